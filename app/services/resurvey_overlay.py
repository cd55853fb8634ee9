"""Draws where to survey again over the picture of a quality report, as of the moment in which it is asked for."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from PIL import Image, ImageColor, ImageDraw

LINE = 3
RESURVEY = "#cc79a7"
"""As the picture's legend has it."""
_FILL = (*ImageColor.getrgb(RESURVEY), 0x66)


def overlaid(
    picture: bytes, canvases: Mapping[str, Mapping[str, Sequence[float]]], squares: Iterable[Mapping[str, Any]]
) -> bytes:
    """The picture with squares drawn into it.

    Parameters
    ----------
    picture : PNG.  canvases : by floor, where on the picture (`pixels`: left, top, right, bottom) which part of the
    floor is (`frame`: west, south, east, north, m).  squares : `floor`, centre `x` and `y`, and `size`, m.
    """
    image = Image.open(io.BytesIO(picture)).convert("RGBA")
    layer = Image.new("RGBA", image.size, (0, 0, 0, 0))
    draw = ImageDraw.Draw(layer)
    for one in squares:
        canvas = canvases.get(one["floor"])
        if canvas is None:
            continue
        (left, top, right, bottom), (west, south, east, north) = canvas["pixels"], canvas["frame"]
        across, up = (right - left) / (east - west), (bottom - top) / (north - south)
        x, y, half = left + (one["x"] - west) * across, bottom - (one["y"] - south) * up, one["size"] / 2.0
        # the outermost squares may reach beyond the frame, and the panel ends there
        box = (
            max(x - half * across, left),
            max(y - half * up, top),
            min(x + half * across, right),
            min(y + half * up, bottom),
        )
        if box[0] < box[2] and box[1] < box[3]:
            draw.rectangle(box, fill=_FILL, outline=RESURVEY, width=LINE)
    written = io.BytesIO()
    Image.alpha_composite(image, layer).convert("RGB").save(written, "PNG")
    return written.getvalue()
