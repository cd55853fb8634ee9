"""Survey bodies on their way to disk: limited, decompressed, split into parts, and never held in memory."""

from __future__ import annotations

import asyncio
import zlib
from collections.abc import AsyncIterator
from contextlib import suppress
from pathlib import Path
from typing import IO

from fastapi import Request
from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header
from starlette.requests import ClientDisconnect

from app.api.decoding import JSON_TYPES
from app.errors import InvalidInput, TooLarge, UnsupportedMedia
from app.survey.upload import SurveyFormat, Upload

PIECE_BYTES = 1 << 20
MOST_PARTS = 10_000
DRAINED_BYTES = 64_000_000
"""Rest of a refused body that is read and thrown away: a client that is still sending would miss the answer."""
MULTIPART = "multipart/form-data"
CSV_TYPES = frozenset({"text/csv", "application/csv"})
_GZIP_WBITS = 31


async def receive_upload(request: Request, folder: Path, floor: str | None, limit_bytes: int) -> Upload:
    """Store the body of a survey request in a folder.

    Parameters
    ----------
    floor : of the traces of a multipart body.  limit_bytes : largest body, before and after Content-Encoding.

    Raises
    ------
    UnsupportedMedia : a media type or Content-Encoding that is not read here.
    InvalidInput : the body is cut short, no multipart body, or damaged.
    TooLarge : beyond the limit.
    """
    content_type = request.headers.get("content-type")
    # Latin-1 is how header bytes arrive; a boundary must come out as the bytes that it was
    media_type, options = parse_options_header((content_type or "").encode("latin-1"))
    kind = media_type.decode("latin-1").strip().lower()
    pieces = _pieces(_decoded(_received(request, limit_bytes), request, limit_bytes))
    if kind == MULTIPART:
        if floor is None:
            raise InvalidInput("a survey of traces needs the floor they were walked on: ?floor=...", "floor")
        return await _store_parts(pieces, folder, options.get(b"boundary", b""), floor)
    if kind in JSON_TYPES:
        return await _store_whole(pieces, folder, SurveyFormat.JSON)
    if kind in CSV_TYPES:
        return await _store_whole(pieces, folder, SurveyFormat.CSV)
    raise UnsupportedMedia(
        f"Content-Type {kind[:80]!r} is not read here; a survey is application/json, text/csv or {MULTIPART}"
    )


async def drain(request: Request) -> None:
    """Read what is left of a refused body, within a bound."""
    left = DRAINED_BYTES
    with suppress(ClientDisconnect, RuntimeError):  # gone, or read to its end already
        async for chunk in request.stream():
            left -= len(chunk)
            if left < 0:
                return


async def _received(request: Request, limit_bytes: int) -> AsyncIterator[bytes]:
    size = 0
    try:
        async for chunk in request.stream():
            size += len(chunk)
            if size > limit_bytes:
                raise _too_large(limit_bytes)
            yield chunk
    except ClientDisconnect as error:
        raise InvalidInput("the body ended early") from error


async def _decoded(chunks: AsyncIterator[bytes], request: Request, limit_bytes: int) -> AsyncIterator[bytes]:
    encoding = request.headers.get("content-encoding", "").strip().lower()
    if encoding in ("", "identity"):
        async for chunk in chunks:
            yield chunk
        return
    if encoding not in ("gzip", "x-gzip"):
        raise UnsupportedMedia(f"Content-Encoding {encoding[:80]!r} is not read here; a survey may be sent as gzip")
    size, member = 0, zlib.decompressobj(_GZIP_WBITS)
    async for chunk in chunks:
        rest, more = chunk, False
        while rest or more:
            if member.eof:  # members may follow one another
                member = zlib.decompressobj(_GZIP_WBITS)
            try:
                plain = member.decompress(rest, PIECE_BYTES)
            except zlib.error as error:
                raise InvalidInput(f"the body is not gzip: {error}") from error
            rest = member.unused_data if member.eof else member.unconsumed_tail
            more = not member.eof and len(plain) == PIECE_BYTES
            size += len(plain)
            if size > limit_bytes:
                raise _too_large(limit_bytes)
            yield plain
    if not member.eof:
        raise InvalidInput("the gzip body ends too early")


