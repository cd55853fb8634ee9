"""Kernel-density matching: a Gaussian kernel about every fingerprint, and a covariance for each fix.

Yu, Na, Liu and Deng, EURASIP J. Wireless Communications and Networking 2019:41, section 6.1
(docs/methods/dual_ukf.md).

Missing access points: with PAPER they are left out pair by pair, so distances are means over the d that scan and point
share, and of points that share less than LEAST_SHARE of the best-informed one's nothing is believed: they would win by
having little to disagree about. Otherwise a point is taken to hear at missing_dbm what the scan heard and it did not.
Differs from the paper, where the settings are not PAPER: that, readings weigh by their strength, and the scan counts as
a few `witnesses`, not d (all as in app/wifi/weibull_bayes.py). In any case sigma is made of standard deviations where
the paper writes variances.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numba
import numpy as np

from app.estimation.arrays import Float32Array, FloatArray, IntArray, position_of
from app.wifi.match import Match, known_access_points, matched_nearest
from app.wifi.match_index import index_of
from app.wifi.radio_map import Int32Array, RadioMap
from app.wifi.representation import represent

LEAST_SHARE = 0.5


@dataclass(frozen=True, slots=True)
class KernelSettings:
    """How differences become weights.

    missing_dbm : what a point hears of an access point that it never heard; None leaves the pair out.  by_strength :
    readings weigh by their powed value.  witnesses : how many independent access points a scan counts as; None for d.
    least_sigma_db : of the standard deviation of readings; surveys of single scans show little of it.
    movement_sigma_m : walking speed x scan interval, of the paper's Sigma_l.  neighbours : best points that take part.
    """

    missing_dbm: float | None = -95.0
    by_strength: bool = True
    witnesses: float | None = 1.0
    least_sigma_db: float = 4.0
    movement_sigma_m: float = 2.5
    neighbours: int = 8


PAPER = KernelSettings(missing_dbm=None, by_strength=False, witnesses=None, neighbours=20)
_sigmas: WeakKeyDictionary[RadioMap, float] = WeakKeyDictionary()


def kernel_match(
    radio_map: RadioMap,
    bssid: IntArray,
    rssi_dbm: FloatArray,
    settings: KernelSettings = KernelSettings(),
    floor: int | None = None,
    points: IntArray | None = None,
) -> Match | None:
    """Match one scan: weighted mean; covariance = Sigma_l + weighted scatter. Arguments as of app.wifi.wknn.wknn.

    The `distance` of a neighbour is its root mean square difference in dB.
    """
    index = index_of(radio_map)
    known = known_access_points(index, bssid)
    if known == 0:
        return None
    square_db2, shared = mean_squares(radio_map, bssid, rssi_dbm, settings)
    if points is not None:
        square_db2, shared = square_db2[points], shared[points]
    if len(shared) == 0 or shared.max() == 0:
        return None
    most = int(shared.max())
    square_db2[shared < (1 if settings.missing_dbm is not None else LEAST_SHARE * most)] = np.inf
    sigma_db = silverman_sigma(max(_sigma_db(radio_map), settings.least_sigma_db), most, len(shared))
    precision = (most if settings.witnesses is None else settings.witnesses) / sigma_db**2

    def kernel(square_db2: FloatArray) -> FloatArray:
        return np.asarray(np.exp(0.5 * precision * (square_db2[0] - square_db2)), np.float64)

    match = matched_nearest(index, square_db2, points, floor, settings.neighbours, kernel, known)
    if match is None:
        return None
    movement_m2 = settings.movement_sigma_m**2 * np.eye(2)
    return replace(match, distance=np.sqrt(match.distance), covariance_m2=movement_m2 + match.covariance_m2)


def silverman_sigma(sigma_db: float, access_points: int, points: int) -> float:
    """Silverman's rule, d = access_points and N = points: sigma (4 / ((d + 2) N))^(1 / (d + 4))."""
    return float(sigma_db * (4.0 / ((access_points + 2) * points)) ** (1.0 / (access_points + 4)))


def mean_squares(
    radio_map: RadioMap, bssid: IntArray, rssi_dbm: FloatArray, settings: KernelSettings = PAPER
) -> tuple[FloatArray, IntArray]:
    """(p,) mean squared difference in dB^2, infinite where nothing is shared, and how many access points are."""
    index = index_of(radio_map)
    strength = represent(rssi_dbm, index.representation).astype(np.float64)
    return _mean_squares(
        radio_map.bssid,
        radio_map.start,
        radio_map.point,
        radio_map.mean_dbm,
        len(radio_map.scans),
        bssid,
        np.asarray(rssi_dbm, np.float64),
        strength if settings.by_strength else np.ones_like(strength),
        math.nan if settings.missing_dbm is None else settings.missing_dbm,
    )


def _sigma_db(radio_map: RadioMap) -> float:
    """Square root of the mean variance of the pairs that were heard more than once, 0 of none."""
    sigma_db = _sigmas.get(radio_map)
    if sigma_db is None:
        variance_db2 = radio_map.variance_db2[radio_map.count > 1]
        sigma_db = _sigmas[radio_map] = math.sqrt(float(variance_db2.mean())) if len(variance_db2) else 0.0
    return sigma_db


@numba.njit(cache=True, nogil=True)
def _mean_squares(
    known: IntArray,
    start: IntArray,
    point: Int32Array,
    mean_dbm: Float32Array,
    points: int,
    bssid: IntArray,
    rssi_dbm: FloatArray,
    weight: FloatArray,
    missing_dbm: float,
) -> tuple[FloatArray, IntArray]:
    filled = not np.isnan(missing_dbm)
    square_db2 = np.zeros(points)
    whole = np.zeros(points)
    shared = np.zeros(points, np.int64)
    scan_whole = 0.0
    scan_square_db2 = 0.0
    for k in range(len(bssid)):
        i = position_of(bssid[k], known)
        if i < 0:
            continue
        missing_db2 = (rssi_dbm[k] - missing_dbm) ** 2 if filled else 0.0
        scan_whole += weight[k]
        scan_square_db2 += weight[k] * missing_db2
        for j in range(start[i], start[i + 1]):
            p = point[j]
            square_db2[p] += weight[k] * ((rssi_dbm[k] - mean_dbm[j]) ** 2 - missing_db2)
            whole[p] += weight[k]
            shared[p] += 1
    for p in range(points):
        of = scan_whole if filled else whole[p]
        square_db2[p] = max(square_db2[p] + scan_square_db2, 0.0) / of if shared[p] > 0 and of > 0.0 else np.inf
    return square_db2, shared
