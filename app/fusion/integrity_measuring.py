"""Method A's measurements: how steps and scans are turned into observations, tested and fused."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Protocol

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.fusion import walking_ukf as ukf
from app.fusion.fix_assembly import Phases, length_of_m, taken_out
from app.fusion.integrity_settings import IntegritySettings
from app.fusion.walking_track import Track, TrackSettings, headed, stepped
from app.integrity.fault_detection import Monitored, MonitorSettings, monitored_update
from app.observations import Excluded, InnovationCheck, Step
from app.wifi.match import Match

BY_WIFI: IntArray = np.array([ukf.OF_WIFI_X, ukf.OF_WIFI_Y])
_HEADING: IntArray = np.array([ukf.OF_HEADING])
_STEP: IntArray = np.array([ukf.OF_LENGTH, ukf.OF_TURN, ukf.OF_HEADING])
_STEP_BLIND: IntArray = np.array([ukf.OF_LENGTH, ukf.OF_TURN])


class Measuring(Protocol):
    """Of a method's settings: how measurements are tested and fused."""

    @property
    def track(self) -> TrackSettings: ...

    @property
    def monitor(self) -> MonitorSettings: ...


def measure(
    track: Track,
    source: str,
    time_s: float,
    which: IntArray,
    measured: FloatArray,
    noise: FloatArray,
    before: FloatArray,
    forward_m: float,
    settings: Measuring,
) -> tuple[Monitored, InnovationCheck]:
    """Test and fuse one measurement.

    Parameters
    ----------
    which, measured, noise : (m,), (m,), (m, m) observations by number, as in app/fusion/walking_ukf.py.
    before : (3,) the estimate before the step.  forward_m : how far ahead of the last step the measurement was taken.
    """
    prior, alpha = (track.mean, track.covariance), settings.track.alpha
    expectation = ukf.expect(*prior, measured, noise, which, before, forward_m, alpha)
    tested = monitored_update(prior, expectation, noise, ukf.angles_of_state(len(track.mean)), settings.monitor)
    rejected = bool(tested.if2)
    check = InnovationCheck(
        source, time_s, expectation[0], tested.sigma, tested.statistic, tested.threshold, rejected, not rejected
    )
    return tested, check


def measure_fix(
    track: Track,
    time_s: float,
    xy_m: FloatArray,
    noise: FloatArray,
    bias_m2: float,
    forward_m: float,
    settings: Measuring,
) -> tuple[Monitored, InnovationCheck]:
    """Test and fuse the place (2,) of a WiFi scan.

    Parameters
    ----------
    noise, bias_m2 : (2, 2) of the fix alone, and the variance of its lasting error in each direction.
    forward_m : as of measure.
    """
    if not settings.track.learning:  # a filter that does not learn the lasting error takes it for noise
        noise = noise + bias_m2 * np.eye(2)
    return measure(track, "wifi", time_s, BY_WIFI, xy_m, noise, track.mean[:3], forward_m, settings)


def after_step(
    track: Track, step: Step, turns: bool, settings: IntegritySettings, checks: list[InnovationCheck]
) -> Track:
    """The track after a step, its heading observed where the phone knows north. turns : whether it knows its turns."""
    absolute = step.absolute
    if not absolute and not turns:
        track = replace(track, headed=False)
    if not track.headed and absolute:
        track = headed(track, step.heading_rad, settings.track.heading_noise_rad)
        step = replace(step, heading_change_rad=0.0)
    before = track.mean[:3].copy()
    track = stepped(track, step, settings.track)
    if not track.headed or not (absolute or settings.control_twice):
        return track
    which = _HEADING if not settings.control_twice else _STEP if absolute else _STEP_BLIND
    of_heading = settings.track.heading_noise_rad if settings.track.learning else step.heading_sigma_rad
    values = (0.0, 0.0, step.length_m, step.heading_change_rad, step.heading_rad)
    sigmas = (0.0, 0.0, settings.length_sigma_m, settings.turn_sigma_rad, of_heading)
    measured, noise = np.array([values[k] for k in which]), np.diag([sigmas[k] ** 2 for k in which])
    tested, check = measure(track, "heading", step.time_s, which, measured, noise, before, 0.0, settings)
    checks.append(check)
    return replace(track, mean=tested.mean, covariance=tested.covariance)


def noise_of(match: Match, settings: IntegritySettings) -> tuple[FloatArray, float]:
    """Independent noise (2, 2) of a fix, and the variance of its lasting error in each direction."""
    error, variance_m2 = settings.error, settings.error.variance_m2(match)
    independent = (1.0 - error.lasting) * variance_m2 * np.eye(2)
    return independent, error.lasting * variance_m2


def phases_of(tested: Monitored, check: InnovationCheck, fault: bool) -> Phases:
    """What a scan's test means for the Fix. fault : it failed too often in a row."""
    excluded: tuple[Excluded, ...] = ()
    apart_m = 0.0
    if tested.if2:
        apart_m = length_of_m(check.innovation[:2])
        excluded = (taken_out(apart_m, fault),)
    statistic = tested.statistic if math.isfinite(tested.statistic) else None
    return Phases(tested.if1, tested.if2, int(fault), statistic, tested.threshold, apart_m, excluded)
