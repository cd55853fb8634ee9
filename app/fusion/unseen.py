"""How a place gets less certain in time that no step accounts for."""

from __future__ import annotations

from app.estimation.arrays import FloatArray
from app.pdr.tracker import PdrOutput

BLIND_AFTER_S = 2.0
"""Without accelerometer for so long a phone is blind: its steps are counted by nobody."""
BLIND_M2_PER_S = 6.0
"""Growth of the position's variance in each direction for a blind phone. Chosen on folds 1-4 of the mall walks, as all
of these."""
BLIND_SPEED_MPS = 0.7
"""Walking speed assumed of it, for the error of WiFi fixes to change with."""
DOUBTFUL_M2_PER_S = 0.05
"""Growth for a phone that moves and yet makes no steps."""


def is_blind(until_s: float, moved: PdrOutput) -> bool:
    """Whether steps may have been made since that nobody counted."""
    return moved.inertial_until_s is None or until_s - moved.inertial_until_s > BLIND_AFTER_S


def drift_m2_per_s(until_s: float, moved: PdrOutput) -> float:
    """Growth of the variance in each direction; 0 while the walker stands still, or a step is under way."""
    if is_blind(until_s, moved):
        return BLIND_M2_PER_S
    return 0.0 if moved.still_since_s is not None or moved.pending_fraction > 0.0 else DOUBTFUL_M2_PER_S


def drifted(covariance: FloatArray, since_s: float, until_s: float, moved: PdrOutput) -> FloatArray:
    """A copy of a covariance (n, n), whose first components are x and y, after time that no step accounts for."""
    growth_m2 = drift_m2_per_s(until_s, moved) * (until_s - since_s)
    covariance = covariance.copy()
    covariance[0, 0] += growth_m2
    covariance[1, 1] += growth_m2
    return covariance
