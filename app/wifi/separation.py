"""Solution separation: where a scan would lie if each group of access points in turn were not to be trusted.

Access points are put into a few groups, all addresses of one radio into one, and the scan is placed without each. Where
all agree no group decides alone; where they part one of them misleads, be it moved, or the only one that is heard
there. How far they part says more of a fix's error than the scatter of the points that match it (decision 0008).

Differs from ARAIM (Blanch et al. 2015), which takes one satellite away: access points are hundreds, err together by
radio and by direction, and each alone moves nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from app.estimation.arrays import Float32Array, FloatArray, IntArray, position_of
from app.wifi.match_index import GROUPS, MatchIndex
from app.wifi.radio_map import Int32Array
from app.wifi.representation import represent

_NEXT_TO_NOTHING = 20.0
"""Logarithm of the weights that are left out."""


@dataclass(frozen=True, slots=True, eq=False)
class GroupedProducts:
    """What cosines are made of, by group of access points.

    shared : (p, GROUPS) sums of a reference point's values times the scan's.  of_point : (p, GROUPS) of the point's
    squares.  of_scan : (GROUPS,) of the scan's.
    """

    shared: FloatArray
    of_point: FloatArray
    of_scan: FloatArray


def grouped_products(index: MatchIndex, bssid: IntArray, rssi_dbm: FloatArray, unheeded: IntArray) -> GroupedProducts:
    """Compare one scan with every reference point.

    Parameters
    ----------
    bssid, rssi_dbm : (n,) the scan, each access point once.
    unheeded : (u,) access points that count on neither side, each once; the scan holds none of them.
    """
    value, of_point = represent(rssi_dbm, index.representation), index.group_square
    if len(unheeded):
        of_point = _without(index.bssid, index.group, index.start, index.point, index.value, of_point, unheeded)
    shared, of_scan = _shared(
        index.bssid, index.group, index.start, index.point, index.value, len(index.floor), bssid, value
    )
    return GroupedProducts(shared, of_point, of_scan)


def cosine_distances(products: GroupedProducts) -> FloatArray:
    """(p,) 1 - cos to every reference point; 1 where nothing is shared."""
    return _distances(products.shared, products.of_point, products.of_scan, -1)


def separated(
    products: GroupedProducts, index: MatchIndex, floor: int, softness: float, otherwise_m: FloatArray
) -> FloatArray:
    """(GROUPS, 2) places of the scan on a floor by soft matching, each without a group.

    Parameters
    ----------
    softness : signal distance by which a point's weight falls to 1/e.
    otherwise_m : (2,) the place without a group that leaves nothing to compare.
    """
    return _separated(
        products.shared,
        products.of_point,
        products.of_scan,
        index.floor,
        index.xy_m,
        floor,
        softness,
        otherwise_m,
    )


@numba.njit(cache=True, nogil=True)
def _without(
    known: IntArray,
    group: IntArray,
    start: IntArray,
    point: Int32Array,
    value: Float32Array,
    of_point: FloatArray,
    unheeded: IntArray,
) -> FloatArray:
    of_point = of_point.copy()
    for k in range(len(unheeded)):
        i = position_of(unheeded[k], known)
        if i < 0:
            continue
        for j in range(start[i], start[i + 1]):
            of_point[point[j], group[i]] = max(of_point[point[j], group[i]] - float(value[j]) ** 2, 0.0)
    return of_point


@numba.njit(cache=True, nogil=True)
def _shared(
    known: IntArray,
    group: IntArray,
    start: IntArray,
    point: Int32Array,
    value: Float32Array,
    points: int,
    bssid: IntArray,
    scan: Float32Array,
) -> tuple[FloatArray, FloatArray]:
    shared, of_scan = np.zeros((points, GROUPS)), np.zeros(GROUPS)
    for k in range(len(bssid)):
        i = position_of(bssid[k], known)
        if i < 0:
            continue
        of_scan[group[i]] += scan[k] * scan[k]
        for j in range(start[i], start[i + 1]):
            shared[point[j], group[i]] += value[j] * scan[k]
    return shared, of_scan


@numba.njit(cache=True, nogil=True)
def _distances(shared: FloatArray, of_point: FloatArray, of_scan: FloatArray, without: int) -> FloatArray:
    """Over all groups but one, -1 for none."""
    distance = np.empty(len(shared))
    scan_square = 0.0
    for group in range(GROUPS):
        if group != without:
            scan_square += of_scan[group]
    for p in range(len(shared)):
        both, point_square = 0.0, 0.0
        for group in range(GROUPS):
            if group != without:
                both += shared[p, group]
                point_square += of_point[p, group]
        norm = math.sqrt(scan_square * point_square)
        distance[p] = 1.0 - both / norm if norm > 0.0 else 1.0
    return distance


@numba.njit(cache=True, nogil=True)
def _separated(
    shared: FloatArray,
    of_point: FloatArray,
    of_scan: FloatArray,
    floors: Int32Array,
    xy_m: FloatArray,
    floor: int,
    softness: float,
    otherwise_m: FloatArray,
) -> FloatArray:
    places_m = np.empty((GROUPS, 2))
    for without in range(GROUPS):
        distance = _distances(shared, of_point, of_scan, without)
        least = 1.0
        for p in range(len(floors)):
            if floors[p] == floor:
                least = min(least, distance[p])
        total, x_m, y_m = 0.0, 0.0, 0.0
        for p in range(len(floors)):
            unlikeness = (distance[p] - least) / softness
            if floors[p] == floor and distance[p] < 1.0 and unlikeness < _NEXT_TO_NOTHING:
                weight = math.exp(-unlikeness)
                total += weight
                x_m += weight * xy_m[p, 0]
                y_m += weight * xy_m[p, 1]
        places_m[without, 0] = x_m / total if total > 0.0 else otherwise_m[0]
        places_m[without, 1] = y_m / total if total > 0.0 else otherwise_m[1]
    return places_m
