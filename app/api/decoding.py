"""Request bodies as they travel: limited in size, decompressed, their media type told apart."""

from __future__ import annotations

import asyncio
import io
import re
import zlib
from enum import StrEnum

import zstandard
from fastapi import Request
from starlette.requests import ClientDisconnect

from app.errors import InvalidInput, TooLarge, UnsupportedMedia

JSON_TYPES = frozenset({"", "application/json"})
"""The empty one: a client that does not say."""
MSGPACK_TYPES = frozenset({"application/msgpack", "application/x-msgpack", "application/vnd.msgpack"})
ZSTD_WINDOW_BYTES = 8 << 20
"""What RFC 9659 lets a sender assume; a larger window is a way to take memory."""
LITTLE_BYTES = 4_000
"""Of a compressed body: up to there it is decompressed at once. What may hold a thousand times more keeps no phone
waiting.
"""
MOST_MEMBERS = 1000
"""Of a gzip body. Senders that compress in blocks make one every 64 kB; a million empty ones only take time."""
_WEIGHT = re.compile(r"[01](\.[0-9]{0,3})?")
_GZIP_WBITS, _PIECE_BYTES = 31, 1 << 16


class Packing(StrEnum):
    """How a body is laid out."""

    JSON = "application/json"
    MSGPACK = "application/msgpack"


def packing_of(content_type: str | None) -> Packing:
    """The layout that a Content-Type announces.

    Raises
    ------
    UnsupportedMedia : anything but JSON and MessagePack.
    """
    media_type = (content_type or "").partition(";")[0].strip().lower()
    if media_type in JSON_TYPES:
        return Packing.JSON
    if media_type in MSGPACK_TYPES:
        return Packing.MSGPACK
    raise UnsupportedMedia(
        f"Content-Type {media_type[:80]!r} is not read here; send application/json or application/msgpack"
    )


def prefers(accept: str, wanted: str, otherwise: str) -> bool:
    """Whether an Accept header names a media type, and gives it a weight above 0 and not below that of another."""
    weights = {}
    for one in accept.lower().split(","):
        media_type, *parameters = (part.strip() for part in one.split(";"))
        said = next((part[2:] for part in parameters if part.startswith("q=")), "")
        weights[media_type] = float(said) if _WEIGHT.fullmatch(said) else 1.0
    return weights.get(wanted, 0.0) > 0.0 and weights[wanted] >= weights.get(otherwise, 0.0)


async def read_body(request: Request, limit_bytes: int) -> bytes:
    """The body of a request, decompressed, at most limit_bytes long before and after.

    Raises
    ------
    UnsupportedMedia : the Content-Encoding is neither gzip nor zstd.
    InvalidInput : the compressed data are damaged.
    TooLarge : more than limit_bytes.
    """
    encoding = request.headers.get("content-encoding", "").strip().lower()
    parts, size = [], 0
    try:
        async for part in request.stream():
            size += len(part)
            if size > limit_bytes:
                raise _too_large(limit_bytes)
            parts.append(part)
    except ClientDisconnect as error:
        raise InvalidInput("the body ended early") from error
    sent = b"".join(parts)
    if len(sent) < LITTLE_BYTES or encoding in ("", "identity"):
        return decompress(sent, encoding, limit_bytes)
    return await asyncio.to_thread(decompress, sent, encoding, limit_bytes)


def decompress(sent: bytes, encoding: str, limit_bytes: int) -> bytes:
    """What was compressed, never more than limit_bytes of it in memory. Raises as read_body does."""
    match encoding:
        case "" | "identity":
            return sent
        case "gzip" | "x-gzip":
            return _gunzip(sent, limit_bytes)
        case "zstd":
            return _unzstd(sent, limit_bytes)
    raise UnsupportedMedia(f"Content-Encoding {encoding[:80]!r} is not read here; send gzip, zstd or none")


def _gunzip(sent: bytes, limit_bytes: int) -> bytes:
    parts, size, begin = [], 0, 0
    for _ in range(MOST_MEMBERS):
        member = zlib.decompressobj(_GZIP_WBITS)
        while not member.eof:  # in pieces, since what follows a member is copied with every call
            piece = sent[begin : begin + _PIECE_BYTES]
            if not piece:
                raise InvalidInput("the gzip body ends too early")
            try:
                part = member.decompress(piece, limit_bytes - size + 1)
            except zlib.error as error:
                raise InvalidInput(f"the body is not gzip: {error}") from error
            size += len(part)
            if size > limit_bytes:
                raise _too_large(limit_bytes)
            parts.append(part)
            begin += len(piece) - len(member.unused_data)
        if begin == len(sent):
            return b"".join(parts)
    raise InvalidInput(f"the gzip body has more than {MOST_MEMBERS} members")


def _unzstd(sent: bytes, limit_bytes: int) -> bytes:
    decompressor = zstandard.ZstdDecompressor(max_window_size=ZSTD_WINDOW_BYTES)
    member = decompressor.stream_reader(io.BytesIO(sent), read_across_frames=True)
    try:
        plain = member.read(limit_bytes + 1)  # of a truncated frame what is there: no JSON or MessagePack survives that
    except zstandard.ZstdError as error:
        raise InvalidInput(f"the body is not zstd: {error}") from error
    if len(plain) > limit_bytes:
        raise _too_large(limit_bytes)
    return plain


def _too_large(limit_bytes: int) -> TooLarge:
    return TooLarge(f"the body is larger than {limit_bytes} bytes, the most that is read here")
