"""How a phone rises and sinks, from its barometer.

A barometer knows heights above nothing, and weather moves it by metres an hour, but within a minute it tells a storey
from none. Samples become means of a second, and seconds heights above an arbitrary level that stays the same for as
long as the sensor reports. A leap that no lift makes (a door between rooms of different pressure, a corrupted value)
moves that level instead of the phone. A sensor that is stuck or far too noisy says nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from app.estimation.arrays import FloatArray
from app.observations import PressureSamples

SCALE_HEIGHT_M = 8500.0
"""R T / (g M) of dry air of 17 degrees: 0.12 hPa a metre near the ground, less where the air is thinner."""
PLAUSIBLE_HPA = (300.0, 1100.0)
"""What phone barometers can measure."""
SMOOTH_S, RECORD_S = 2, 8
"""Seconds whose mean is the height now, and seconds that are kept: it is steady if their halves are alike."""
STEADY_M = 0.35
"""Between the means of the last seconds and of those before: stairs make 0.7 m in that time, a moving staircase 1 m."""
LEAP_M, LEAP_SIGMAS = 4.0, 6.0
"""More than a second can differ from where the two before lead: a lift that sets off gains 1.5 m a second."""
HELD_APART_S = 3.0
"""Without a sample for so long, the seconds before are no part of the mean any more, and leaps cannot be told."""
NOISE_M, NOISIEST_M = 0.15, 1.0
"""Of a second's mean: assumed at first, and that from which a storey cannot be told."""
_FORGETS = 1.0 / 20.0
_STUCK_M = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class HeightRecord:
    """newest_s : time of the newest sample.  second, total_m, count : the second under way, in whole Unix seconds, and
    the sum of its heights.  seconds : (n, 2) the last seconds that are over, oldest first: Unix second and height (m).
    shift_m : what leaps have added so far.  rough_m2 : mean square of second differences, six times a mean's variance.
    """

    newest_s: float = -math.inf
    second: float = -math.inf
    total_m: float = 0.0
    count: int = 0
    seconds: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    shift_m: float = 0.0
    rough_m2: float = 6.0 * NOISE_M**2

    @property
    def height_m(self) -> float:
        """Over the last seconds, above the arbitrary level; NaN before the first second is over."""
        return float(self.seconds[-SMOOTH_S:, 1].mean()) if len(self.seconds) else math.nan

    @property
    def noise_m(self) -> float:
        """Standard deviation of a second's mean."""
        return math.sqrt(self.rough_m2 / 6.0)

    @property
    def steady(self) -> bool:
        """Whether the phone has neither risen nor sunk for some seconds."""
        height_m = self.seconds[:, 1]
        half = RECORD_S // 2
        return len(height_m) == RECORD_S and abs(float(height_m[half:].mean() - height_m[:half].mean())) < STEADY_M

    @property
    def trusted(self) -> bool:
        """Whether the sensor is neither stuck nor all noise."""
        stuck = len(self.seconds) == RECORD_S and float(np.ptp(self.seconds[:, 1])) < _STUCK_M
        return self.noise_m <= NOISIEST_M and not stuck


def measured(record: HeightRecord, samples: PressureSamples, until_s: float | None = None) -> list[HeightRecord]:
    """The record after each second that is over by now, oldest first, and last the record as it is.

    Samples that are older than those before, or that no barometer can measure, are left out.

    Parameters
    ----------
    until_s : leave samples later than this for a later call with the same batch.
    """
    time_s, height_m = _heights(samples, record.newest_s, until_s)
    if not len(time_s):
        return [record]
    found = []
    whole = np.floor(time_s)
    begins = np.flatnonzero(np.diff(whole, prepend=-np.inf))
    totals, counts = np.add.reduceat(height_m, begins), np.diff(np.append(begins, len(whole)))
    for second, total_m, count in zip(whole[begins].tolist(), totals.tolist(), counts.tolist(), strict=True):
        if second == record.second:
            record = replace(record, total_m=record.total_m + total_m, count=record.count + count)
            continue
        if record.count:
            record = _over(record)
            found.append(record)
        record = replace(record, second=second, total_m=total_m, count=count)
    return [*found, replace(record, newest_s=float(time_s[-1]))]


def _heights(samples: PressureSamples, newest_s: float, until_s: float | None) -> tuple[FloatArray, FloatArray]:
    """Times and heights (n,) of the usable samples in (newest_s, until_s]."""
    low, high = PLAUSIBLE_HPA
    time_s, pressure_hpa = samples.time_s, samples.pressure_hpa
    ahead = np.maximum.accumulate(np.concatenate([[newest_s], np.nan_to_num(time_s, nan=-np.inf)]))[:-1]
    usable = np.isfinite(time_s) & (time_s > ahead) & (pressure_hpa >= low) & (pressure_hpa <= high)
    if until_s is not None:
        usable &= time_s <= until_s
    return time_s[usable], -SCALE_HEIGHT_M * np.log(pressure_hpa[usable])


def _over(record: HeightRecord) -> HeightRecord:
    """The record once the second under way is over."""
    height_m, shift_m, rough_m2, kept = record.total_m / record.count, record.shift_m, record.rough_m2, record.seconds
    if len(kept) and record.second - kept[-1, 0] > HELD_APART_S:
        kept = kept[:0]
    height_m += shift_m
    if len(kept) > 1:
        (before_s, before_m), (last_s, last_m) = kept[-2:].tolist()
        bend_m = height_m - last_m - (last_m - before_m) * (record.second - last_s) / (last_s - before_s)
        if abs(bend_m) > max(LEAP_M * (record.second - last_s), LEAP_SIGMAS * math.sqrt(rough_m2)):
            shift_m += last_m - height_m
            height_m = last_m
        # a leap is no noise, but a sensor that leaps all the time is nothing else
        rough_m2 += _FORGETS * (min(bend_m * bend_m, 9.0 * rough_m2) - rough_m2)
        rough_m2 = max(rough_m2, 1e-4)
    seconds = np.vstack([kept[-(RECORD_S - 1) :], [record.second, height_m]])
    return replace(record, count=0, total_m=0.0, seconds=seconds, shift_m=shift_m, rough_m2=rough_m2)
