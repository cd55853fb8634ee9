"""A corridor so long that nobody at one end hears the other."""

from __future__ import annotations

import numpy as np

from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import RadioMap, build_radio_map

PLACES_M = np.arange(0.0, 200.0, 5.0)
ACCESS_POINTS = np.repeat(np.arange(len(PLACES_M), dtype=np.int64) * 16, 4) + np.tile(np.arange(4), len(PLACES_M))
"""Four at every fifth metre of a long corridor."""
AT_M = np.repeat(PLACES_M, 4)


def heard(x_m: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """What a phone hears: everything within 25 m, at a level that falls by 2 dB a metre."""
    rng = np.random.default_rng([seed, int(10.0 * x_m)])
    near = np.abs(AT_M - x_m) < 25.0
    return ACCESS_POINTS[near], -40.0 - 2.0 * np.abs(AT_M - x_m)[near] + rng.normal(0.0, 1.0, int(near.sum()))


def surveyed() -> RadioMap:
    return build_radio_map([Fingerprint("F1", float(x), 0.0, 0.0, "walk", *heard(float(x))) for x in range(0, 200, 2)])


MAP = surveyed()


def mixed(x_m: float, far_m: float, count: int, loud_db: float = 30.0) -> tuple[np.ndarray, np.ndarray]:
    """A scan with so many access points of a far place in it, louder than its own."""
    bssid, rssi_dbm = heard(x_m)
    other, level_dbm = heard(far_m, seed=1)
    loudest = np.argsort(-level_dbm)[:count]
    return np.concatenate([bssid, other[loudest]]), np.concatenate([rssi_dbm - loud_db, level_dbm[loudest]])
