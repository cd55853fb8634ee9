"""Still or moving, as the trust chain tells it: mean and variance of the horizontal acceleration, variance of the norm.

Trust Chain Positioning Fusion, Sensors 2015, 15, 29850, section 3.2.1 (docs/methods/trust_chain.md): still when all
three are below a threshold of their own. Differs from the paper, which names neither thresholds nor windows: means and
variances forget exponentially, and gravity, which the horizontal part is perpendicular to, is the slow mean of the
acceleration itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from app.estimation.arrays import FloatArray
from app.observations import Batch
from app.pdr.tracker import fresh_samples

TAU_GRAVITY_S, TAU_S = 3.0, 0.7
GAP_S = 1.0
HORIZONTAL_MPS2, HORIZONTAL_VARIANCE, SIZE_VARIANCE = 0.5, 0.1, 0.1
"""A phone held by somebody who stands: 0.2 m/s^2, 0.02 and 0.03 (m/s^2)^2; by somebody who walks: 1 and 1 to 4."""
NEWEST_S, GRAVITY, MEAN, VARIANCE, SIZE, SIZE_VARIES = 0, 1, 4, 5, 6, 7


def _unknown() -> FloatArray:
    values = np.zeros(8)
    values[NEWEST_S] = -math.inf
    return values


@dataclass(frozen=True, slots=True, eq=False)
class ShakingState:
    """values : (8,) newest sample (s), gravity (3), and of the horizontal part and the norm the mean and the variance
    about it, m/s^2."""

    values: FloatArray = field(default_factory=_unknown)

    @property
    def still(self) -> bool:
        """Whether the phone is where it was; never before the first sample."""
        values = self.values
        return bool(
            math.isfinite(values[NEWEST_S])
            and values[MEAN] < HORIZONTAL_MPS2
            and values[VARIANCE] < HORIZONTAL_VARIANCE
            and values[SIZE_VARIES] < SIZE_VARIANCE
        )


def advance_shaking(state: ShakingState, batch: Batch, until_s: float | None = None) -> ShakingState:
    """The state after the batch's accelerometer samples that are newer than those seen.

    Parameters
    ----------
    until_s : leave samples later than this for a later call with the same batch.
    """
    time_s, force = fresh_samples(batch.accelerometer, float(state.values[NEWEST_S]), until_s)
    if not len(time_s):
        return state
    values = state.values.copy()
    follow(values, time_s, force)
    return ShakingState(values)


@njit(cache=True)
def follow(values: FloatArray, time_s: FloatArray, force: FloatArray) -> None:
    """Take samples (n,), (n, 3) into the state's values (8,), in place."""
    for i in range(len(time_s)):
        x, y, z = force[i, 0], force[i, 1], force[i, 2]
        interval_s = time_s[i] - values[NEWEST_S]
        values[NEWEST_S] = time_s[i]
        size = math.sqrt(x * x + y * y + z * z)
        if interval_s > GAP_S:  # from here on as if shaken, until shown otherwise
            values[GRAVITY], values[GRAVITY + 1], values[GRAVITY + 2] = x, y, z
            values[MEAN], values[VARIANCE] = 0.0, 4.0 * HORIZONTAL_VARIANCE
            values[SIZE], values[SIZE_VARIES] = size, 4.0 * SIZE_VARIANCE
            continue
        slow, fast = -math.expm1(-interval_s / TAU_GRAVITY_S), -math.expm1(-interval_s / TAU_S)
        values[GRAVITY] += slow * (x - values[GRAVITY])
        values[GRAVITY + 1] += slow * (y - values[GRAVITY + 1])
        values[GRAVITY + 2] += slow * (z - values[GRAVITY + 2])
        gx, gy, gz = values[GRAVITY], values[GRAVITY + 1], values[GRAVITY + 2]
        squared = gx * gx + gy * gy + gz * gz
        along2 = (x * gx + y * gy + z * gz) ** 2 / squared if squared > 0.0 else 0.0
        horizontal = math.sqrt(max(size * size - along2, 0.0))
        values[MEAN] += fast * (horizontal - values[MEAN])
        values[VARIANCE] += fast * ((horizontal - values[MEAN]) ** 2 - values[VARIANCE])
        values[SIZE] += fast * (size - values[SIZE])
        values[SIZE_VARIES] += fast * ((size - values[SIZE]) ** 2 - values[SIZE_VARIES])
