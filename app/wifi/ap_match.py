"""AP match: candidates are the reference points of whose two strongest access points one is the scan's strongest.

Trust Chain Positioning Fusion, Sensors 2015, 15, 29850, section 3.2.2 (docs/methods/trust_chain.md); the lists
are made once per map.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from app.estimation.arrays import FloatArray, IntArray, looked_up
from app.wifi.match_index import MatchIndex, index_of
from app.wifi.radio_map import RadioMap

STRONGEST = 2


@dataclass(frozen=True, slots=True, eq=False)
class ApMatchIndex:
    """Points by access point: those of access point i are `point[start[i]:start[i + 1]]`, ascending."""

    start: IntArray
    point: IntArray


_held: WeakKeyDictionary[RadioMap, ApMatchIndex] = WeakKeyDictionary()


def ap_match_candidates(radio_map: RadioMap, bssid: IntArray, rssi_dbm: FloatArray) -> IntArray:
    """(m,) reference points, ascending; none where the scan's strongest access point is strongest nowhere.

    Access points that the map does not know are passed over: a phone's hotspot nearby is often the strongest.
    """
    lists = ap_match_index(radio_map)
    at, known = looked_up(bssid, radio_map.bssid)
    if not known.any():
        return np.empty(0, np.int64)
    access_points = at[known]
    loudest = access_points[np.lexsort((access_points, -rssi_dbm[known]))[0]]
    return lists.point[lists.start[loudest] : lists.start[loudest + 1]]


def ap_match_index(radio_map: RadioMap) -> ApMatchIndex:
    """The lists of a map; the same object when asked again."""
    lists = _held.get(radio_map)
    if lists is None:
        lists = _held[radio_map] = _build(index_of(radio_map), len(radio_map.bssid))
    return lists


def _build(index: MatchIndex, access_points: int) -> ApMatchIndex:
    row = np.repeat(np.arange(len(index.row_start) - 1), np.diff(index.row_start))
    order = np.lexsort((index.column, -index.row_value, row))  # by point, strongest first
    rank = np.arange(len(order)) - index.row_start[row[order]]
    top = order[rank < STRONGEST]
    point, access_point = row[top], index.column[top]
    by_access_point = np.lexsort((point, access_point))
    start = np.searchsorted(access_point[by_access_point], np.arange(access_points + 1))
    return ApMatchIndex(start.astype(np.int64), point[by_access_point].astype(np.int64))
