from __future__ import annotations

import io

from PIL import Image

from app.services.resurvey_overlay import overlaid

CANVASES = {"F1": {"pixels": [20.0, 10.0, 120.0, 60.0], "frame": [-5.0, 0.0, 45.0, 25.0]}}
"""Two pixels a metre; north is up."""


def picture() -> bytes:
    written = io.BytesIO()
    Image.new("RGB", (140, 80), "white").save(written, "PNG")
    return written.getvalue()


def drawn(*squares: dict[str, object]) -> Image.Image:
    return Image.open(io.BytesIO(overlaid(picture(), CANVASES, squares)))


def coloured(image: Image.Image) -> tuple[int, int, int, int] | None:
    """Left, top, right and bottom of what is not white."""
    return Image.eval(image.convert("L"), lambda level: 255 * (level < 250)).getbbox()


def test_a_square_is_drawn_where_it_is_on_the_plan() -> None:
    box = coloured(drawn({"floor": "F1", "x": 20.0, "y": 10.0, "size": 10.0}))
    assert box == (60, 30, 81, 51)  # 15 to 25 m east, 5 to 15 m north


def test_what_is_beneath_stays_visible() -> None:
    inside = drawn({"floor": "F1", "x": 20.0, "y": 10.0, "size": 10.0}).getpixel((70, 40))
    assert isinstance(inside, tuple) and inside != (255, 255, 255) and min(inside) > 150


def test_no_square_reaches_beyond_the_panel_of_its_floor() -> None:
    box = coloured(drawn({"floor": "F1", "x": -5.0, "y": 25.0, "size": 10.0}))
    assert box == (20, 10, 31, 21)
    assert coloured(drawn({"floor": "F1", "x": -50.0, "y": 10.0, "size": 10.0})) is None


def test_a_floor_that_is_not_in_the_picture_is_left_out() -> None:
    assert coloured(drawn({"floor": "B9", "x": 20.0, "y": 10.0, "size": 10.0})) is None
