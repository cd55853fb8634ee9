"""A method's estimate as the Fix that goes back to the phone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion.interface import SessionStart
from app.fusion.state_codec import storable
from app.integrity.protection_level import ACCURACY_SHARE, protection_level_m, radius_holding
from app.observations import Carrying, Excluded, Fix, Flag, InnovationCheck, Integrity, Motion, Position
from app.pdr.tracker import PdrOutput
from app.wifi.floor_decision import FloorBelief

BEYOND_M = 1e6
"""Stands for a disagreement that is not finite."""
SHORTEST_STRIDE_S = 0.3


@storable
@dataclass(frozen=True, slots=True)
class Phases:
    """What integrity monitoring last found.

    disagreement_m : distance between the estimate and an observation that was taken out; 0 where none was.
    excluded : observations taken out.
    """

    if1: int = 0
    if2: int = 0
    if3: int = 0
    statistic: float | None = None
    threshold: float | None = None
    disagreement_m: float = 0.0
    excluded: tuple[Excluded, ...] = ()


@dataclass(frozen=True, slots=True)
class Walker:
    """What the inertial sensors say beside the position. heading and speed : None where nothing is known."""

    heading_rad: float | None
    speed_mps: float | None
    step_count: int
    motion: Motion
    carrying: Carrying

    @classmethod
    def of(
        cls,
        moved: PdrOutput,
        step_count: int,
        heading_rad: float | None = None,
        stride_m: float | None = None,
        stride_s: float = 1.0,
        carrying: Carrying | None = None,
    ) -> Walker:
        """By dead reckoning. stride_m, stride_s : of the newest step, as the method scales it; None where it says
        nothing.  carrying : where the method knows better."""
        speed_mps = None
        if stride_m is not None and moved.motion is not Motion.UNKNOWN:
            speed_mps = 0.0 if moved.motion is Motion.STILL else stride_m / max(stride_s, SHORTEST_STRIDE_S)
        return cls(heading_rad, speed_mps, step_count, moved.motion, moved.carrying if carrying is None else carrying)


class Positioned(Protocol):
    """Of a method's state: what the answer needs beside the track."""

    @property
    def start(self) -> SessionStart: ...

    @property
    def time_s(self) -> float | None: ...

    @property
    def floor(self) -> FloorBelief | None: ...

    @property
    def radio_s(self) -> float | None: ...

    @property
    def phases(self) -> Phases: ...


class Telling(Protocol):
    """Of a method's settings: silent_after_s without a usable scan the track coasts.  tail : as of Estimate."""

    @property
    def silent_after_s(self) -> float: ...

    @property
    def tail(self) -> float: ...


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


def length_of_m(innovation_m: FloatArray) -> float:
    """Of a disagreement (2,); BEYOND_M of one that is not finite."""
    apart_m = float(np.hypot(*innovation_m))
    return apart_m if math.isfinite(apart_m) else BEYOND_M


def taken_out(apart_m: float, again: bool, observation: str = "wifi") -> Excluded:
    """An observation that was taken out, and why. again : it was not the only one lately."""
    times = "again and again" if again else "this once"
    return Excluded(f"{apart_m:.0f} m from where the steps lead, {times}", observation=observation)


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
    level_m = max(level_m, accuracy_m)
    integrity = Integrity(
        flag=flag_of(phases, coasting),
        usable=not phases.if3 and level_m <= start.alert_limit_m,
        if1=phases.if1,
        if2=phases.if2,
        if3=phases.if3,
        statistic=phases.statistic,
        threshold=phases.threshold,
        protection_level_m=level_m,
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


def fix_at(
    state: Positioned,
    xy_m: FloatArray,
    covariance_m2: FloatArray,
    walker: Walker,
    settings: Telling,
    checks: tuple[InnovationCheck, ...],
) -> Fix:
    """The answer of a track that is at a place (2,) with a covariance (2, 2); none before the first usable scan."""
    if state.floor is None or state.radio_s is None or state.time_s is None:
        return no_fix(state.start, state.time_s, walker)
    position = Position(float(xy_m[0]), float(xy_m[1]), state.floor.floor)
    estimate = Estimate(position, covariance_m2, settings.tail)
    coasting = state.time_s - state.radio_s > settings.silent_after_s
    return assembled_fix(state.start, state.time_s, estimate, walker, state.phases, coasting, checks)
