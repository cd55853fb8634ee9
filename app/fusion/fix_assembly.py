"""A method's estimate as the Fix that goes back to the phone."""

from __future__ import annotations

from dataclasses import dataclass

from app.estimation.arrays import FloatArray
from app.fusion.interface import SessionStart
from app.integrity.protection_level import ACCURACY_SHARE, protection_level_m, radius_holding
from app.observations import Carrying, Excluded, Fix, Flag, InnovationCheck, Integrity, Motion, Position


@dataclass(frozen=True, slots=True)
class Phases:
    """What integrity monitoring last found.

    disagreement_m : distance between the estimate and an observation that was taken out; 0 where none was.
    excluded : observations taken out.
    covers_m : what the protection level must reach at least, because the walker may be at another place.
    """

    if1: int = 0
    if2: int = 0
    if3: int = 0
    statistic: float | None = None
    threshold: float | None = None
    disagreement_m: float = 0.0
    excluded: tuple[Excluded, ...] = ()
    covers_m: float = 0.0


@dataclass(frozen=True, slots=True)
class Walker:
    """What the inertial sensors say beside the position. heading and speed : None where nothing is known."""

    heading_rad: float | None
    speed_mps: float | None
    step_count: int
    motion: Motion
    carrying: Carrying


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """A position with its covariance (2, 2).

    tail : how heavy the tails of its errors are (1: a Gaussian's).  accuracy_m, level_m : radii that hold 68 % and
    1 - risk, of an estimate that knows them better than its covariance does.
    """

    position: Position
    covariance_m2: FloatArray
    tail: float = 1.0
    accuracy_m: float | None = None
    level_m: float | None = None


def flag_of(phases: Phases, coasting: bool) -> Flag:
    """The one word for what was found; a fault outweighs silence, silence outweighs what was found before it."""
    if phases.if3:
        return Flag.FAULT
    if coasting:
        return Flag.COASTING
    if phases.if2:
        return Flag.OUTLIER
    return Flag.CORRECTED if phases.if1 else Flag.NOMINAL


def no_fix(start: SessionStart, time_s: float | None, walker: Walker) -> Fix:
    """The answer while there is no position."""
    integrity = Integrity(
        flag=Flag.INITIALISING,
        usable=False,
        if1=0,
        if2=0,
        if3=0,
        statistic=None,
        threshold=None,
        protection_level_m=None,
        alert_limit_m=start.alert_limit_m,
        risk=start.risk,
    )
    return Fix(time_s, None, None, None, None, None, walker.step_count, walker.motion, walker.carrying, integrity)


def assembled_fix(
    start: SessionStart,
    time_s: float | None,
    estimate: Estimate,
    walker: Walker,
    phases: Phases,
    coasting: bool,
    checks: tuple[InnovationCheck, ...],
) -> Fix:
    """The answer with a position; accuracy and protection level follow from its covariance where it has no own."""
    spread = estimate.covariance_m2
    level_m, accuracy_m = estimate.level_m, estimate.accuracy_m
    if level_m is None:
        level_m = protection_level_m(spread, start.risk, estimate.tail, phases.disagreement_m)
    if accuracy_m is None:
        accuracy_m = radius_holding(spread, ACCURACY_SHARE)
    level_m = max(level_m, phases.covers_m)
    integrity = Integrity(
        flag=flag_of(phases, coasting),
        usable=not phases.if3 and level_m <= start.alert_limit_m,
        if1=phases.if1,
        if2=phases.if2,
        if3=phases.if3,
        statistic=phases.statistic,
        threshold=phases.threshold,
        protection_level_m=max(level_m, accuracy_m),
        alert_limit_m=start.alert_limit_m,
        risk=start.risk,
        excluded=phases.excluded,
    )
    xy = float(spread[0, 1])
    return Fix(
        time_s=time_s,
        position=estimate.position,
        accuracy_m=accuracy_m,
        covariance_m2=((float(spread[0, 0]), xy), (xy, float(spread[1, 1]))),
        heading_rad=walker.heading_rad,
        speed_mps=walker.speed_mps,
        step_count=walker.step_count,
        motion=walker.motion,
        carrying=walker.carrying,
        integrity=integrity,
        checks=checks,
    )
