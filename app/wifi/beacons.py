"""Bluetooth beacons in the key space of access points: what arrays hold instead of text, and how scans are compared.

An access point's key is its 48-bit address, a beacon's a hash of its identifier above all of those. So fingerprints,
maps and matchers hold both alike; which readings are of which radio shows in the key.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from hashlib import blake2b

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.wifi.fingerprint import Fingerprint
from app.wifi.representation import SQUARED
from app.wifi.signal_distance import Distance
from app.wifi.soft_match import SoftSettings

MARK = 1 << 62
"""Of every beacon's key, and of no address."""
LISTENING_S = 2.0
"""Readings of so long make a scan: phones report beacons one by one. Alone on the mall walks of folds 1-4 scans of 1, 2
and 4 s err by 10.9, 9.1 and 7.8 m; on the move a longer one is of several places."""
BEACON_MATCH = SoftSettings(SQUARED, softness=0.03, distance=Distance.SORENSEN, separated=False, few_known=0.0)
"""Often a single beacon is heard; the cosine of one number is 1 whatever its level, this distance is not."""


@lru_cache(1 << 16)
def beacon_key(beacon: str) -> int:
    """The key of `uuid:major:minor`, or whatever else identifies a beacon; upper and lower case are the same."""
    digest = blake2b(beacon.lower().encode("utf-8", "surrogatepass"), digest_size=8).digest()
    return MARK | (int.from_bytes(digest, "little") & (MARK - 1))


def heard_beacons(key: IntArray, rssi_dbm: FloatArray) -> tuple[IntArray, FloatArray]:
    """Each beacon of some readings (n,) once, ascending, with the mean of its readings."""
    keys, which, count = np.unique(key, return_inverse=True, return_counts=True)
    return keys, np.bincount(which, rssi_dbm, minlength=len(keys)) / count


def parted(fingerprints: Sequence[Fingerprint]) -> tuple[list[Fingerprint], list[Fingerprint]]:
    """What a survey heard of access points, and what of beacons; without those that heard none of the kind."""
    of_access_points, of_beacons = [], []
    for one in fingerprints:
        marked = one.bssid >= MARK
        if not marked.any():
            of_access_points.append(one)
        elif marked.all():
            of_beacons.append(one)
        else:
            of_access_points.append(replace(one, bssid=one.bssid[~marked], rssi_dbm=one.rssi_dbm[~marked]))
            of_beacons.append(replace(one, bssid=one.bssid[marked], rssi_dbm=one.rssi_dbm[marked]))
    return of_access_points, of_beacons
