"""How large the errors of WiFi fixes are in this very building, learnt from its survey with whole walks left out.

A map says how good it is: place the scans of some survey walks on a map of the others, and look how the error grows
with the scatter of the matching points and with the signal distance to the best of them. The scan of a place that
nobody surveyed is unlike all that is known, and that is what the distance tells.

Differs from fixed constants: buildings differ in how many access points they have and how densely they were walked.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize

from app.estimation.arrays import FloatArray
from app.wifi.fingerprint import Fingerprint
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.soft_match import soft_match

SECTION = "fix_calibration"
"""Of the radio map: the numbers below in the order of the fields, and their count of walks."""
GROUPS = 8
LEAST_WALKS = 12
"""Fewer say too little about a building; the defaults then stand."""
LARGEST_SAMPLE = 4000
PRIOR_WALKS = 10.0
"""Walks that the defaults are worth beside the survey's own."""


@dataclass(frozen=True, slots=True)
class FixCalibration:
    """Variance of a fix in each direction: least_m2 + scatter * that of the matching points + distance_m2 * d^2.

    d : signal distance to the best point.  walks : how many survey walks the numbers were learnt from, 0: defaults.
    Defaults: maximum likelihood over the survey walks of folds 1-4 of both mall floors.
    """

    least_m2: float = 7.3
    scatter: float = 0.9
    distance_m2: float = 600.0
    walks: int = 0

    def variance_m2(self, match: Match, distance_weight: float = 1.0) -> float:
        """Of this fix, in each direction. distance_weight : by what the part of the signal distance counts more."""
        scatter_m2 = float(np.trace(match.covariance_m2)) / 2.0
        strange_m2 = self.distance_m2 * match.signal_distance**2
        return self.least_m2 + self.scatter * scatter_m2 + distance_weight * strange_m2


DEFAULT = FixCalibration()


def calibration_of(radio_map: RadioMap) -> FixCalibration:
    """What was learnt when the map was published; the defaults for a map that carries nothing."""
    section = radio_map.sections.get(SECTION)
    if section is None:
        return DEFAULT
    least_m2, scatter, distance_m2, walks = section.tolist()
    return FixCalibration(least_m2, scatter, distance_m2, int(walks))


def calibrated_map(fingerprints: Sequence[Fingerprint], version: int = 0) -> RadioMap:
    """The radio map of a survey, with what the survey says of its own errors."""
    learnt = calibrate(fingerprints)
    numbers = np.array([learnt.least_m2, learnt.scatter, learnt.distance_m2, learnt.walks])
    radio_map = build_radio_map(fingerprints, version)
    return replace(radio_map, sections={**radio_map.sections, SECTION: numbers})


def calibrate(fingerprints: Sequence[Fingerprint]) -> FixCalibration:
    """Learn from a survey; the defaults for one of fewer than LEAST_WALKS walks."""
    walks = len({(one.floor, one.walk) for one in fingerprints})
    if walks < LEAST_WALKS:
        return DEFAULT
    error_m, scatter_m2, distance = left_out_errors(fingerprints)
    if len(error_m) < LEAST_WALKS:
        return DEFAULT
    start = np.log([DEFAULT.least_m2, DEFAULT.scatter, DEFAULT.distance_m2])

    def surprise(logarithms: FloatArray) -> float:
        least_m2, scatter, distance_m2 = np.exp(logarithms)
        variance_m2 = least_m2 + scatter * scatter_m2 + distance_m2 * distance**2
        likely = np.mean(np.log(variance_m2) + error_m**2 / (2.0 * variance_m2))
        return float(likely + PRIOR_WALKS / walks * np.mean((logarithms - start) ** 2))

    found = minimize(surprise, start, method="Nelder-Mead", options={"maxiter": 600})
    least_m2, scatter, distance_m2 = np.exp(found.x).tolist()
    return FixCalibration(least_m2, scatter, distance_m2, walks)


def left_out_errors(fingerprints: Sequence[Fingerprint]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Errors (n,) of survey scans placed on a map without their walk, the matching points' scatter (n,) in each
    direction, and the signal distance (n,). Of a large survey every so manyth scan is placed."""
    group = np.array([zlib.crc32(f"{one.floor} {one.walk}".encode()) % GROUPS for one in fingerprints])
    every = max(1, -(-len(fingerprints) // LARGEST_SAMPLE))
    rows: list[tuple[float, float, float]] = []
    for left_out in range(GROUPS):
        kept = [one for one, of in zip(fingerprints, group, strict=True) if of != left_out]
        placed = [one for one, of in zip(fingerprints, group, strict=True) if of == left_out][::every]
        if not placed:
            continue
        radio_map = build_radio_map(kept)
        for one in placed:
            if one.floor not in radio_map.floors:
                continue
            match = soft_match(radio_map, one.bssid, one.rssi_dbm, floor=radio_map.floors.index(one.floor))
            if match is not None:
                error_m = float(np.hypot(match.xy_m[0] - one.x_m, match.xy_m[1] - one.y_m))
                rows.append((error_m, float(np.trace(match.covariance_m2)) / 2.0, match.signal_distance))
    table = np.array(rows, dtype=np.float64).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2]
