"""Readings of Bluetooth beacons until they make a fix: phones report them one by one, or in scans of any length."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.fusion.state_codec import storable
from app.observations import BluetoothScan
from app.wifi.beacons import beacon_key, heard_beacons

PACE_S = 1.5
"""At least so long between fixes: what arrives faster is read together."""
KEPT_S = 4.0
"""Readings that waited longer belong to another place."""
MOST_KEPT = 1000
"""Readings waiting; no place has more, and they are in every session's state."""


def _none() -> FloatArray:
    return np.empty(0)


@storable
@dataclass(frozen=True, slots=True, eq=False)
class BeaconEar:
    """time_s, key, rssi_dbm : (n,) readings that no fix was made of yet.  fixed_s : when the last one was made.
    placed_s : newest fix that was believed.  contradictions : fixes in a row, while there was no WiFi, that were not.
    """

    time_s: FloatArray = field(default_factory=_none)
    key: IntArray = field(default_factory=lambda: np.empty(0, np.int64))
    rssi_dbm: FloatArray = field(default_factory=_none)
    fixed_s: float | None = None
    placed_s: float | None = None
    contradictions: int = 0


def listened(ear: BeaconEar, scan: BluetoothScan, now_s: float) -> tuple[BeaconEar, tuple[IntArray, FloatArray] | None]:
    """Take a scan in.

    Parameters
    ----------
    now_s : when it was delivered.

    Returns
    -------
    The ear after it; and, once PACE_S has passed since the last time, keys (n,) and levels (n,) to make a fix of, each
    beacon once. However the readings were cut into scans of less than PACE_S, they are told in about the same portions.
    """
    heard = np.array([beacon_key(one) for one in scan.beacon], np.int64)
    waiting = ear.time_s >= now_s - KEPT_S
    time_s = np.concatenate([ear.time_s[waiting], np.full(len(heard), now_s)])[-MOST_KEPT:]
    key = np.concatenate([ear.key[waiting], heard])[-MOST_KEPT:]
    rssi_dbm = np.concatenate([ear.rssi_dbm[waiting], scan.rssi_dbm])[-MOST_KEPT:]
    if not len(key) or (ear.fixed_s is not None and now_s < ear.fixed_s + PACE_S):
        return replace(ear, time_s=time_s, key=key, rssi_dbm=rssi_dbm), None
    told = heard_beacons(key, rssi_dbm)
    return replace(ear, time_s=_none(), key=np.empty(0, np.int64), rssi_dbm=_none(), fixed_s=now_s), told
