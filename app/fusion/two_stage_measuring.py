"""Method B's measurements beside the WiFi fix: steps, and the direction that the newest fixes show."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.fusion import position_ekf as ekf
from app.fusion.heading_search import HeadingSearch, sigma_of, sought
from app.fusion.position_ekf import StepTrack
from app.fusion.two_stage_settings import TwoStageSettings
from app.fusion.wifi_direction import direction_of
from app.observations import InnovationCheck, Step
from app.pdr.attitude_ekf import EulerState


def after_step(
    track: StepTrack,
    step: Step,
    attitude: EulerState,
    turns: bool,
    settings: TwoStageSettings,
    checks: list[InnovationCheck],
) -> StepTrack:
    """The track after a step. turns : whether the phone has a gyroscope; without one the compass has to do."""
    absolute = step.absolute
    pointed_rad = attitude.heading_at(step.time_s) if turns else None
    pointed_rad = math.nan if pointed_rad is None else pointed_rad
    turn_rad = pointed_rad - track.pointed_rad if attitude.stretch == track.stretch else math.nan
    if not math.isfinite(turn_rad):  # the first step, or a gap: what was known of the heading is not any more
        turn_rad = 0.0
        if not math.isnan(track.pointed_rad) or not turns:
            track = replace(track, headed=False)
    if not track.headed and absolute:
        track = ekf.headed(track, step.heading_rad, step.heading_sigma_rad)
        turn_rad = 0.0
    track = ekf.stepped(track, turn_rad, settings.position)
    innovation_m = step.length_m - float(track.mean[ekf.LENGTH])
    variance_m2 = settings.position.fix_length_m2
    track = _one(track, "step", step.time_s, ekf.LENGTH, innovation_m, variance_m2, checks)
    return replace(track, pointed_rad=pointed_rad, stretch=attitude.stretch, stride_s=step.duration_s)


def after_direction(
    track: StepTrack, fixes_m: FloatArray, time_s: float, settings: TwoStageSettings, checks: list[InnovationCheck]
) -> StepTrack:
    """The track after the direction that fixes (n, 2), oldest first, show; as it was where they show none."""
    direction_rad = direction_of(fixes_m, settings.least_progress_m)
    if direction_rad is None:
        return track
    innovation = wrap(direction_rad - float(track.mean[ekf.HEADING]))
    return _one(track, "direction", time_s, ekf.HEADING, innovation, settings.position.fix_heading_rad2, checks)


def north_sought(track: StepTrack, north: HeadingSearch) -> tuple[StepTrack, HeadingSearch]:
    """The track with a heading where fixes and steps have given it away."""
    north, heading = sought(north, track.mean[:2], sigma_of(track.covariance))
    return (track, north) if heading is None else (ekf.headed(track, *heading), HeadingSearch())


def _one(
    track: StepTrack,
    source: str,
    time_s: float,
    component: int,
    innovation: float,
    variance: float,
    checks: list[InnovationCheck],
) -> StepTrack:
    """The track after a measurement of one component, with its record. The paper fuses all of these: none is tested."""
    sigma = math.sqrt(float(track.covariance[component, component]) + variance)
    value = np.array([innovation])
    statistic = (innovation / sigma) ** 2
    checks.append(InnovationCheck(source, time_s, value, np.array([sigma]), statistic, math.inf, False, True))
    return ekf.measured(track, value, ekf.of(component), np.array([[variance]]))
