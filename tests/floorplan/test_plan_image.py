from __future__ import annotations

import io
import struct
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from app.errors import InvalidInput, TooLarge
from app.floorplan.plan_image import MOST_CHUNKS, SIGNATURE, refuse_unusable_png
from tests.open_data import open_data


def png(mode: str = "RGB", size: tuple[int, int] = (7, 5)) -> bytes:
    buffer = io.BytesIO()
    Image.new(mode, size).save(buffer, "PNG")
    return buffer.getvalue()


def chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def made_of(width: int, height: int, depth: int = 8, colour: int = 2, interlace: int = 0, pieces: int = 1) -> bytes:
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, interlace)
    return SIGNATURE + chunk(b"IHDR", header) + pieces * chunk(b"IDAT", b"") + chunk(b"IEND", b"")


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA", "I;16"])
def test_every_kind_of_png_can_be_used(mode: str) -> None:
    refuse_unusable_png(png(mode))


def test_a_real_plan_is_a_whole_png() -> None:
    refuse_unusable_png(open_data("mall", "F1", "floor_image.png").read_bytes())


@given(st.integers(0, len(png()) - 1))
def test_a_png_that_was_cut_off_is_refused(length: int) -> None:
    with pytest.raises(InvalidInput):
        refuse_unusable_png(png()[:length])


@given(st.integers(0, len(png()) - 1), st.integers(1, 255))
def test_a_png_with_a_damaged_byte_is_refused(at: int, change: int) -> None:
    whole = png()
    with pytest.raises(InvalidInput):
        refuse_unusable_png(whole[:at] + bytes([whole[at] ^ change]) + whole[at + 1 :])


@given(st.binary(max_size=200))
def test_anything_else_is_refused(body: bytes) -> None:
    for sent in (body, SIGNATURE + body):
        with pytest.raises(InvalidInput):
            refuse_unusable_png(sent)


@pytest.mark.parametrize(
    "header", [{"width": 0, "height": 5}, {"width": 5, "height": 0}, {"width": 5, "height": 5, "depth": 3}]
)
def test_a_header_that_describes_no_image_is_refused(header: dict[str, int]) -> None:
    with pytest.raises(InvalidInput):
        refuse_unusable_png(made_of(**header))
    for more in ({"colour": 5}, {"interlace": 2}):
        with pytest.raises(InvalidInput):
            refuse_unusable_png(made_of(5, 5, **more))


@pytest.mark.parametrize(("width", "height"), [(20_001, 1), (1, 20_001), (20_000, 20_000), (2**32 - 1, 2**32 - 1)])
def test_more_pixels_than_a_browser_can_show_are_refused(width: int, height: int) -> None:
    with pytest.raises(TooLarge):
        refuse_unusable_png(made_of(width, height))
    refuse_unusable_png(made_of(20_000, 5_000))


def test_an_image_in_more_pieces_than_any_writer_makes_is_too_large() -> None:
    refuse_unusable_png(made_of(5, 5, pieces=MOST_CHUNKS - 2))
    with pytest.raises(TooLarge, match=str(MOST_CHUNKS)):
        refuse_unusable_png(made_of(5, 5, pieces=MOST_CHUNKS - 1))
