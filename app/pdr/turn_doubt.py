"""Whether the gyroscope can be believed: its turns beside those of the compass, over a stretch of walking.

A gyroscope that has gained a bias turns the track steadily away from the way, and every step seems fine by itself. The
compass is wrong by tens of degrees indoors, but it does not drift: over some seconds the angle between the two wanders
about, and only a broken gyroscope makes it grow at a steady rate. While it does the compass alone leads.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.observations import Step

SPAN_S = 12.0
LEAST_SPAN_S = 9.0
DOUBTED_RAD_PER_S = 0.12
"""Rate at which the angle between both grows. Recorded walks reach it in 0.2 % of their steps; a bias of 0.2 is
noticed after 7 s of half the walks, 9 s of nine in ten."""
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
    doubted : whether its gyroscope is.
    """

    step: Step
    turns: bool = True
    afresh: bool = False
    doubted: bool = False


def led(record: TurnRecord, steps: Sequence[Step], turns: bool) -> tuple[TurnRecord, list[LedStep]]:
    """The record with these steps, and each by the gyroscope, or by the compass while the gyroscope is doubted.

    turns : whether there is a gyroscope.
    """
    found, doubted = list[LedStep](), turns_doubted(record)
    for step in steps:
        record, doubted_before = noted(record, step), doubted
        doubted = turns_doubted(record)
        if not doubted:
            found.append(LedStep(step, turns))
        elif np.isfinite(step.magnetic_heading_rad):
            found.append(LedStep(_by_compass(record, step), turns=False, afresh=not doubted_before, doubted=True))
        else:
            found.append(LedStep(_without_drift(record, step), turns, doubted=True))
    return record, found


def noted(record: TurnRecord, step: Step) -> TurnRecord:
    """The record with one more step; one without a compass says nothing, until all that the record holds is old."""
    kept = record.steps[record.steps[:, 0] >= step.time_s - SPAN_S][-MOST_STEPS:]
    turned_rad = record.turned_rad + step.heading_change_rad
    if not np.isfinite(step.magnetic_heading_rad):
        return TurnRecord(record.steps if len(kept) else kept, turned_rad)
    apart_rad = turned_rad - step.magnetic_heading_rad
    if len(kept):  # the compass's bearing is known to whole turns only
        before_rad = float(kept[-1, 1])
        apart_rad = before_rad + wrap(apart_rad - before_rad)
    return TurnRecord(np.vstack([kept, [step.time_s, apart_rad]]), turned_rad)


def turns_doubted(record: TurnRecord) -> bool:
    """Whether the gyroscope and the compass drift apart steadily."""
    time_s = record.steps[:, 0]
    if len(time_s) < LEAST_STEPS or time_s[-1] - time_s[0] < LEAST_SPAN_S:
        return False
    return abs(_drift_rad_per_s(record)) > DOUBTED_RAD_PER_S


def _drift_rad_per_s(record: TurnRecord) -> float:
    """The rate at which the angle between both grows. The record spans some time."""
    time_s, apart_rad = record.steps.T
    from_middle_s = time_s - time_s.mean()
    return float(from_middle_s @ apart_rad / (from_middle_s @ from_middle_s))


def _by_compass(record: TurnRecord, step: Step) -> Step:
    """The newest step of a record, its direction and its turn by the compass."""
    (before_s, before_rad), (now_s, now_rad) = record.steps[-2:].tolist()
    share = min(step.duration_s / (now_s - before_s), 1.0) if now_s > before_s else 1.0
    return replace(
        step,
        heading_rad=step.magnetic_heading_rad,
        heading_sigma_rad=COMPASS_SIGMA_RAD,
        heading_change_rad=float(wrap(step.heading_change_rad - share * (now_rad - before_rad))),
    )


def _without_drift(record: TurnRecord, step: Step) -> Step:
    """A step that the compass says nothing of: its turn by the gyroscope, as if it drifted as before."""
    drifted_rad = _drift_rad_per_s(record) * step.duration_s
    return replace(step, heading_sigma_rad=math.pi, heading_change_rad=step.heading_change_rad - drifted_rad)
