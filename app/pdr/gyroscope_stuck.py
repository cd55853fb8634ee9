"""A gyroscope that has died and repeats its last reading.

No reading of a sensor in a walker's hand is the same as the one before to the last digit, let alone for half a second.
One that lies still may well be: then nothing is lost by believing it. Nor is a gyroscope given up before a compass can
take its place.
"""

from __future__ import annotations

from numba import njit

from app.estimation.arrays import FloatArray
from app.pdr.attitude_state import REST_S
from app.pdr.compass import NORM

REPEATED_AFTER_S = 0.5
REPEATED_S = 3
"""Of the second row of `rest`: for how long the newest rate has been repeated."""


@njit(cache=True)
def notice_repeats(sample: FloatArray, row: int, interval_s: float, rate: FloatArray, rest: FloatArray) -> None:
    """Keep in `rest` for how long the reading has been the same.

    Parameters
    ----------
    sample : (n, 3) angular rates, of which one row is taken.  rate : (3,) the one before.
    """
    same = sample[row, 0] == rate[0] and sample[row, 1] == rate[1] and sample[row, 2] == rate[2]
    rest[1, REPEATED_S] = rest[1, REPEATED_S] + interval_s if same else 0.0


@njit(cache=True)
def gyroscope_stuck(scalars: FloatArray, rest: FloatArray, magnetic: FloatArray) -> bool:
    """Whether the phone moves, its gyroscope repeats itself, and a compass is there. Arrays as of AttitudeState."""
    repeats = rest[1, REPEATED_S] > REPEATED_AFTER_S
    return bool(repeats and scalars[REST_S] == 0.0 and magnetic[NORM] > 0.0)
