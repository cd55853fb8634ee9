"""How large the errors of fixes are in this very building, learnt from its survey with whole walks left out.

A map says how good it is: place the scans of some survey walks on a map of the others, and look how the error grows
with the scatter of the matching points and with the signal distance to the best of them. The scan of a place that
nobody surveyed is unlike all that is known, and that is what the distance tells.

Differs from fixed constants: buildings differ in how many access points they have and how densely they were walked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields, replace

import numpy as np
from scipy.optimize import minimize

from app.estimation.arrays import FloatArray
from app.wifi import floor_doubt
from app.wifi.beacons import BEACON_MATCH, parted
from app.wifi.fingerprint import Fingerprint
from app.wifi.left_out import WIFI_MATCH, LeftOutScans, left_out_scans
from app.wifi.left_out_errors import conformal_reach, persistence
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.soft_match import SoftSettings
from app.wifi.survey_likeness import likeness_of, likeness_sections

SECTION = "fix_calibration"
"""Of the radio map: the numbers below in the order of the fields."""
LEAST_WALKS = 4
"""Of fewer, leaving one out leaves no map of the building; the defaults then stand."""
FEW_WALKS_WEIGHT = 2.0
"""By what their distance_m2 counts more: few walks leave most places to nobody. On maps of two of the mall's walks
1.5 % of answers are hazardous at 20 m without it, and 0.3 % with it."""
REACH_68, REACH_95 = 1.17, 2.5
"""Conformal 68 and 95 % of errors in standard deviations of the surveys that radii were set on: the mall, folds 1-4."""
REACH_PRIOR_WALKS = 20.0
"""Walks that a reach, a fineness and a persistence of 1 are worth beside the survey's own."""
TYPICAL_M = 4.4
"""Median standard deviation of left-out fixes in those surveys."""
LEAST_FINENESS = 0.5
TYPICAL_PERSISTENCE = 0.33
"""How left-out errors last along a walk in those surveys, the least of them; 0.37 the most."""
LEAST_PERSISTENCE = 0.4
DISTANCE_WEIGHT = 1.6
"""By what signal distance counts more than the mean square of errors asks for. Where nobody surveyed errors are seldom,
but large and the same for a whole walk: 1.6 trades 0.02 m of mean error for levels that know it."""
PRIOR_WALKS = 10.0
"""Walks that the defaults are worth beside the survey's own."""


@dataclass(frozen=True, slots=True)
class FixCalibration:
    """Where a match puts the phone, and with what variance in each direction.

    least_m2, scatter, separation, distance_m2, edge : the variance is
    least_m2 + scatter * that of the matching points + separation * that of the solutions without a group
    + (distance_m2 + edge * |outward|^2) * strangeness.
    beyond : a strange scan at the edge of the survey was taken past it: the place moves by beyond * strangeness *
    outward.  parted : and by this share of the way to the mean of the places without a group.
    walks : how many survey walks the numbers were learnt from, 0: defaults.
    reach, reach_68 : by what this survey's errors reach further than those that levels, and accuracies, were set on:
    their conformal 95 and 68 % in standard deviations, walks counting alike, beside REACH_95 and REACH_68; drawn
    towards 1 where walks are few.
    fineness : by what errors that a whole walk shares are less, LEAST_FINENESS to 1: the root of the left-out fixes'
    median standard deviation, beside TYPICAL_M; drawn towards 1 likewise.
    persistence : by what errors last less along a walk, LEAST_PERSISTENCE to 1, beside TYPICAL_PERSISTENCE; likewise.
    Defaults: maximum likelihood over the survey walks of folds 1-4 of both mall floors, but for distance_m2: all walks
    of the mall say 700, 20 to 80 of them 2,600 to 4,500, since more places are left that nobody surveyed.
    """

    least_m2: float = 8.1
    scatter: float = 0.4
    separation: float = 0.13
    distance_m2: float = 1500.0
    edge: float = 28.0
    beyond: float = 16.0
    parted: float = 0.1
    walks: int = 0
    reach: float = 1.0
    fineness: float = 1.0
    reach_68: float = 1.0
    persistence: float = 1.0

    def place_m(self, match: Match) -> FloatArray:
        """(2,) of the phone."""
        share = min(self.beyond * match.strangeness, 1.0)
        return np.asarray(match.xy_m + share * match.outward_m + self.parted * match.parted_m, np.float64)

    def variance_m2(self, match: Match, distance_weight: float = 1.0) -> float:
        """Of that place, in each direction. distance_weight : by what strangeness counts more."""
        least, scatter_m2, apart_m2, _, _ = _witnesses(match)
        usual_m2 = self.least_m2 * least + self.scatter * scatter_m2 + self.separation * apart_m2
        return usual_m2 + distance_weight * self.strange_m2(match)

    def strange_m2(self, match: Match) -> float:
        """What of the variance of a place is because the scan is unlike what was surveyed."""
        *_, strange, at_edge_m2 = _witnesses(match)
        return self.distance_m2 * strange + self.edge * at_edge_m2


def _witnesses(match: Match) -> tuple[float, float, float, float, float]:
    """What the variance is a sum of, each times its number in the order of FixCalibration."""
    scatter_m2 = float(np.trace(match.covariance_m2)) / 2.0
    at_edge_m2 = match.strangeness * float(match.outward_m @ match.outward_m)
    return 1.0, scatter_m2, match.separation_m2, match.strangeness, at_edge_m2


DEFAULT = FixCalibration()
BEACON_DEFAULT = FixCalibration(14.0, 0.7, distance_m2=170.0)
"""Of fixes by Bluetooth beacons, likewise: weaker and fewer, so fixes err more."""


