"""A radio map as bytes: what the database stores. Arrays and their names, zstd-compressed, nothing that executes.

Layout: MAGIC, then a zstd frame with checksum of: length of the table of contents (4 bytes, little-endian), the table
(JSON), and the arrays' bytes in its order; the table of a map with beacons holds theirs under `beacons`, and their
arrays follow.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np
import orjson
import zstandard
from numpy.typing import NDArray

from app.wifi.radio_map import RadioMap

MAGIC: Final = b"SFRM\x01"
"""Four letters and the number of the layout."""
LARGEST_BYTES: Final = 2 << 30
_LEVEL = 6
_KINDS: Final[Mapping[str, type[np.generic]]] = {
    "bssid": np.int64,
    "floor": np.int32,
    "xy_m": np.float64,
    "scans": np.int32,
    "start": np.int64,
    "point": np.int32,
    "count": np.int32,
    "mean_dbm": np.float32,
    "variance_db2": np.float32,
}
_ALLOWED = frozenset(f"<{kind}" for kind in ("f4", "f8", "i2", "i4", "i8", "u2", "u4", "u8")) | {"|i1", "|u1", "|b1"}


class DamagedRadioMapError(ValueError):
    """Bytes that are no radio map of this layout."""


def encode_radio_map(radio_map: RadioMap) -> bytes:
    """Bytes that decode_radio_map turns back, sections included. The same map gives the same bytes.

    Raises
    ------
    ValueError : a section of another kind than numbers.
    """
    table, parts = _contents(radio_map)
    if radio_map.beacons is not None:
        table["beacons"], arrays = _contents(radio_map.beacons)
        parts += arrays
    head = orjson.dumps(table)
    compressor = zstandard.ZstdCompressor(level=_LEVEL, write_checksum=True)
    return MAGIC + compressor.compress(b"".join([len(head).to_bytes(4, "little"), head, *parts]))


def _contents(radio_map: RadioMap) -> tuple[dict[str, Any], list[bytes]]:
    """A map's part of the table, and its arrays' bytes; without its beacons."""
    arrays = {name: np.ascontiguousarray(getattr(radio_map, name)) for name in _KINDS}
    sections = {name: np.ascontiguousarray(radio_map.sections[name]) for name in sorted(radio_map.sections)}
    for name, array in sections.items():
        if array.dtype.str not in _ALLOWED:
            raise ValueError(f"section {name} holds {array.dtype}: only little-endian numbers can be stored")
    table = {
        "version": radio_map.version,
        "floors": list(radio_map.floors),
        "arrays": [_entry(name, array) for name, array in arrays.items()],
        "sections": [_entry(name, array) for name, array in sections.items()],
    }
    return table, [array.tobytes() for array in (*arrays.values(), *sections.values())]


def decode_radio_map(body: bytes) -> RadioMap:
    """The map of encode_radio_map.

    Raises
    ------
    DamagedRadioMapError : not a radio map, of a layout that is not read here, or damaged.
    """
    if body[: len(MAGIC)] != MAGIC:
        raise DamagedRadioMapError("not a radio map, or one of a layout that is not read here")
    content = _decompressed(body[len(MAGIC) :])
    try:
        size = int.from_bytes(content[:4], "little")
        table = orjson.loads(content[4 : 4 + size])
        radio_map, end = _map(table, content, 4 + size)
        if "beacons" in table:
            beacons, end = _map(table["beacons"], content, end)
            if beacons.floors != radio_map.floors:
                raise DamagedRadioMapError("the radio map and its beacons are of different floors")
            radio_map = replace(radio_map, beacons=beacons)
    except DamagedRadioMapError:
        raise
    except (ValueError, KeyError, TypeError) as error:
        raise DamagedRadioMapError(f"the radio map's table of contents is damaged: {error!r}") from error
    if end != len(content):
        raise DamagedRadioMapError("the radio map is longer or shorter than its table of contents says")
    return radio_map


def _map(table: Any, content: bytes, at: int) -> tuple[RadioMap, int]:
    """The map that a table describes, its arrays read from `at` on, and where they end."""
    floors = tuple(str(name) for name in table["floors"])
    version = int(table["version"])
    arrays, end = _arrays(table["arrays"], content, at)
    sections, end = _arrays(table["sections"], content, end)
    _check(arrays, len(floors))
    return RadioMap(version=version, floors=floors, **arrays, sections=sections, beacons=None), end


def _entry(name: str, array: NDArray[Any]) -> dict[str, Any]:
    return {"name": name, "kind": array.dtype.str, "shape": list(array.shape)}


def _decompressed(frame: bytes) -> bytes:
    try:
        size = zstandard.get_frame_parameters(frame).content_size
        if size > LARGEST_BYTES:
            raise DamagedRadioMapError(f"the radio map claims {size} bytes")
        return zstandard.ZstdDecompressor().decompress(frame)
    except zstandard.ZstdError as error:
        raise DamagedRadioMapError(f"the radio map is damaged: {error}") from error


def _arrays(entries: list[Any], content: bytes, at: int) -> tuple[dict[str, NDArray[Any]], int]:
    """Arrays by name, read from `at` on, and where they end."""
    found = {}
    for entry in entries:
        if entry["kind"] not in _ALLOWED:
            raise ValueError(f"kind {entry['kind']!r}")
        shape = tuple(int(side) for side in entry["shape"])
        if any(side < 0 for side in shape):
            raise ValueError(f"shape {shape}")
        kind, items = np.dtype(entry["kind"]), math.prod(shape)
        # copied: what is read-only or not aligned would be another type to compiled matchers
        array = np.frombuffer(content, kind, items, at).copy() if items else np.empty(0, kind)
        found[str(entry["name"])] = array.reshape(shape)
        at += items * kind.itemsize
    return found, at


def _check(arrays: Mapping[str, NDArray[Any]], floors: int) -> None:
    """Raise DamagedRadioMapError unless the arrays fit each other: compiled matchers index with them unchecked."""
    if {name: array.dtype for name, array in arrays.items()} != {name: np.dtype(kind) for name, kind in _KINDS.items()}:
        raise DamagedRadioMapError("the radio map's arrays are not those of this layout")
    points, pairs, start = len(arrays["scans"]), len(arrays["point"]), arrays["start"]
    lengths = {"floor": (points,), "scans": (points,), "xy_m": (points, 2), "start": (len(arrays["bssid"]) + 1,)}
    lengths |= dict.fromkeys(("point", "count", "mean_dbm", "variance_db2"), (pairs,))
    if arrays["bssid"].ndim != 1 or any(arrays[name].shape != shape for name, shape in lengths.items()):
        raise DamagedRadioMapError("the radio map's arrays differ in length")
    if start[0] != 0 or start[-1] != pairs or (np.diff(start) < 0).any() or (np.diff(arrays["bssid"]) <= 0).any():
        raise DamagedRadioMapError("the radio map's access points are out of order")
    for name, least, beyond in (("floor", 0, floors), ("point", 0, points), ("scans", 1, None), ("count", 1, None)):
        array = arrays[name]
        if len(array) and (array.min() < least or (beyond is not None and array.max() >= beyond)):
            raise DamagedRadioMapError(f"the radio map's {name} is out of range")
    if not all(np.isfinite(arrays[name]).all() for name in ("xy_m", "mean_dbm", "variance_db2")):
        raise DamagedRadioMapError("the radio map holds values that are not finite")
