"""Walks as evidence alone: steps and fixes that are made from a truth which the tests know."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion.walk_timeline import Moment
from app.observations import Motion, RadioFix, Step

STEP_S, STEP_M = 0.55, 0.7
STEPS_A_FIX = 4
OWN_M2, LASTING_M2, REACH_M = 8.0, 12.0, 12.0


@dataclass(frozen=True)
class Told:
    """Evidence of a walk. truth_m : (n, 2) at its moments, the ends of the steps."""

    evidence: tuple[Step | RadioFix, ...]
    moments: tuple[Moment, ...]
    truth_m: FloatArray

    def error_m(self, xy_m: FloatArray) -> float:
        """Mean distance of (n, 2) places from the truth."""
        return float(np.hypot(*(xy_m - self.truth_m).T).mean())


def told(
    seed: int, steps: int = 80, turn_rad: float = 0.0, north: bool = True, scale: float = 1.0, askew_rad: float = 0.0
) -> Told:
    """A walk whose errors are those of the walking model: of steps, of turns, and of fixes, own and lasting.

    Parameters
    ----------
    turn_rad : at every step.  north : whether the phone knows it; if not, its headings are off by any angle.
    scale : of the true steps, beside what the phone believes.  askew_rad : of the phone, beside the way.
    """
    rng = np.random.default_rng(seed)
    heading_rad, place_m = float(rng.uniform(-math.pi, math.pi)), np.array([50.0, 50.0])
    off_rad = askew_rad if north else float(rng.uniform(-math.pi, math.pi))
    lasting = rng.normal(size=2) * math.sqrt(LASTING_M2)
    kept = math.exp(-STEP_M / REACH_M)
    evidence: list[Step | RadioFix] = []
    truth = []
    for number in range(steps):
        end_s = (number + 1) * STEP_S
        turned = turn_rad + float(rng.normal()) * 0.01
        middle_rad = heading_rad + 0.5 * turned
        step_m = scale * STEP_M + float(rng.normal()) * 0.05
        place_m = place_m + step_m * np.array([math.sin(middle_rad), math.cos(middle_rad)])
        heading_rad += turned
        lasting = kept * lasting + rng.normal(size=2) * math.sqrt(LASTING_M2 * (1.0 - kept**2))
        phone_rad = math.remainder(heading_rad + off_rad, math.tau)
        sigma_rad = 0.2 if north else math.pi
        change_rad = turned + float(rng.normal()) * 0.005
        evidence.append(Step(end_s, STEP_S, STEP_M, phone_rad, sigma_rad, change_rad, math.nan))
        truth.append(place_m)
        if number % STEPS_A_FIX == 0:
            seen_m = place_m + lasting + rng.normal(size=2) * math.sqrt(OWN_M2)
            evidence.append(RadioFix(end_s, "F1", seen_m, OWN_M2 * np.eye(2), LASTING_M2, 0.1, fits=True))
    moments = tuple(Moment((number + 1) * STEP_S, Motion.WALKING) for number in range(steps))
    return Told(tuple(evidence), moments, np.array(truth))
