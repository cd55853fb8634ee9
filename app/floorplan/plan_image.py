"""A floor's raster plan: whether bytes are a whole PNG of a size that can be shown."""

from __future__ import annotations

import struct
import zlib

from app.errors import InvalidInput, TooLarge

LARGEST_SIDE_PX = 20_000
LARGEST_AREA_PX = 100_000_000
SIGNATURE = b"\x89PNG\r\n\x1a\n"
_BIT_DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
"""Of each colour type (PNG 1.2, 4.1.1)."""
MOST_CHUNKS = 25_000
"""Writers make one of every 8 kB or more."""
_FRAME_BYTES = 12
"""Of a chunk, beside its data: length, name, checksum."""


def refuse_unusable_png(body: bytes) -> None:
    """Nothing, of a PNG whose chunks are all there and undamaged; its pixels are not decompressed.

    Raises
    ------
    InvalidInput : not a PNG, or a damaged one.
    TooLarge : more pixels than a browser should be asked to show, or more chunks than are looked at.
    """
    if not body.startswith(SIGNATURE):
        raise InvalidInput("the body is not a PNG image")
    at, header = len(SIGNATURE), b""
    names: list[bytes] = []
    while at < len(body):
        if len(names) >= MOST_CHUNKS:
            raise TooLarge(f"the PNG has more than {MOST_CHUNKS} chunks; write it anew with larger ones")
        if len(body) - at < _FRAME_BYTES:
            raise InvalidInput("the PNG ends too early")
        length, name = struct.unpack_from(">I4s", body, at)
        end = at + _FRAME_BYTES + length
        if end > len(body):
            raise InvalidInput("the PNG ends too early")
        (checksum,) = struct.unpack_from(">I", body, end - 4)
        if zlib.crc32(memoryview(body)[at + 4 : end - 4]) != checksum:
            raise InvalidInput(f"the PNG is damaged: the checksum of chunk {len(names)} is wrong")
        if not names:
            header = body[at + 8 : end - 4]
        names.append(name)
        at = end
        if name == b"IEND":
            break
    if not names or names[0] != b"IHDR" or names[-1] != b"IEND" or b"IDAT" not in names:
        raise InvalidInput("the PNG ends too early or lacks its header")
    _refuse_unusable_header(header)


def _refuse_unusable_header(header: bytes) -> None:
    if len(header) != 13:
        raise InvalidInput("the header of the PNG is damaged")
    width, height, depth, colour, compression, filtering, interlace = struct.unpack(">IIBBBBB", header)
    known = depth in _BIT_DEPTHS.get(colour, ()) and compression == filtering == 0 and interlace in (0, 1)
    if not known or width == 0 or height == 0:
        raise InvalidInput("the header of the PNG is damaged")
    if max(width, height) > LARGEST_SIDE_PX or width * height > LARGEST_AREA_PX:
        raise TooLarge(f"{width} x {height} pixels; at most {LARGEST_SIDE_PX} a side, {LARGEST_AREA_PX:,} in all")
