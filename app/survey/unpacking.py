"""Files as they are sent: plain, gzip, xz or a zip of those, told from the content and never trusted in size."""

from __future__ import annotations

import gzip
import io
import lzma
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import IO, Protocol

from app.errors import InvalidInput, TooLarge

FILE_LIMIT_BYTES = 256_000_000
"""Largest single file after decompression: some three hours of a phone's log."""
TOTAL_LIMIT_BYTES = 20_000_000_000
"""Most that all files of one survey may come to: what a bomb of bombs may cost."""
MEMBERS_LIMIT = 10_000
"""Most files in one zip."""
XZ_MEMORY_LIMIT_BYTES = 128_000_000
"""Dictionary memory a stream may ask for; `xz -9` needs 65 MB."""

_DAMAGED = (
    lzma.LZMAError,
    zlib.error,
    gzip.BadGzipFile,
    zipfile.BadZipFile,
    EOFError,
    NotImplementedError,  # a zip by an unknown method
    RuntimeError,  # an encrypted zip
    ValueError,
    struct.error,
)


@dataclass(slots=True)
class Allowance:
    """What unpacking may cost. left_bytes falls with every byte that comes out."""

    file_bytes: int = FILE_LIMIT_BYTES
    left_bytes: int = TOTAL_LIMIT_BYTES


class _Readable(Protocol):
    def read(self, size: int, /) -> bytes: ...


class _Bounded(io.RawIOBase):
    """Reads through to a stream until it has given more than the limit."""

    def __init__(self, stream: _Readable, name: str, allowance: Allowance) -> None:
        self._stream, self._name, self._allowance, self._given_bytes = stream, name, allowance, 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]
        data = self._stream.read(len(buffer))
        self._given_bytes += len(data)
        self._allowance.left_bytes -= len(data)
        if self._given_bytes > self._allowance.file_bytes or self._allowance.left_bytes < 0:
            raise TooLarge(f"{self._name}: more than {self._given_bytes - 1} bytes after decompression", self._name)
        buffer[: len(data)] = data
        return len(data)


@contextmanager
def damage_named(name: str) -> Iterator[None]:
    """Turns what decoders raise on damaged bytes, now or while reading, into InvalidInput that names the file."""
    try:
        yield
    except _DAMAGED as error:
        raise InvalidInput(
            f"{name}: the file is damaged or cut short ({str(error) or type(error).__name__})", name
        ) from error


def unpacked(stream: IO[bytes], name: str, allowance: Allowance) -> Iterator[tuple[str, IO[bytes]]]:
    """Every file inside a stream, with its name; read each before asking for the next.

    Parameters
    ----------
    stream : seekable, at its start.
    name : of the file, for messages. Members of a zip are named by their own path.

    Raises
    ------
    InvalidInput : a damaged or encrypted archive, TooLarge one beyond a bound; also raised while reading what was
        yielded, inside `damage_named`.
    """
    yield from _unpacked(stream, name, allowance, nested=False)


def _unpacked(stream: IO[bytes], name: str, allowance: Allowance, nested: bool) -> Iterator[tuple[str, IO[bytes]]]:
    magic = stream.read(6)
    stream.seek(0)
    if magic.startswith(b"PK\x03\x04") or magic.startswith(b"PK\x05\x06"):
        if nested:
            raise InvalidInput(f"{name}: a zip inside a zip is not read", name)
        with damage_named(name), zipfile.ZipFile(stream) as archive:
            members = [m for m in archive.infolist() if not m.is_dir() and not _is_rubbish(m.filename)]
        if len(members) > MEMBERS_LIMIT:
            raise TooLarge(f"{name}: more than {MEMBERS_LIMIT} files in one zip", name)
        for member in members:
            with damage_named(member.filename):
                content = _member(stream, member, allowance)
            yield from _unpacked(content, member.filename, allowance, nested=True)
    elif magic.startswith(b"\x1f\x8b"):
        yield name, _bounded(gzip.GzipFile(fileobj=stream), name, allowance)
    elif magic == b"\xfd7zXZ\x00":
        yield name, _bounded(_XzStream(stream), name, allowance)
    else:
        yield name, _bounded(stream, name, allowance)


def _member(stream: IO[bytes], member: zipfile.ZipInfo, allowance: Allowance) -> IO[bytes]:
    with zipfile.ZipFile(stream) as archive, archive.open(member) as opened:
        return io.BytesIO(_bounded(opened, member.filename, allowance).read())


def _bounded(stream: _Readable, name: str, allowance: Allowance) -> io.BufferedReader:
    return io.BufferedReader(_Bounded(stream, name, allowance), 1 << 16)


def _is_rubbish(path: str) -> bool:
    """Resource forks and the like that desktop zip tools add unasked."""
    return path.startswith("__MACOSX/") or path.rsplit("/", 1)[-1].startswith(".")


class _XzStream:
    """An xz stream decompressed with bounded memory (lzma.LZMAFile takes no memory limit)."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._decoder = lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=XZ_MEMORY_LIMIT_BYTES)

    def read(self, size: int, /) -> bytes:
        while True:
            if self._decoder.eof:  # several streams may follow one another, padded with zeros
                rest = (self._decoder.unused_data or self._stream.read(1 << 16)).lstrip(b"\0")
                if not rest:
                    return b""
                self._decoder = lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=XZ_MEMORY_LIMIT_BYTES)
            elif self._decoder.needs_input:
                rest = self._stream.read(1 << 16)
                if not rest:
                    raise EOFError("compressed data ended before the end of the stream")
            else:
                rest = b""
            data = self._decoder.decompress(rest, max_length=size)
            if data:
                return data
