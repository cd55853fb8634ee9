"""Fingerprints in a file on their way between processes: what is read piece by piece is never held as a whole.

A row is what the table of fingerprints holds, the floor by its name; rows follow one another, each behind its length.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import IO

import ormsgpack

from app.wifi.fingerprint import Fingerprint
from app.wifi.fingerprint_codec import pack_readings, unpack_readings

Row = tuple[str, str, float, float, float, bytes]
"""floor, walk, time_s, x_m, y_m, packed readings."""
_LENGTH = struct.Struct("<I")


def row_of(fingerprint: Fingerprint) -> Row:
    """A fingerprint as it is stored."""
    readings = pack_readings(fingerprint.bssid, fingerprint.rssi_dbm)
    return fingerprint.floor, fingerprint.walk, fingerprint.time_s, fingerprint.x_m, fingerprint.y_m, readings


def fingerprint_of(row: Row) -> Fingerprint:
    """The inverse of row_of."""
    floor, walk, time_s, x_m, y_m, readings = row
    bssid, rssi_dbm = unpack_readings(readings)
    return Fingerprint(floor, x_m, y_m, time_s, walk, bssid, rssi_dbm)


def write_row(stream: IO[bytes], row: Row) -> None:
    """Append a row."""
    packed = ormsgpack.packb(row)
    stream.write(_LENGTH.pack(len(packed)))
    stream.write(packed)


def read_rows(stream: IO[bytes]) -> Iterator[Row]:
    """The rows of a stream from where it stands.

    Raises
    ------
    ValueError : it ends within a row.
    """
    while head := stream.read(_LENGTH.size):
        if len(head) < _LENGTH.size:
            raise ValueError("it ends within the length of a row")
        packed = stream.read(_LENGTH.unpack(head)[0])
        floor, walk, time_s, x_m, y_m, readings = ormsgpack.unpackb(packed)
        yield floor, walk, time_s, x_m, y_m, readings