async def _pieces(chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
    """The same bytes in pieces worth a thread each."""
    gathered, size = [], 0
    async for chunk in chunks:
        gathered.append(chunk)
        size += len(chunk)
        if size >= PIECE_BYTES:
            yield b"".join(gathered)
            gathered, size = [], 0
    yield b"".join(gathered)


async def _store_whole(pieces: AsyncIterator[bytes], folder: Path, kind: SurveyFormat) -> Upload:
    path = folder / "body"
    with path.open("wb") as file:
        async for piece in pieces:
            await asyncio.to_thread(file.write, piece)
    return Upload(kind, (("body", path),))


async def _store_parts(pieces: AsyncIterator[bytes], folder: Path, boundary: bytes, floor: str) -> Upload:
    if not boundary:
        raise InvalidInput("the Content-Type of a multipart body must name its boundary", "files")
    parts = _Parts(folder)
    try:
        parser = MultipartParser(boundary, parts.callbacks())  # type: ignore[arg-type]
        async for piece in pieces:
            await asyncio.to_thread(parser.write, piece)
    except FormParserError as error:
        raise InvalidInput(
            f"the body is no multipart body with the boundary of its header: {error}", "files"
        ) from error
    finally:
        parts.close()
    if not parts.ended:
        raise InvalidInput("the multipart body ends before its closing boundary", "files")
    if not parts.files:
        raise InvalidInput("a survey of traces needs parts named files, one trace each", "files")
    return Upload(SurveyFormat.TRACES, tuple(parts.files), floor)


class _Parts:
    """Files that a multipart parser finds, written as they come."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._field, self._value = b"", b""
        self._disposition = b""
        self._open: IO[bytes] | None = None
        self.files: list[tuple[str, Path]] = []
        self.ended = False

    def callbacks(self) -> dict[str, object]:
        return {f"on_{name}": getattr(self, f"_{name}") for name in _CALLBACKS}

    def close(self) -> None:
        if self._open is not None:
            self._open.close()

    def _part_begin(self) -> None:
        self._disposition = b""

    def _header_field(self, data: bytes, start: int, end: int) -> None:
        self._field += data[start:end]

    def _header_value(self, data: bytes, start: int, end: int) -> None:
        self._value += data[start:end]

    def _header_end(self) -> None:
        if self._field.lower() == b"content-disposition":
            self._disposition = self._value
        self._field, self._value = b"", b""

    def _headers_finished(self) -> None:
        _, options = parse_options_header(self._disposition)
        name = options.get(b"name", b"").decode("utf-8", "replace")
        if name != "files":
            raise InvalidInput(
                f"a part named {name[:64]!r} is not known here: a trace is a part named files", name[:64]
            )
        if len(self.files) >= MOST_PARTS:
            raise TooLarge(f"more than {MOST_PARTS} files in one survey; send several", "files")
        path = self._folder / str(len(self.files))
        self.files.append((_file_name(options.get(b"filename", b""), len(self.files)), path))
        self._open = path.open("wb")

    def _part_data(self, data: bytes, start: int, end: int) -> None:
        assert self._open is not None  # data follow headers
        self._open.write(memoryview(data)[start:end])

    def _part_end(self) -> None:
        self.close()

    def _end(self) -> None:
        self.ended = True


_CALLBACKS = (
    *("part_begin", "header_field", "header_value", "header_end"),
    *("headers_finished", "part_data", "part_end", "end"),
)


def _file_name(sent: bytes, index: int) -> str:
    """The name without the folders that some clients send; never used as a path."""
    name = sent.decode("utf-8", "replace").replace("\\", "/").rsplit("/", 1)[-1]
    return "".join(filter(str.isprintable, name)) or f"file-{index + 1}"


def _too_large(limit_bytes: int) -> TooLarge:
    return TooLarge(f"the survey is larger than {limit_bytes} bytes; send it in several")
