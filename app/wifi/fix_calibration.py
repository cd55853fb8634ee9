"""How large the errors of fixes are in this very building, learnt from its survey with whole walks left out.

A map says how good it is: place the scans of some survey walks on a map of the others, and look how the error grows
with the scatter of the matching points and with the signal distance to the best of them. The scan of a place that
nobody surveyed is unlike all that is known, and that is what the distance tells.

Differs from fixed constants: buildings differ in how many access points they have and how densely they were walked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize

from app.estimation.arrays import FloatArray, IntArray
from app.wifi.beacons import BEACON_MATCH, parted
from app.wifi.fingerprint import Fingerprint
from app.wifi.left_out import WIFI_MATCH, LeftOutScans, left_out_scans
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.soft_match import SoftSettings
from app.wifi.survey_likeness import likeness_of, likeness_sections

SECTION = "fix_calibration"
"""Of the radio map: the numbers below in the order of the fields."""
LEAST_WALKS = 12
"""Fewer say too little about a building; the defaults then stand."""
REACH_95 = 2.5
"""Conformal 95 % of errors in standard deviations of the surveys that the levels were set on: the mall, folds 1-4."""
REACH_PRIOR_WALKS = 20.0
"""Walks that a reach of 1 is worth beside the survey's own."""
DISTANCE_WEIGHT = 1.6
"""By what signal distance counts more than the mean square of errors asks for. Where nobody surveyed errors are seldom,
but large and the same for a whole walk: 1.6 trades 0.02 m of mean error for levels that know it."""
PRIOR_WALKS = 10.0
"""Walks that the defaults are worth beside the survey's own."""


@dataclass(frozen=True, slots=True)
class FixCalibration:
    """Variance of a fix in each direction: least_m2 + scatter * that of the matching points + distance_m2 * d^2.

    d : signal distance to the best point.  walks : how many survey walks the numbers were learnt from, 0: defaults.
    reach : by what this survey's errors reach further than those that levels were set on: their conformal 95 % in
    standard deviations, walks counting alike, beside REACH_95; drawn towards 1 where walks are few.
    Defaults: maximum likelihood over the survey walks of folds 1-4 of both mall floors.
    """

    least_m2: float = 7.3
    scatter: float = 0.9
    distance_m2: float = 600.0
    walks: int = 0
    reach: float = 1.0

    def variance_m2(self, match: Match, distance_weight: float = 1.0) -> float:
        """Of this fix, in each direction. distance_weight : by what the part of the signal distance counts more."""
        usual_m2, strange_m2 = self.parts_m2(match, distance_weight)
        return usual_m2 + strange_m2

    def parts_m2(self, match: Match, distance_weight: float = 1.0) -> tuple[float, float]:
        """The variance in two parts: of any fix, and of one of a place unlike those that were surveyed."""
        scatter_m2 = float(np.trace(match.covariance_m2)) / 2.0
        strange_m2 = self.distance_m2 * match.signal_distance**2
        return self.least_m2 + self.scatter * scatter_m2, distance_weight * strange_m2


DEFAULT = FixCalibration()
BEACON_DEFAULT = FixCalibration(14.0, 0.7, 170.0)
"""Of fixes by Bluetooth beacons, likewise: weaker and fewer, so fixes err more."""


def calibration_of(radio_map: RadioMap, default: FixCalibration = DEFAULT) -> FixCalibration:
    """What was learnt when the map was published; the defaults for a map that carries nothing."""
    section = radio_map.sections.get(SECTION)
    if section is None:
        return default
    least_m2, scatter, distance_m2, walks, *rest = section.tolist()
    reach = rest[0] if rest else 1.0  # maps of an earlier version have none
    return FixCalibration(least_m2, scatter, distance_m2, int(walks), reach)


def calibrated_map(fingerprints: Sequence[Fingerprint], version: int = 0) -> RadioMap:
    """The radio map of a survey, and of its beacons if there are any, with what the survey says of its own errors."""
    of_access_points, of_beacons = parted(fingerprints)
    floors = sorted({one.floor for one in fingerprints})
    left_out = left_out_scans(of_access_points)
    radio_map = build_radio_map(of_access_points, version, floors=floors)
    likeness = likeness_sections(likeness_of(of_access_points, left_out, floors))
    radio_map = _told(replace(radio_map, sections=likeness), calibrate(of_access_points, left_out=left_out))
    if not of_beacons:
        return radio_map
    learnt = calibrate(of_beacons, BEACON_MATCH, BEACON_DEFAULT)
    return replace(radio_map, beacons=_told(build_radio_map(of_beacons, version, floors=floors), learnt))


def _told(radio_map: RadioMap, learnt: FixCalibration) -> RadioMap:
    numbers = np.array([learnt.least_m2, learnt.scatter, learnt.distance_m2, learnt.walks, learnt.reach])
    return replace(radio_map, sections={**radio_map.sections, SECTION: numbers})


def calibrate(
    fingerprints: Sequence[Fingerprint],
    matching: SoftSettings = WIFI_MATCH,
    default: FixCalibration = DEFAULT,
    left_out: LeftOutScans | None = None,
) -> FixCalibration:
    """Learn from what a survey heard of one radio; the defaults if in fewer than LEAST_WALKS walks.

    left_out : its scans, where they have been placed already.
    """
    walks = len({(one.floor, one.walk) for one in fingerprints})
    if walks < LEAST_WALKS:
        return default
    left_out = left_out or left_out_scans(fingerprints, matching)
    error_m, scatter_m2, distance = left_out.error_m, left_out.scatter_m2, left_out.signal_distance
    if len(error_m) < LEAST_WALKS:
        return default
    start = np.log([default.least_m2, default.scatter, default.distance_m2])

    def surprise(logarithms: FloatArray) -> float:
        least_m2, scatter, distance_m2 = np.exp(logarithms)
        variance_m2 = least_m2 + scatter * scatter_m2 + distance_m2 * distance**2
        likely = np.mean(np.log(variance_m2) + error_m**2 / (2.0 * variance_m2))
        return float(likely + PRIOR_WALKS / walks * np.mean((logarithms - start) ** 2))

    found = minimize(surprise, start, method="Nelder-Mead", options={"maxiter": 600})
    least_m2, scatter, distance_m2 = np.exp(found.x).tolist()
    learnt = FixCalibration(least_m2, scatter, distance_m2, walks)
    sigma_m = np.sqrt([learnt.variance_m2(match, DISTANCE_WEIGHT) for match in left_out.match])
    conformal = conformal_reach(error_m / sigma_m, left_out.walk, 0.95)
    return replace(learnt, reach=(conformal / REACH_95) ** (walks / (walks + REACH_PRIOR_WALKS)))


def conformal_reach(score: FloatArray, walk: IntArray, share: float) -> float:
    """The score that a scan of a new walk stays below in this share of cases, were walks drawn alike.

    Parameters
    ----------
    score : (n,) larger is worse.  walk : (n,) whose; the scans of one err alike, so each walk counts once.

    Notes
    -----
    Split conformal prediction (Vovk et al. 2005) over walks: of w walks the share is raised by 1 / w of itself; where
    that passes 1 the largest score is taken.
    """
    _, which, count = np.unique(walk, return_inverse=True, return_counts=True)
    order = np.argsort(score)
    reached = np.cumsum((1.0 / count)[which.reshape(-1)][order]) / len(count)
    wanted = share * (1.0 + 1.0 / len(count))
    return float(score[order[min(int(np.searchsorted(reached, wanted)), len(order) - 1)]])
