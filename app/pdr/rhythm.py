"""Which swings of the acceleration are steps: those in a rhythm that legs can have.

Differs from the papers, which count every peak above a height and a time threshold: a phone that is waved about makes
such peaks too. A walk begins with a few regular swings, mostly along gravity, no higher than a body bounces; it goes on
with steps near its period, left and right each like itself; it ends when the rhythm does.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.estimation.arrays import FloatArray

REVERSAL_FLOOR_MPS2, REVERSAL_SHARE, TAU_FORGET_S = 1.2, 0.4, 3.0
"""A swing counts from the floor or this share of the walker's usual swing, which fades without steps."""
SHORTEST_S, SHORTEST_FIRST_S, LONGEST_S = 0.30, 0.37, 0.95
"""Walking is 1.2 to 2.6 steps a second, a stroll 1.05; nobody starts to walk faster than that."""
BOUNCE_M = 0.07
"""Half the way up and down that a swing implies; a body's centre moves by 0.02 to 0.04, a thigh by 0.05."""
RHYTHM_STEPS, RHYTHM_RATIO, SWING_RATIO, START_SWING_MPS2 = 3, 1.4, 2.5, 2.4
"""A walk begins with so many intervals that differ by no more, with swings of at least that on average."""
RECENT_S, RHYTHM_AGAIN = 20.0, 1
"""Who walked so recently walks again after so many intervals, if they are like those before."""
WARM_S, EARLY, LATE = 4.0, 0.62, 1.6
"""A walk goes on with steps between these shares of its period; one pause of up to so long does not end it."""
ROUGH_LIMIT = 0.15
"""A walk ends where the logarithm of interval to period strays by more on average of some four steps."""
VERTICAL_SHARE = 0.6
"""Of the swing, along gravity. Walking: 0.7 and more in a trouser pocket, 0.95 in the hand; shaken level: 0."""
SPIN_LIMIT, TAU_SPIN_S, FOREARM_M = 4.5, 0.5, 0.4
"""rad/s, root mean square: swinging arms and thighs stay below (45 degrees at 1 Hz: 3.5). No walk begins with less
acceleration than turning the phone at the forearm's length explains."""
USUAL_PERIOD_S = 0.55
STEP_OVERDUE = 1.8
"""Of a step's duration: so long after it, without the next, the walker has stopped."""

(USUAL, PERIOD, LAST_S, LAST_CANDIDATE_S, RUN_SHORT, RUN_LONG, RUN, STEP_S,
 LAST_TURNED, HELD, PAUSED, ROUGH, BEFORE_1, BEFORE_2) = range(14)  # fmt: skip
S_SIN, S_COS, S_VAR, S_MSIN, S_MCOS, S_MCOUNT, S_COUNT, S_TURNED = range(8)
STEP_TIME, STEP_DURATION, STEP_SWING, STEP_HEADING, STEP_VARIANCE, STEP_CHANGE, STEP_COMPASS = range(7)
"""Columns of a step."""


def no_walk_yet() -> FloatArray:
    """What is known of the walk (14,) before the first swing."""
    walk = np.zeros(14)
    walk[[LAST_S, LAST_CANDIDATE_S, STEP_S]] = -math.inf
    walk[LAST_TURNED], walk[PERIOD] = math.nan, USUAL_PERIOD_S
    return walk


@njit(cache=True)
def _write(step: FloatArray, row: FloatArray, walk: FloatArray) -> None:
    """One held row to the answer; the turn since the step before is known only now."""
    row[:7] = step[:7]
    row[STEP_CHANGE] = 0.0 if math.isnan(walk[LAST_TURNED]) else step[STEP_CHANGE] - walk[LAST_TURNED]
    walk[LAST_TURNED] = step[STEP_CHANGE]
    walk[STEP_S] = step[STEP_TIME]


@njit(cache=True)
def _hold(at: float, swing: float, walk: FloatArray, marks: FloatArray, held: FloatArray) -> None:
    """Note a possible step in the next free row, with the averages since the last one."""
    near = at - walk[LAST_S] <= LONGEST_S
    base, peak = marks[0] if near else marks[1], marks[2]
    cells = max(peak[S_COUNT] - base[S_COUNT], 1.0)
    heard = peak[S_MCOUNT] - base[S_MCOUNT] > 0.5
    step = held[int(walk[HELD])]
    step[STEP_TIME], step[STEP_DURATION], step[STEP_SWING] = at, at - walk[LAST_S] if near else walk[PERIOD], swing
    step[STEP_HEADING] = math.atan2(peak[S_SIN] - base[S_SIN], peak[S_COS] - base[S_COS])
    step[STEP_VARIANCE] = max(peak[S_VAR] - base[S_VAR], 0.0) / cells
    step[STEP_CHANGE] = peak[S_TURNED]
    step[STEP_COMPASS] = math.atan2(peak[S_MSIN] - base[S_MSIN], peak[S_MCOS] - base[S_MCOS]) if heard else math.nan
    walk[HELD] += 1.0
    walk[LAST_S] = at
    marks[0] = peak


