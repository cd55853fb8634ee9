"""How unlike a scan and the reference points are.

Each distance is made of sums over the access points that both heard and of sums over each alone, so a scan touches the
pairs of its own access points only.

Differs from the paper: access points that the map does not know are left out, they say nothing about the place. What
one side heard and the other did not counts as 0 of the other (see app/wifi/representation.py).
"""

from __future__ import annotations

import math
from enum import IntEnum

import numba
import numpy as np

from app.estimation.arrays import Float32Array, FloatArray, IntArray, position_of
from app.wifi.match_index import MatchIndex
from app.wifi.radio_map import Int32Array
from app.wifi.representation import represent


class Distance(IntEnum):
    """SORENSEN (also Bray-Curtis): sum |a - b| / sum (a + b), for values of 0 and more.  COSINE: 1 - cos."""

    EUCLIDEAN = 0
    SORENSEN = 1
    COSINE = 2


NOTHING: IntArray = np.empty(0, np.int64)


def distances(
    index: MatchIndex,
    bssid: IntArray,
    rssi_dbm: FloatArray,
    distance: Distance,
    points: IntArray | None = None,
    unheeded: IntArray = NOTHING,
) -> FloatArray:
    """Distance of one scan to every reference point, or to some.

    Parameters
    ----------
    bssid, rssi_dbm : (n,) the scan, each access point once.
    points : (m,) reference points to compare with; all if None.
    unheeded : (u,) access points that count on neither side, each once; the scan holds none of them.

    Returns
    -------
    (p,) or (m,). SORENSEN and COSINE are 1 where nothing is shared.
    """
    value = represent(rssi_dbm, index.representation)
    total, square = index.total, index.square
    if len(unheeded):
        total, square = _without(index.bssid, index.start, index.point, index.value, total, square, unheeded)
    if points is None:
        return _to_all(index.bssid, index.start, index.point, index.value, total, square, bssid, value, int(distance))
    return _to_some(
        index.bssid,
        index.row_start,
        index.column,
        index.row_value,
        total,
        square,
        bssid,
        value,
        int(distance),
        points,
    )


@numba.njit(cache=True, nogil=True)
def _without(
    known: IntArray,
    start: IntArray,
    point: Int32Array,
    value: Float32Array,
    total: FloatArray,
    square: FloatArray,
    unheeded: IntArray,
) -> tuple[FloatArray, FloatArray]:
    """Sums of the points' values, and of their squares, without some access points."""
    total, square = total.copy(), square.copy()
    for k in range(len(unheeded)):
        i = position_of(unheeded[k], known)
        if i < 0:
            continue
        for j in range(start[i], start[i + 1]):
            total[point[j]] = max(total[point[j]] - value[j], 0.0)
            square[point[j]] = max(square[point[j]] - float(value[j]) ** 2, 0.0)
    return total, square


@numba.njit(cache=True, nogil=True)
def _to_all(
    known: IntArray,
    start: IntArray,
    point: Int32Array,
    value: Float32Array,
    total: FloatArray,
    square: FloatArray,
    bssid: IntArray,
    scan: Float32Array,
    distance: int,
) -> FloatArray:
    shared = np.zeros(len(total))
    scan_total = 0.0
    scan_square = 0.0
    for k in range(len(bssid)):
        i = position_of(bssid[k], known)
        if i < 0:
            continue
        q = scan[k]
        scan_total += q
        scan_square += q * q
        if distance == 1:
            for j in range(start[i], start[i + 1]):
                shared[point[j]] += min(value[j], q)
        else:
            for j in range(start[i], start[i + 1]):
                shared[point[j]] += value[j] * q
    result = np.empty(len(total))
    for p in range(len(total)):
        result[p] = _finish(distance, shared[p], scan_total, scan_square, total[p], square[p])
    return result


@numba.njit(cache=True, nogil=True)
def _to_some(
    known: IntArray,
    row_start: IntArray,
    column: Int32Array,
    row_value: Float32Array,
    total: FloatArray,
    square: FloatArray,
    bssid: IntArray,
    scan: Float32Array,
    distance: int,
    points: IntArray,
) -> FloatArray:
    spread = np.zeros(len(known), np.float32)
    scan_total = 0.0
    scan_square = 0.0
    for k in range(len(bssid)):
        i = position_of(bssid[k], known)
        if i >= 0:
            spread[i] = scan[k]
            scan_total += scan[k]
            scan_square += scan[k] * scan[k]
    result = np.empty(len(points))
    for m in range(len(points)):
        p = points[m]
        shared = 0.0
        if distance == 1:
            for j in range(row_start[p], row_start[p + 1]):
                shared += min(row_value[j], spread[column[j]])
        else:
            for j in range(row_start[p], row_start[p + 1]):
                shared += row_value[j] * spread[column[j]]
        result[m] = _finish(distance, shared, scan_total, scan_square, total[p], square[p])
    return result


@numba.njit(cache=True, nogil=True)
def _finish(distance: int, shared: float, scan_total: float, scan_square: float, total: float, square: float) -> float:
    if distance == 0:
        return math.sqrt(max(scan_square + square - 2.0 * shared, 0.0))
    if distance == 1:
        both = scan_total + total
        return 1.0 - 2.0 * shared / both if both > 0.0 else 1.0
    norm = math.sqrt(scan_square * square)
    return 1.0 - shared / norm if norm > 0.0 else 1.0
