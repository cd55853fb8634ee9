"""Whether the gyroscope can be believed: its turns beside those of the compass, over a stretch of walking.

A gyroscope that has gained a bias turns the track steadily away from the way, and every step seems fine by itself. The
compass is wrong by tens of degrees indoors, but it does not drift: over some seconds the angle between the two wanders
about, and only a broken gyroscope makes it grow at a steady rate. While it does the compass alone leads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.observations import Step

SPAN_S = 12.0
LEAST_SPAN_S = 9.0
DOUBTED_RAD_PER_S = 0.1
"""Rate at which the angle between both grows. Recorded walks reach it in 0.4 % of their steps; a bias twice as large is
noticed after 6 s of half the walks, 8 s of nine in ten."""
COMPASS_SIGMA_RAD = 0.6
"""Of a step's direction by the compass alone."""
LEAST_STEPS = 10
MOST_STEPS = 40


@dataclass(frozen=True, slots=True, eq=False)
class TurnRecord:
    """steps : (n, 2) of the last seconds with a compass, oldest first: time (s), and the turn by the gyroscope since
    the record began less the compass's bearing (rad, unwrapped)."""

    steps: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    turned_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class LedStep:
    """A step by whatever can be believed.

    turns : whether its turn is known by a gyroscope.
    afresh : whether the directions of the steps before it were wrong.
    """

    step: Step
    turns: bool = True
    afresh: bool = False


def led(record: TurnRecord, steps: Sequence[Step], turns: bool) -> tuple[TurnRecord, list[LedStep]]:
    """The record with these steps, and each by the gyroscope, or by the compass while the gyroscope is doubted.

    turns : whether there is a gyroscope.
    """
    found = list[LedStep]()
    for step in steps:
        doubted_before, record = turns_doubted(record), noted(record, step)
        if turns_doubted(record):
            found.append(LedStep(_by_compass(record, step), False, not doubted_before))
        else:
            found.append(LedStep(step, turns, False))
    return record, found


def noted(record: TurnRecord, step: Step) -> TurnRecord:
    """The record with one more step; without a compass it says nothing and begins anew."""
    if not np.isfinite(step.magnetic_heading_rad):
        return TurnRecord()
    turned_rad = record.turned_rad + step.heading_change_rad
    apart_rad = turned_rad - step.magnetic_heading_rad
    if len(record.steps):  # the compass's bearing is known to whole turns only
        before_rad = float(record.steps[-1, 1])
        apart_rad = before_rad + wrap(apart_rad - before_rad)
    kept = record.steps[record.steps[:, 0] >= step.time_s - SPAN_S][-MOST_STEPS:]
    return TurnRecord(np.vstack([kept, [step.time_s, apart_rad]]), turned_rad)


def turns_doubted(record: TurnRecord) -> bool:
    """Whether the gyroscope and the compass drift apart steadily."""
    time_s, apart_rad = record.steps[:, 0], record.steps[:, 1]
    if len(time_s) < LEAST_STEPS or time_s[-1] - time_s[0] < LEAST_SPAN_S:
        return False
    from_middle_s = time_s - time_s.mean()
    rate = float(from_middle_s @ apart_rad / (from_middle_s @ from_middle_s))
    return abs(rate) > DOUBTED_RAD_PER_S


def _by_compass(record: TurnRecord, step: Step) -> Step:
    """The newest step of a record, its direction and its turn by the compass."""
    before_rad, now_rad = record.steps[-2:, 1].tolist()
    return replace(
        step,
        heading_rad=step.magnetic_heading_rad,
        heading_sigma_rad=COMPASS_SIGMA_RAD,
        heading_change_rad=float(wrap(step.heading_change_rad - (now_rad - before_rad))),
    )