def calibration_of(radio_map: RadioMap, default: FixCalibration = DEFAULT) -> FixCalibration:
    """What was learnt when the map was published; the defaults for a map that carries nothing, or what an earlier
    release learnt, which weighed other witnesses. The last two before this one learnt neither reach_68 nor persistence,
    and the first of them no fineness."""
    section = radio_map.sections.get(SECTION)
    if section is None or len(fields(FixCalibration)) - len(section) not in (0, 2, 3):
        return default
    learnt = FixCalibration(*section.tolist())
    return replace(learnt, walks=int(learnt.walks))


def calibrated_map(fingerprints: Sequence[Fingerprint], version: int = 0) -> RadioMap:
    """The radio map of a survey, and of its beacons if there are any, with what the survey says of its own errors."""
    of_access_points, of_beacons = parted(fingerprints)
    floors = sorted({one.floor for one in fingerprints})
    left_out = left_out_scans(of_access_points, floors=floors)
    radio_map = build_radio_map(of_access_points, version, floors=floors)
    sections = likeness_sections(likeness_of(of_access_points, left_out, floors))
    sections[floor_doubt.SECTION] = floor_doubt.section_of(floor_doubt.learnt_doubt(of_access_points, left_out, floors))
    radio_map = _told(replace(radio_map, sections=sections), calibrate(of_access_points, left_out=left_out))
    if not of_beacons:
        return radio_map
    learnt = calibrate(of_beacons, BEACON_MATCH, BEACON_DEFAULT)
    return replace(radio_map, beacons=_told(build_radio_map(of_beacons, version, floors=floors), learnt))


def _told(radio_map: RadioMap, learnt: FixCalibration) -> RadioMap:
    return replace(radio_map, sections={**radio_map.sections, SECTION: np.array(astuple(learnt), np.float64)})


def calibrate(
    fingerprints: Sequence[Fingerprint],
    matching: SoftSettings = WIFI_MATCH,
    default: FixCalibration = DEFAULT,
    left_out: LeftOutScans | None = None,
) -> FixCalibration:
    """Learn from what a survey heard of one radio; in fewer than LEAST_WALKS walks the defaults, with more caution.

    left_out : its scans, where they have been placed already.
    """
    walks = len({(one.floor, one.walk) for one in fingerprints})
    cautious = replace(default, distance_m2=FEW_WALKS_WEIGHT * default.distance_m2)
    if walks < LEAST_WALKS:
        return cautious
    left_out = left_out or left_out_scans(fingerprints, matching)
    if len(left_out.match) < LEAST_WALKS:
        return cautious
    witnesses = np.array([_witnesses(match) for match in left_out.match], np.float64)
    outward_m = np.array([match.outward_m for match in left_out.match], np.float64)
    parted_m = np.array([match.parted_m for match in left_out.match], np.float64)
    strangeness = np.array([[match.strangeness] for match in left_out.match], np.float64)
    # beacons have no groups and no edge
    seen = np.concatenate([witnesses.any(axis=0), [outward_m.any(), parted_m.any()]])
    usual = np.array(astuple(default)[: len(seen)], np.float64)

    def numbers(logarithms: FloatArray) -> FloatArray:
        found = usual.copy()
        found[seen] = np.exp(logarithms)
        return found

    def missed_m2(beyond: float, parted: float) -> FloatArray:
        moved_m = np.minimum(beyond * strangeness, 1.0) * outward_m + parted * parted_m
        return np.asarray(((left_out.missed_m - moved_m) ** 2).sum(axis=1), np.float64)

    def surprise(logarithms: FloatArray) -> float:
        *weights, beyond, parted = numbers(logarithms)
        variance_m2 = witnesses @ weights
        likely = np.mean(np.log(variance_m2) + missed_m2(beyond, parted) / (2.0 * variance_m2))
        return float(likely + PRIOR_WALKS / walks * np.mean((logarithms - start) ** 2))

    start = np.log(usual[seen])
    found = minimize(surprise, start, method="L-BFGS-B", bounds=[(one - 5.0, one + 5.0) for one in start])
    learnt = replace(FixCalibration(*numbers(found.x).tolist()), walks=walks)
    return _beside_the_usual(learnt, left_out, np.array([(one.x_m, one.y_m) for one in fingerprints], np.float64))


def _beside_the_usual(learnt: FixCalibration, left_out: LeftOutScans, true_m: FloatArray) -> FixCalibration:
    """With how its errors differ from those that the radii were set on. true_m : (f, 2) of all fingerprints."""
    sigma_m = np.sqrt([learnt.variance_m2(match, DISTANCE_WEIGHT) for match in left_out.match])
    missed_m = true_m[left_out.scan] - [learnt.place_m(match) for match in left_out.match]
    error, walk = missed_m / sigma_m[:, None], left_out.walk
    score = np.hypot(*error.T)
    finer = math.sqrt(float(np.median(sigma_m)) / TYPICAL_M)
    lasts = persistence(error, true_m[left_out.scan], walk) / TYPICAL_PERSISTENCE
    believed = learnt.walks / (learnt.walks + REACH_PRIOR_WALKS)
    return replace(
        learnt,
        reach=(conformal_reach(score, walk, 0.95) / REACH_95) ** believed,
        reach_68=(conformal_reach(score, walk, 0.68) / REACH_68) ** believed,
        fineness=min(max(finer, LEAST_FINENESS), 1.0) ** believed,
        persistence=min(max(lasts, LEAST_PERSISTENCE), 1.0) ** believed,
    )
