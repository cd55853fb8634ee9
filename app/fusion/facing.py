"""How a phone is held: the angle between where it points and where its walker goes, learnt from fixes and steps.

A phone in a pocket, across, or in a building whose plan is not drawn north up, tells headings that are off by one and
the same angle. Steps by such headings lead the track away from the fixes, turned about where both were together: so the
way by steps, turned as a whole, must fit the way by fixes (Procrustes). And each step pushes a phone in the hand to
where its walker goes (app/pdr/push.py). One angle is taken for another only on strong evidence of both together.
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

QUARTER_RAD = 0.5 * math.pi


@dataclass(frozen=True, slots=True)
class FacingSettings:
    """When an angle is taken for another.

    fixes : of the last ones.  least_fixes : before which they say nothing.
    lasting : by what the variance of a fix counts more: errors last, so the next fix is not another witness.
    evidence : logarithm of how much likelier fixes and pushes are if the way is turned.
    fixes_evidence : of the fixes alone, at least: they must not speak against it, for people walk differently.
    misfit_m : how far from the turned way any fix may be: one that leaps is no matter of how the phone is held.
    longest : by what the way by fixes may be longer than that by steps: a leap makes it longer.
    least_rad : a way turned by less is the compass's error: of 208 recorded walks four are, by 30 to 56 degrees.
    push_kept : share of what the steps before pushed that stays with every step.
    push_witnesses : so many steps in a row say no more than one.
    push_least, push_most : concentration (von Mises) of the pushes about where they point: below it they say nothing,
    and never more than by the other, since walkers sway to the side of the hand that holds the phone.
    """

    fixes: int = 16
    least_fixes: int = 3
    lasting: float = 2.0
    evidence: float = 5.0
    fixes_evidence: float = 0.0
    misfit_m: float = 15.0
    longest: float = 1.5
    least_rad: float = 1.0
    push_kept: float = 0.95
    push_witnesses: float = 3.0
    push_least: float = 5.0
    push_most: float = 8.0


@storable
@dataclass(frozen=True, slots=True, eq=False)
class FacingRecord:
    """How a phone is held, and what may yet speak against it.

    angle_rad : from where the phone points to the walking direction.
    walked_m : (2,) way by steps, before any scale, since the record began.  ways : (n, 5) it at each of the last fixes,
    the fix, and its variance.  pushed : (3,) sums of the unit vectors of the last steps' pushes, along and across where
    the phone points, and their number.
    """

    angle_rad: float = 0.0
    walked_m: FloatArray = field(default_factory=lambda: np.zeros(2))
    ways: FloatArray = field(default_factory=lambda: np.empty((0, 5)))
    pushed: FloatArray = field(default_factory=lambda: np.zeros(3))

    def begun_anew(self) -> FacingRecord:
        """The record from now on: the ways until now say nothing any more."""
        return FacingRecord(self.angle_rad, pushed=self.pushed)


def faced(
    record: FacingRecord, steps: Sequence[LedStep], settings: FacingSettings
) -> tuple[FacingRecord, list[LedStep]]:
    """The record with these steps, and each in the direction in which its walker went.

    The fixes before a step without north, or before one whose directions begin afresh, say nothing any more.
    """
    found = list[LedStep]()
    for one in steps:
        step = one.step
        if one.afresh or not step.absolute:
            record = record.begun_anew()
        if math.isfinite(step.push_rad):
            push = np.array([math.cos(step.push_rad), math.sin(step.push_rad), 1.0])
            record = replace(record, pushed=settings.push_kept * record.pushed + push)
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
        return record.begun_anew(), False
    ways = np.vstack([record.ways, [*record.walked_m, *xy_m, variance_m2]])[-settings.fixes :]
    record = replace(record, ways=ways)
    information = 1.0 / (settings.lasting * ways[:, 4])
    apart_m = ways[:, :4] - information @ ways[:, :4] / information.sum()
    by_steps, by_fixes = apart_m[:, 0] + 1j * apart_m[:, 1], apart_m[:, 2] + 1j * apart_m[:, 3]
    # log-likelihood of a turn by t: the real part of exp(-i t) times this
    alike, pushed = complex((information * by_fixes) @ by_steps.conj()), _pushed(record, settings)
    if len(ways) < settings.least_fixes:
        alike = 0j
    turn_rad = cmath.phase(alike + pushed)
    if abs(pushed) > abs(alike):  # in front, across, or the wrong way round: what is between them is the hand's sway
        turn_rad = float(wrap(record.angle_rad - QUARTER_RAD * round((record.angle_rad - turn_rad) / QUARTER_RAD)))
    by_fixes_alone, by_both = (_gain(of, turn_rad) for of in (alike, alike + pushed))
    if by_both < settings.evidence or by_fixes_alone < settings.fixes_evidence or abs(turn_rad) < settings.least_rad:
        return record, False
    longer = abs(alike) > settings.longest * float(information @ np.abs(by_steps) ** 2)
    misfit_m = np.abs(by_fixes - cmath.exp(1j * turn_rad) * by_steps)
    if longer or misfit_m.max() > settings.misfit_m:
        return record, False
    # angles in the plane turn from east to north, headings from north to east
    return replace(record.begun_anew(), angle_rad=float(wrap(record.angle_rad - turn_rad))), True


def _gain(alike: complex, turn_rad: float) -> float:
    """How much likelier a turn is than none, logarithm."""
    return (alike * cmath.exp(-1j * turn_rad)).real - alike.real


def _pushed(record: FacingRecord, settings: FacingSettings) -> complex:
    """What the pushes of the last steps say of a turn: towards it, as long as they are concentrated about it."""
    along, across, number = record.pushed.tolist()
    astray = number - math.hypot(along, across) + 2.0  # two more than were, so that few steps say little
    concentration = min(number**2 / (2.0 * settings.push_witnesses * astray), settings.push_most)
    if concentration < settings.push_least:
        return 0j
    return cmath.rect(concentration, record.angle_rad - math.atan2(across, along))
