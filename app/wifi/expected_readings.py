"""What a radio map expects to be heard around a place: of each access point how often, how loud and how varied.

Made of the survey scans around, the nearer the more, so that a place known to some metres only gets the levels of all
the places that it may be.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numba
import numpy as np

from app.estimation.arrays import Float32Array, FloatArray, IntArray
from app.wifi.radio_map import Int32Array, RadioMap

_REACH = 2.5
"""Standard deviations up to which survey scans count."""


@dataclass(frozen=True, slots=True, eq=False)
class ExpectedReadings:
    """Of the map's a access points around one place.

    scans : weight of the survey scans around; one at the very place weighs 1.
    heard : (a,) weight of those that heard the access point.
    mean_dbm, spread_db : (a,) of their readings, over scans and places; 0 where none heard it.
    """

    scans: float
    heard: FloatArray
    mean_dbm: FloatArray
    spread_db: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _ByPoint:
    """The map's pairs by point: start (p + 1,); access point, count, mean and variance (n,)."""

    start: IntArray
    access_point: Int32Array
    count: Float32Array
    mean_dbm: Float32Array
    variance_db2: Float32Array


_held: WeakKeyDictionary[RadioMap, _ByPoint] = WeakKeyDictionary()


def expected_readings(radio_map: RadioMap, floor: int, xy_m: FloatArray, sigma_m: float) -> ExpectedReadings:
    """What is heard around a place of a floor.

    Parameters
    ----------
    floor : index into the map's floors.  xy_m : (2,).
    sigma_m : standard deviation of the weight that survey scans have by their distance.
    """
    pairs = _by_point(radio_map)
    scans, heard, mean_dbm, spread_db = _gathered(
        radio_map.xy_m,
        radio_map.floor,
        radio_map.scans,
        pairs.start,
        pairs.access_point,
        pairs.count,
        pairs.mean_dbm,
        pairs.variance_db2,
        floor,
        float(xy_m[0]),
        float(xy_m[1]),
        sigma_m,
        len(radio_map.bssid),
    )
    return ExpectedReadings(scans, heard, mean_dbm, spread_db)


def _by_point(radio_map: RadioMap) -> _ByPoint:
    """Made once per map, when first asked for."""
    pairs = _held.get(radio_map)
    if pairs is None:
        order = np.argsort(radio_map.point, kind="stable")
        pairs = _held[radio_map] = _ByPoint(
            start=np.searchsorted(radio_map.point[order], np.arange(len(radio_map.scans) + 1)),
            access_point=radio_map.access_point[order],
            count=radio_map.count[order].astype(np.float32),
            mean_dbm=radio_map.mean_dbm[order],
            variance_db2=radio_map.variance_db2[order],
        )
    return pairs


@numba.njit(cache=True, nogil=True)
def _gathered(
    xy_m: FloatArray,
    floors: Int32Array,
    scans: Int32Array,
    start: IntArray,
    access_point: Int32Array,
    count: Float32Array,
    mean_dbm: Float32Array,
    variance_db2: Float32Array,
    floor: int,
    x_m: float,
    y_m: float,
    sigma_m: float,
    access_points: int,
) -> tuple[float, FloatArray, FloatArray, FloatArray]:
    heard = np.zeros(access_points)
    mean = np.zeros(access_points)
    spread = np.zeros(access_points)
    total = 0.0
    for p in range(len(floors)):
        if floors[p] != floor:
            continue
        square = ((xy_m[p, 0] - x_m) ** 2 + (xy_m[p, 1] - y_m) ** 2) / (sigma_m * sigma_m)
        if square > _REACH * _REACH:
            continue
        weight = math.exp(-0.5 * square)
        total += weight * scans[p]
        for j in range(start[p], start[p + 1]):
            i = access_point[j]
            w = weight * count[j]
            heard[i] += w
            mean[i] += w * mean_dbm[j]
            spread[i] += w * (variance_db2[j] + mean_dbm[j] * mean_dbm[j])
    for i in range(access_points):
        if heard[i] > 0.0:
            mean[i] /= heard[i]
            spread[i] = math.sqrt(max(spread[i] / heard[i] - mean[i] * mean[i], 0.0))
    return total, heard, mean, spread
