"""How well each walk of a survey would have been placed by all the others: leave one walk out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import BoolArray, FloatArray, IntArray
from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import build_radio_map
from app.wifi.wknn import wknn

MOST_COMPARISONS = 40_000_000
"""Of scans with reference points: about half a minute. Larger surveys are judged by scans evenly taken from them."""


@dataclass(frozen=True, slots=True, eq=False)
class WalkErrors:
    """Of n scans that were tried.

    scan : (n,) index of the fingerprint.  error_m : (n,) horizontal; NaN where no place was found or the floor was
    wrong.  placed : (n,) a place was found.  floor_right : (n,) and on the right floor.
    """

    scan: IntArray
    error_m: FloatArray
    placed: BoolArray
    floor_right: BoolArray


def leave_one_walk_out(fingerprints: Sequence[Fingerprint], most_comparisons: int = MOST_COMPARISONS) -> WalkErrors:
    """Place scans of a survey by wknn, without the walks that they are of.

    Every fingerprint is a reference point of its own, which decision 0002 measured equal to gathered ones, so leaving a
    walk out is leaving its points out. A scan by itself: no filter, no history.

    Parameters
    ----------
    fingerprints : in any order.
    """
    count = len(fingerprints)
    order = sorted(range(count), key=lambda at: _place_key(fingerprints[at]))
    radio_map = build_radio_map(fingerprints, cell_m=0.0)  # its points are in this order
    _, walk = np.unique([fingerprints[at].walk for at in order], return_inverse=True)
    step = max(1, -(-count * count // max(most_comparisons, 1)))
    tried = np.arange(0, count, step)
    error_m, placed, floor_right = np.full(len(tried), np.nan), np.zeros(len(tried), bool), np.zeros(len(tried), bool)
    for number, point in enumerate(tried.tolist()):
        one = fingerprints[order[point]]
        others = np.flatnonzero(walk != walk[point])
        match = wknn(radio_map, one.bssid, one.rssi_dbm, points=others) if len(others) else None
        if match is None:
            continue
        placed[number] = True
        floor_right[number] = radio_map.floors[match.floor] == one.floor
        if floor_right[number]:
            error_m[number] = float(np.hypot(*(match.xy_m - (one.x_m, one.y_m))))
    return WalkErrors(np.array(order, np.int64)[tried], error_m, placed, floor_right)


def _place_key(one: Fingerprint) -> tuple[str, float, float, float, str]:
    return one.floor, one.x_m, one.y_m, one.time_s, one.walk