@njit(cache=True)
def _goes_on(at: float, swing: float, walk: FloatArray) -> int:
    """Does this swing continue the walk? 1: a step; 0: a bump between two; -1: no, it may begin another walk."""
    gap = at - walk[STEP_S]
    if walk[USUAL] == 0.0 or gap > WARM_S:
        return -1
    if gap < max(EARLY * walk[PERIOD], SHORTEST_S):
        return 0
    if swing < REVERSAL_SHARE * walk[USUAL] or swing > 3.0 * BOUNCE_M * (2.0 * math.pi / walk[PERIOD]) ** 2:
        return -1
    if gap <= LATE * walk[PERIOD]:
        walk[PAUSED] = 0.0
        # left and right may differ, as in a trouser pocket, but each repeats itself
        odd = abs(math.log(gap / walk[PERIOD]))
        odd = min(odd, abs(math.log(gap / walk[BEFORE_2]))) if walk[BEFORE_2] > 0.0 else odd
        walk[ROUGH] += 0.25 * (odd - walk[ROUGH])
        walk[BEFORE_2], walk[BEFORE_1] = walk[BEFORE_1], gap
        if walk[ROUGH] < ROUGH_LIMIT:
            return 1
        walk[USUAL] = 0.0
    elif walk[PAUSED] == 0.0:
        walk[PAUSED] = 1.0
        return 1
    return -1


@njit(cache=True)
def judge(
    at: float,
    swing: float,
    vertical: float,
    spin2: float,
    walk: FloatArray,
    marks: FloatArray,
    held: FloatArray,
    answer: FloatArray,
    count: int,
) -> int:
    """Judge one swing of the acceleration whose peak is past.

    Parameters
    ----------
    at : time of the peak, s.  swing, vertical : from trough to peak, m/s^2, of the norm and along gravity.
    spin2 : mean square of the angular rate, (rad/s)^2; 0 without gyroscope.
    walk : (14,) what is known of the walk.  marks : (3, 8) and held : (RHYTHM_STEPS + 1, 8) as in StepState; in place.
    answer : (m, 7) steps are written from row `count` on.

    Returns
    -------
    How many rows of the answer are steps.
    """
    if spin2 > SPIN_LIMIT**2 or vertical < VERTICAL_SHARE * swing:
        walk[RUN], walk[HELD] = 0.0, 0.0
        return count
    verdict = _goes_on(at, swing, walk)
    if verdict == 0:
        return count
    if verdict > 0:
        walk[HELD], walk[RUN] = 0.0, 0.0
        interval = at - walk[STEP_S]
        _hold(at, swing, walk, marks, held)
        walk[USUAL] += 0.25 * (swing - walk[USUAL])
        if interval <= LATE * walk[PERIOD]:
            walk[PERIOD] += 0.25 * (interval - walk[PERIOD])
    else:
        interval = at - walk[LAST_CANDIDATE_S]
        walk[LAST_CANDIDATE_S] = at
        before = held[max(int(walk[HELD]) - 1, 0), STEP_SWING]
        fits = walk[HELD] > 0.0 and SHORTEST_FIRST_S <= interval <= LONGEST_S
        fits = fits and max(swing, before) < SWING_RATIO * min(swing, before)
        running = walk[RUN] > 0.0
        short = min(walk[RUN_SHORT], interval) if running else interval
        long = max(walk[RUN_LONG], interval) if running else interval
        if fits and long > RHYTHM_RATIO * short:  # the last two may be the beginning
            held[0] = held[int(walk[HELD]) - 1].copy()
            walk[HELD], walk[RUN], short, long = 1.0, 0.0, interval, interval
        elif fits and walk[HELD] > RHYTHM_STEPS:
            held[:RHYTHM_STEPS] = held[1:].copy()
            walk[HELD] = RHYTHM_STEPS
        elif not fits:
            walk[HELD], walk[RUN] = 0.0, -1.0
        _hold(at, swing, walk, marks, held)
        walk[RUN], walk[RUN_SHORT], walk[RUN_LONG] = walk[RUN] + 1.0, short, long
        mean = np.mean(held[: int(walk[HELD]), STEP_SWING])
        again = held[0, STEP_TIME] - walk[STEP_S] < RECENT_S and short > walk[PERIOD] / RHYTHM_RATIO
        again = again and long < walk[PERIOD] * RHYTHM_RATIO
        if walk[RUN] < (RHYTHM_AGAIN if again else RHYTHM_STEPS) or mean < max(START_SWING_MPS2, FOREARM_M * spin2):
            return count
        period = (at - held[0, STEP_TIME]) / walk[RUN]
        if mean > 2.0 * BOUNCE_M * (2.0 * math.pi / period) ** 2:
            return count
        walk[USUAL], walk[PERIOD], walk[PAUSED], walk[ROUGH] = mean, period, 0.0, 0.0
        walk[BEFORE_1] = walk[BEFORE_2] = 0.0
    for k in range(int(walk[HELD])):
        _write(held[k], answer[count], walk)
        count += 1
    walk[HELD], walk[RUN], walk[LAST_CANDIDATE_S] = 0.0, 0.0, at
    return count
