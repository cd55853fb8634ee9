"""Steps from the norm of the acceleration: its swings in the walking band, told from handling by their rhythm.

Equation 15 of the integrity paper (norm minus gravity, smoothed, peaks above a height and a time threshold).

Differs from the paper: samples of any rate are first averaged over cells of 20 ms, so that the filters see one rate and
the answer does not depend on the phone's; the height threshold follows the walker; peaks count only in a rhythm that
legs can have, with the force mostly along gravity, and without the spin of a phone that is turned about in the hand.
The first steps after standing are held back until the rhythm is there, then given with their true times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from app.estimation.arrays import FloatArray
from app.pdr.attitude import COMPASS, GAP_S, HEADING, RATE, SIZE, TURNED, VARIANCE, VERTICAL
from app.pdr.rhythm import (
    HELD,
    PERIOD,
    REVERSAL_FLOOR_MPS2,
    REVERSAL_SHARE,
    RHYTHM_STEPS,
    RUN,
    S_COS,
    S_COUNT,
    S_MCOS,
    S_MCOUNT,
    S_MSIN,
    S_SIN,
    S_TURNED,
    S_VAR,
    STEP_S,
    TAU_FORGET_S,
    TAU_SPIN_S,
    USUAL,
    judge,
    no_walk_yet,
)

CELL_S = 0.02
LOWPASS_HZ = 3.0
"""Above the second harmonic's worth of a slow walk, below impacts and tremor."""
_C = math.tan(math.pi * LOWPASS_HZ * CELL_S)
_D = 1.0 + math.sqrt(2.0) * _C + _C * _C
B0, A1, A2 = _C * _C / _D, 2.0 * (_C * _C - 1.0) / _D, (1.0 - math.sqrt(2.0) * _C + _C * _C) / _D
DELAY_CELLS = 4
"""Delay of the low-pass at walking frequencies: headings wait for as long, and steps are dated back by it."""

TAU_STILL_S, STILL_BELOW_MPS2, STILL_ABOVE_MPS2, STILL_AFTER_S = 0.3, 0.3, 0.5, 0.5
"""Standing with the phone in the hand leaves 0.1 to 0.2 m/s^2, the slowest walk 0.7."""

(IN1, IN2, OUT1, OUT2, VIN1, VIN2, VOUT1, VOUT2, SIDE, PEAK, PEAK_S, TROUGH, VMAX, VMIN,
 SPIN2, MEAN, SQUARE, CALM_S, STILL_SINCE_S, SUM_SIZE, SUM_VERTICAL, CELL, SAMPLE_S) = range(23)  # fmt: skip


def _no_signal_yet() -> FloatArray:
    signal = np.zeros(23)
    signal[SAMPLE_S], signal[STILL_SINCE_S] = -math.inf, math.nan
    return signal


@dataclass(frozen=True, slots=True, eq=False)
class StepState:
    """What the detector remembers.

    signal : (23,) of the filters, by the names above.  walk : (14,) of the rhythm.  sample : (7,) newest of `track`.
    sums : (8,) of heading, variance and compass over all cells so far, and the turn.  delayed : (DELAY_CELLS, 8) the
    sums of the last cells.  marks : (3, 8) the sums at the last step, the trough and the peak.
    held : (RHYTHM_STEPS + 1, 8) steps awaiting their rhythm.
    """

    signal: FloatArray = field(default_factory=_no_signal_yet)
    walk: FloatArray = field(default_factory=no_walk_yet)
    sample: FloatArray = field(default_factory=lambda: np.zeros(7))
    sums: FloatArray = field(default_factory=lambda: np.zeros(8))
    delayed: FloatArray = field(default_factory=lambda: np.zeros((DELAY_CELLS, 8)))
    marks: FloatArray = field(default_factory=lambda: np.zeros((3, 8)))
    held: FloatArray = field(default_factory=lambda: np.zeros((RHYTHM_STEPS + 1, 8)))

    def arrays(self) -> tuple[FloatArray, ...]:
        """Writable copies in the order of `detect`'s arguments."""
        return (
            self.signal.copy(),
            self.walk.copy(),
            self.sample.copy(),
            self.sums.copy(),
            self.delayed.copy(),
            self.marks.copy(),
            self.held.copy(),
        )


