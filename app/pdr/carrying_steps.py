"""What counts as a step, and how long it is, by where the phone is carried.

Unconstrained-smartphones paper section 5.1, its equations 5 and 6: a peak of the acceleration's norm above a height
and a time threshold, and a length that is linear in step frequency and variance, both with constants by position.

Differs from the paper: the peaks are those that app/pdr/step_detection.py found in a rhythm that legs can have; the
thresholds here come on top of it. The paper trains the constants for each user; these are of nobody in particular.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray
from app.observations import Carrying
from app.pdr.carried_state import NORM
from app.pdr.gravity import GRAVITY_MPS2

PERIOD_SHARE = 2.0 / 3.0
"""Of the usual time between steps that two of them are apart at least."""
SHORTEST_M, LONGEST_M = 0.3, 1.0
SHORTEST_STEP_S = 0.3


@dataclass(frozen=True, slots=True)
class StepConstants:
    """Of one carrying position.

    peak_mps2 : A_Th, of the norm above gravity.  per_hz_m, per_variance_m, offset_m : alpha, beta, gamma of the length.
    sigma_m : of a step's length beside it.
    """

    peak_mps2: float
    per_hz_m: float
    per_variance_m: float
    offset_m: float
    sigma_m: float


HANDHELD = StepConstants(1.0, -0.497, 1.58e-3, 1.586, 0.15)
"""Measured: least squares over 296 ways between waypoints of the mall walks of folds 1-4, of all of whose steps 99 %
peak above 1.9 m/s^2. Ways' lengths come out within 13 % (68 %), people differ by 12 %."""
POCKET = StepConstants(0.5, -0.145, 4.2e-3, 0.851, 0.15)
CALL = StepConstants(0.5, -0.023, 6.5e-3, 0.640, 0.15)
SWINGING = StepConstants(0.8, -0.218, 6.9e-3, 1.034, 0.15)
"""Least squares over the steps of 20 simulated people in each position; nobody recorded measured lengths there."""
OF: dict[Carrying, StepConstants] = {
    Carrying.HANDHELD: HANDHELD,
    Carrying.POCKET: POCKET,
    Carrying.CALL: CALL,
    Carrying.SWINGING: SWINGING,
}


def constants_of(carrying: Carrying) -> StepConstants:
    """Of a position; of an unknown one those of the hand."""
    return OF.get(carrying, HANDHELD)


def is_step(cells: FloatArray, interval_s: float, usual_s: float, carrying: Carrying) -> bool:
    """Whether a peak passes both thresholds, Eq. 5.

    Parameters
    ----------
    cells : (n, 8) of the step.  interval_s : since the step before.  usual_s : what that mostly is, or NaN.
    """
    if math.isfinite(usual_s) and interval_s < PERIOD_SHARE * usual_s:
        return False
    return len(cells) == 0 or float(cells[:, NORM].max()) - GRAVITY_MPS2 > constants_of(carrying).peak_mps2


def step_length_m(cells: FloatArray, duration_s: float, carrying: Carrying) -> float:
    """alpha frequency + beta variance + gamma, Eq. 6, within what legs can do."""
    own = constants_of(carrying)
    variance = float(np.var(cells[:, NORM])) if len(cells) else 0.0
    length_m = own.per_hz_m / max(duration_s, SHORTEST_STEP_S) + own.per_variance_m * variance + own.offset_m
    return min(max(length_m, SHORTEST_M), LONGEST_M)
