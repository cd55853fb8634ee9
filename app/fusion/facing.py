"""How a phone is held: the angle between where it points and where its walker goes, learnt from fixes.

A phone in a pocket, across, or in a building whose plan is not drawn north up, tells headings that are off by one and
the same angle. Steps by such headings lead the track away from the fixes, turned about where both were together: so the
way by steps, turned as a whole, must fit the way by fixes (Procrustes). One angle is taken for another only on strong
evidence, since fixes err by metres, alike for a while.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.fusion.state_codec import storable
from app.pdr.turn_doubt import LedStep


@dataclass(frozen=True, slots=True)
class FacingSettings:
    """When an angle is taken for another.

    fixes : of the last ones.  least_fixes : before which nothing is said.
    lasting : by what the variance of a fix counts more: errors last, so the next fix is not another witness.
    evidence : logarithm of how much likelier the fixes are if the way is turned.
    misfit_m : how far from the turned way any fix may be: one that leaps is no matter of how the phone is held.
    longest : by what the way by fixes may be longer than that by steps: a leap makes it longer.
    least_rad : a way turned by less is the compass's error: of 208 recorded walks four are, by 30 to 56 degrees.
    """

    fixes: int = 16
    least_fixes: int = 5
    lasting: float = 2.0
    evidence: float = 5.0
    misfit_m: float = 15.0
    longest: float = 1.5
    least_rad: float = 1.0


@storable
@dataclass(frozen=True, slots=True, eq=False)
class FacingRecord:
    """How a phone is held, and what may yet speak against it.

    angle_rad : from where the phone points to the walking direction.
    walked_m : (2,) way by steps, before any scale, since the record began.  ways : (n, 5) it at each of the last fixes,
    the fix, and its variance.
    """

    angle_rad: float = 0.0
    walked_m: FloatArray = field(default_factory=lambda: np.zeros(2))
    ways: FloatArray = field(default_factory=lambda: np.empty((0, 5)))


def faced(record: FacingRecord, steps: Sequence[LedStep]) -> tuple[FacingRecord, list[LedStep]]:
    """The record with these steps, and each in the direction in which its walker went.

    The fixes before a step without north, or before one whose directions begin afresh, say nothing any more.
    """
    found = list[LedStep]()
    for one in steps:
        step = one.step
        if one.afresh or not step.absolute:
            record = FacingRecord(record.angle_rad)
        if step.absolute:
            step = replace(step, heading_rad=float(wrap(step.heading_rad + record.angle_rad)))
            way_m = step.length_m * np.array([math.sin(step.heading_rad), math.cos(step.heading_rad)])
            record = replace(record, walked_m=record.walked_m + way_m)
        found.append(replace(one, step=step))
    return record, found


def placed(
    record: FacingRecord, xy_m: FloatArray, variance_m2: float, believed: bool, settings: FacingSettings
) -> tuple[FacingRecord, bool]:
    """The record with one more fix, and whether the phone turns out to be held otherwise.

    Parameters
    ----------
    xy_m : (2,) the fix.  variance_m2 : of its error in each direction.
    believed : False of a fix while others contradict the track: a way walked elsewhere, and relayed, is turned, too.
    """
    if not believed:
        return FacingRecord(record.angle_rad), False
    ways = np.vstack([record.ways, [*record.walked_m, *xy_m, variance_m2]])[-settings.fixes :]
    record = replace(record, ways=ways)
    if len(ways) < settings.least_fixes:
        return record, False
    information = 1.0 / (settings.lasting * ways[:, 4])
    apart_m = ways[:, :4] - information @ ways[:, :4] / information.sum()
    by_steps, by_fixes = apart_m[:, 0] + 1j * apart_m[:, 1], apart_m[:, 2] + 1j * apart_m[:, 3]
    alike = complex((information * by_fixes) @ by_steps.conj())
    turn_rad = cmath.phase(alike)
    if abs(alike) - alike.real < settings.evidence or abs(turn_rad) < settings.least_rad:
        return record, False
    longer = abs(alike) / float(information @ np.abs(by_steps) ** 2)
    misfit_m = np.abs(by_fixes - cmath.exp(1j * turn_rad) * by_steps)
    if longer > settings.longest or misfit_m.max() > settings.misfit_m:
        return record, False
    # angles in the plane turn from east to north, headings from north to east
    return FacingRecord(float(wrap(record.angle_rad - turn_rad))), True
