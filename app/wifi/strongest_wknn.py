"""WKNN over a scan's strongest access points alone: Euclidean distance of RSSI, weights 1 / distance.

Two-stage WiFi/MEMS integration, Micromachines 2019, 10, 198, Eq. 1 and 3 (docs/methods/two_stage_ekf.md); the
trust chain's WKNN is the same (docs/methods/trust_chain.md).

Differs from the papers: access points that the map does not know are passed over before the strongest are counted. One
that a reference point never heard counts there as `missing_dbm`, one heard in a part of its scans as that much nearer
to it; what a point heard and the scan did not plays no part, as in Eq. 1. Distances are root mean squares, in dB, so
that scans of different size compare; it leaves the weights as they are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from app.estimation.arrays import Float32Array, FloatArray, IntArray, position_of
from app.wifi.match import Match, matched_nearest
from app.wifi.match_index import index_of
from app.wifi.radio_map import Int32Array, RadioMap
from app.wifi.representation import Representation, Shape, represent

_LEAST_DISTANCE_DB = 1e-3
"""Keeps the weight of a perfect match finite."""
LOOK_UP_COSTS = 16
"""Steps along a list that take as long as one search in it."""


@dataclass(frozen=True, slots=True)
class StrongestSettings:
    """count : access points of the scan that take part, the paper's 20.  neighbours : the papers leave K open.
    missing_dbm : what a reference point counts with that never heard one of them; weaker readings count as it too."""

    count: int = 20
    neighbours: int = 5
    missing_dbm: float = -100.0


def strongest_wknn(
    radio_map: RadioMap,
    bssid: IntArray,
    rssi_dbm: FloatArray,
    settings: StrongestSettings = StrongestSettings(),
    floor: int | None = None,
    points: IntArray | None = None,
) -> Match | None:
    """Match one scan.

    Parameters
    ----------
    bssid, rssi_dbm : (n,) the scan, each access point once.
    floor : index of the floor to place it on; by default the one that the neighbours on all floors vote for.
    points : (m,) ascending, the only reference points to look at.

    Returns
    -------
    None where the map knows no access point of the scan, or no candidate shares one.
    """
    index = index_of(radio_map, Representation(Shape.POSITIVE, zero_dbm=settings.missing_dbm))
    access_points, height_db, known = _loudest(
        index.bssid, bssid, represent(rssi_dbm, index.representation), settings.count
    )
    if known == 0:
        return None
    if points is None:
        distance = _to_all(index.start, index.point, index.value, access_points, height_db, len(index.floor))
    else:
        distance = _to_some(index.start, index.point, index.value, access_points, height_db, points)
    return matched_nearest(index, distance, points, floor, settings.neighbours, _weight, known)


def _weight(distance_db: FloatArray) -> FloatArray:
    return 1.0 / np.maximum(distance_db, _LEAST_DISTANCE_DB)


@numba.njit(cache=True, nogil=True)
def _loudest(known: IntArray, bssid: IntArray, height_db: Float32Array, count: int) -> tuple[IntArray, FloatArray, int]:
    """Index in the map (k,) and height (k,) of the scan's strongest known access points; how many are known."""
    found, height = np.empty(len(bssid), np.int64), np.empty(len(bssid))
    size = 0
    for k in range(len(bssid)):
        i = position_of(bssid[k], known)
        if i >= 0:
            found[size], height[size] = i, height_db[k]
            size += 1
    # of equal ones the lower address, whatever the order of the scan
    by_address = np.argsort(found[:size])
    order = by_address[np.argsort(-height[:size][by_address], kind="mergesort")][:count]
    return found[:size][order], height[:size][order], size


@numba.njit(cache=True, nogil=True)
def _to_all(
    start: IntArray, point: Int32Array, value: Float32Array, access_points: IntArray, height_db: FloatArray, points: int
) -> FloatArray:
    """(p,) root mean square difference, infinite where nothing is shared."""
    extra, shares = np.zeros(points), np.zeros(points, np.bool_)
    nothing = 0.0
    for k in range(len(access_points)):
        h = height_db[k]
        nothing += h * h
        for j in range(start[access_points[k]], start[access_points[k] + 1]):
            extra[point[j]] += value[j] * (value[j] - 2.0 * h)
            shares[point[j]] = True
    distance = np.empty(points)
    for p in range(points):
        distance[p] = math.sqrt(max(nothing + extra[p], 0.0) / len(access_points)) if shares[p] else math.inf
    return distance


@numba.njit(cache=True, nogil=True)
def _to_some(
    start: IntArray,
    point: Int32Array,
    value: Float32Array,
    access_points: IntArray,
    height_db: FloatArray,
    points: IntArray,
) -> FloatArray:
    """(m,) the same of some points, ascending: each is looked up in the lists of the scan's access points; many of them
    walk along the list instead."""
    extra, shares = np.zeros(len(points)), np.zeros(len(points), np.bool_)
    nothing = 0.0
    for k in range(len(access_points)):
        h = height_db[k]
        nothing += h * h
        at, end = start[access_points[k]], start[access_points[k] + 1]
        few = len(points) * LOOK_UP_COSTS < end - at
        for m in range(len(points)):
            if few:
                at += np.searchsorted(point[at:end], points[m])
            else:
                while at < end and point[at] < points[m]:
                    at += 1
            if at == end:
                break
            if point[at] == points[m]:
                extra[m] += value[at] * (value[at] - 2.0 * h)
                shares[m] = True
    distance = np.empty(len(points))
    for m in range(len(points)):
        distance[m] = math.sqrt(max(nothing + extra[m], 0.0) / len(access_points)) if shares[m] else math.inf
    return distance
