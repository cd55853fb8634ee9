"""The readings of a fingerprint as bytes: 8 a reading, which is what surveys mostly consist of.

Layout, little-endian: format (1 byte), parts (1 byte, bits), number of readings n (4 bytes), then columns: n addresses
of 6 bytes, n RSSI of 2 bytes in hundredths of a dB. Each bit of `parts` announces one further column behind these:
bit 1 the upper 2 bytes of each address, which only keys of beacons have; no other bit is in use.
"""

from __future__ import annotations

import struct

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.wifi.beacons import MARK

FORMAT = 1
UNITS_PER_DB = 100.0
_HEAD = struct.Struct("<BBI")
_ADDRESS_BYTES = 6
_UPPER_BYTES = 2
_READING_BYTES = _ADDRESS_BYTES + 2
_UPPER = 1 << 1


def pack_readings(bssid: IntArray, rssi_dbm: FloatArray) -> bytes:
    """Readings as bytes.

    Parameters
    ----------
    bssid : (n,) 48-bit addresses, or keys of beacons.  rssi_dbm : (n,) within +-327 dBm; kept to a hundredth.

    Raises
    ------
    ValueError : lengths differ, an address or a level does not fit.
    """
    if bssid.shape != rssi_dbm.shape or bssid.ndim != 1:
        raise ValueError(f"bssid {bssid.shape} and rssi_dbm {rssi_dbm.shape} must be columns of one length")
    if np.any(bssid < 0) or np.any((bssid >= 1 << 48) & (bssid < MARK)):
        raise ValueError("a bssid must be a 48-bit address or the key of a beacon")
    units = np.rint(rssi_dbm * UNITS_PER_DB)
    if not np.all(np.abs(units) < 1 << 15):
        raise ValueError("rssi_dbm must be finite and within +-327 dBm")
    octets = bssid.astype("<i8").view(np.uint8).reshape(-1, 8)
    lower, upper = octets[:, :_ADDRESS_BYTES], octets[:, _ADDRESS_BYTES:]
    parts = _UPPER if upper.any() else 0
    packed = _HEAD.pack(FORMAT, parts, len(bssid)) + lower.tobytes() + units.astype("<i2").tobytes()
    return packed + upper.tobytes() if parts else packed


def unpack_readings(packed: bytes) -> tuple[IntArray, FloatArray]:
    """bssid and rssi_dbm, both (n,), of pack_readings.

    Raises
    ------
    ValueError : the bytes are of another format, or damaged.
    """
    if len(packed) < _HEAD.size:
        raise ValueError(f"packed readings of {len(packed)} bytes are cut short")
    layout, parts, count = _HEAD.unpack_from(packed)
    if layout != FORMAT or parts & ~_UPPER:
        raise ValueError(f"packed readings of format {layout}, parts {parts} are not known here")
    split, behind = _HEAD.size + count * _ADDRESS_BYTES, _HEAD.size + count * _READING_BYTES
    end = behind + (count * _UPPER_BYTES if parts else 0)
    if len(packed) != end:
        raise ValueError(f"{count} packed readings take {end} bytes, not {len(packed)}")
    bytes_of = np.zeros((count, 8), np.uint8)
    bytes_of[:, :_ADDRESS_BYTES] = np.frombuffer(packed, np.uint8, split - _HEAD.size, _HEAD.size).reshape(
        count, _ADDRESS_BYTES
    )
    if parts:
        bytes_of[:, _ADDRESS_BYTES:] = np.frombuffer(packed, np.uint8, end - behind, behind).reshape(
            count, _UPPER_BYTES
        )
    bssid = bytes_of.view("<i8").reshape(count).astype(np.int64)
    return bssid, np.frombuffer(packed, "<i2", count, split) / UNITS_PER_DB