@njit(cache=True)
def _end_cell(
    now_s: float,
    size: float,
    vertical: float,
    s: FloatArray,
    walk: FloatArray,
    sample: FloatArray,
    sums: FloatArray,
    delayed: FloatArray,
    marks: FloatArray,
    held: FloatArray,
    answer: FloatArray,
    count: int,
) -> int:
    """Take one finished cell of 20 ms that ends at now_s."""
    sums[S_SIN] += math.sin(sample[HEADING])
    sums[S_COS] += math.cos(sample[HEADING])
    sums[S_VAR] += sample[VARIANCE]
    if not math.isnan(sample[COMPASS]):
        sums[S_MSIN] += math.sin(sample[COMPASS])
        sums[S_MCOS] += math.cos(sample[COMPASS])
        sums[S_MCOUNT] += 1.0
    sums[S_COUNT] += 1.0
    sums[S_TURNED] = sample[TURNED]
    slot = int(sums[S_COUNT]) % DELAY_CELLS
    past = delayed[slot]

    out = B0 * (size + 2.0 * s[IN1] + s[IN2]) - A1 * s[OUT1] - A2 * s[OUT2]
    s[IN2], s[IN1], s[OUT2], s[OUT1] = s[IN1], size, s[OUT1], out
    up = B0 * (vertical + 2.0 * s[VIN1] + s[VIN2]) - A1 * s[VOUT1] - A2 * s[VOUT2]
    s[VIN2], s[VIN1], s[VOUT2], s[VOUT1] = s[VIN1], vertical, s[VOUT1], up
    s[SPIN2] += CELL_S / TAU_SPIN_S * (sample[RATE] ** 2 - s[SPIN2])
    walk[USUAL] *= 1.0 - CELL_S / TAU_FORGET_S if now_s - walk[STEP_S] > walk[PERIOD] else 1.0

    reversal = max(REVERSAL_FLOOR_MPS2, REVERSAL_SHARE * walk[USUAL])
    if s[SIDE] > 0.0:  # rising, or just past a peak
        if out > s[PEAK]:
            s[PEAK], s[PEAK_S] = out, now_s - (DELAY_CELLS + 0.5) * CELL_S
            marks[2] = past
        s[VMAX] = max(s[VMAX], up)
        if out < s[PEAK] - reversal:
            swing, vertical_swing = s[PEAK] - s[TROUGH], s[VMAX] - s[VMIN]
            count = judge(s[PEAK_S], swing, vertical_swing, s[SPIN2], walk, marks, held, answer, count)
            s[SIDE], s[TROUGH], s[VMIN] = -1.0, out, up
            marks[1] = past
    else:
        if out < s[TROUGH]:
            s[TROUGH] = out
            marks[1] = past
        s[VMIN] = min(s[VMIN], up)
        if out > s[TROUGH] + reversal:
            s[SIDE], s[PEAK], s[PEAK_S], s[VMAX] = 1.0, out, now_s - (DELAY_CELLS + 0.5) * CELL_S, up
            marks[2] = past

    gain = CELL_S / TAU_STILL_S
    s[MEAN] += gain * (size - s[MEAN])
    s[SQUARE] += gain * ((size - s[MEAN]) ** 2 - s[SQUARE])
    if s[SQUARE] < (STILL_BELOW_MPS2 if math.isnan(s[STILL_SINCE_S]) else STILL_ABOVE_MPS2) ** 2:
        s[CALM_S] += CELL_S
        if s[CALM_S] >= STILL_AFTER_S and math.isnan(s[STILL_SINCE_S]):
            s[STILL_SINCE_S] = now_s - s[CALM_S]
    else:
        s[CALM_S], s[STILL_SINCE_S] = 0.0, math.nan
    delayed[slot] = sums
    return count


@njit(cache=True)
def detect(arrays: tuple[FloatArray, ...], time_s: FloatArray, tracked: FloatArray, answer: FloatArray) -> int:
    """Advance the detector over samples of the accelerometer.

    Parameters
    ----------
    arrays : the seven arrays of StepState, changed in place.
    time_s : (n,) seconds, non-decreasing.  tracked : (n, 7) what `attitude.track` says of each sample.
    answer : (m, 7) written: time (s), duration (s), swing of the acceleration (m/s^2), heading and its variance,
        turn since the step before (rad), bearing by the compass (rad or NaN).

    Returns
    -------
    How many rows of the answer are steps.
    """
    s, walk, sample, sums, delayed, marks, held = arrays
    count = 0
    for i in range(len(time_s)):
        now = time_s[i]
        size, vertical = tracked[i, SIZE], tracked[i, VERTICAL]
        if now - s[SAMPLE_S] > GAP_S:
            # start over: the filters settled on this sample, nothing pending
            s[CELL] = math.floor(now / CELL_S)
            filled = now - s[CELL] * CELL_S
            s[SUM_SIZE], s[SUM_VERTICAL] = size * filled, vertical * filled
            s[IN1] = s[IN2] = s[OUT1] = s[OUT2] = s[MEAN] = size
            s[VIN1] = s[VIN2] = s[VOUT1] = s[VOUT2] = vertical
            s[SQUARE], s[CALM_S], s[STILL_SINCE_S] = 1.0, 0.0, math.nan
            s[SIDE], s[TROUGH], s[VMIN], walk[RUN], walk[HELD], s[SPIN2] = -1.0, size, vertical, 0.0, 0.0, 0.0
            marks[1] = sums
            delayed[:] = sums
        else:
            begin, first, first_up = s[SAMPLE_S], sample[SIZE], sample[VERTICAL]
            slope = (size - first) / (now - begin) if now > begin else 0.0
            slope_up = (vertical - first_up) / (now - begin) if now > begin else 0.0
            at = begin
            while (s[CELL] + 1.0) * CELL_S <= now:
                end = (s[CELL] + 1.0) * CELL_S
                middle = 0.5 * (at + end) - begin
                s[SUM_SIZE] += (first + slope * middle) * (end - at)
                s[SUM_VERTICAL] += (first_up + slope_up * middle) * (end - at)
                size_mean, vertical_mean = s[SUM_SIZE] / CELL_S, s[SUM_VERTICAL] / CELL_S
                count = _end_cell(
                    end, size_mean, vertical_mean, s, walk, sample, sums, delayed, marks, held, answer, count
                )
                s[CELL] += 1.0
                s[SUM_SIZE], s[SUM_VERTICAL], at = 0.0, 0.0, end
            middle = 0.5 * (at + now) - begin
            s[SUM_SIZE] += (first + slope * middle) * (now - at)
            s[SUM_VERTICAL] += (first_up + slope_up * middle) * (now - at)
        sample[:] = tracked[i]
        s[SAMPLE_S] = now
    return count
