"""Method D's noises: the process's from the context, the fix's from the scan, inflated where the F test fails."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray
from app.estimation.error_state_kalman import error_after
from app.estimation.extended_kalman import innovation_covariance
from app.estimation.innovation import f_threshold, normalised_square
from app.floorplan.openness import Surroundings
from app.fusion.adaptive_robust_settings import AdaptiveRobustSettings
from app.fusion.error_track import ErrorTrack, place, put_right
from app.fusion.fix_assembly import BEYOND_M, Phases
from app.observations import Excluded, InnovationCheck
from app.pdr.tracker import PdrOutput
from app.pdr.walking_context import Pace, WalkingContext


@dataclass(frozen=True, slots=True, eq=False)
class Updated:
    """A track after a fix, and what the F test found. The fault phase is for the caller, who counts."""

    track: ErrorTrack
    phases: Phases
    check: InnovationCheck


def process_noise(context: WalkingContext, surroundings: Surroundings, settings: AdaptiveRobustSettings) -> FloatArray:
    """(4,) variances of a step's noise in x, y, step length and heading, section 4.1."""
    noise = settings.noise if settings.adaptive else settings.fixed
    position_m = noise.corridor_m if surroundings is Surroundings.CORRIDOR else noise.open_m
    length_m = noise.normal_m if context.pace is Pace.NORMAL else noise.unusual_m
    heading_rad = noise.turning_rad if context.turning else noise.straight_rad
    return np.square([position_m, position_m, length_m, heading_rad])


def robust_update(
    track: ErrorTrack,
    time_s: float,
    fix_m: FloatArray,
    variance_m2: float,
    moved: PdrOutput,
    settings: AdaptiveRobustSettings,
) -> Updated:
    """Observe where the fix (2,) lies from the nominal position, Eq. 10 and 13-21.

    A fix that is not finite changes nothing and is an outlier.
    """
    nominal_m, jacobian = place(track, moved)
    innovation, noise = fix_m - nominal_m, variance_m2 * np.eye(2)
    spread = innovation_covariance(track.covariance, jacobian, noise)
    sigma = np.sqrt(np.diag(spread))
    threshold = f_threshold(len(innovation), settings.significance)
    if not (np.isfinite(innovation).all() and np.isfinite(spread).all()):
        phases = Phases(1, 1, 0, None, threshold, BEYOND_M, (Excluded("not a place", observation="wifi"),))
        check = InnovationCheck("wifi", time_s, innovation, sigma, math.inf, threshold, True, False)
        return Updated(track, phases, check)
    statistic = normalised_square(innovation, spread) / len(innovation)
    failed = settings.robust and statistic > threshold
    outlier = failed and bool((np.abs(innovation) > settings.outlier_sigmas * sigma).any())
    if failed:
        noise = noise * (statistic / threshold)
    error, covariance = error_after(track.covariance, innovation, jacobian, noise)
    excluded: tuple[Excluded, ...] = ()
    apart_m = 0.0
    if outlier:
        apart_m = float(np.hypot(*innovation))
        reason = f"{apart_m:.0f} m from where the steps lead, given {threshold / statistic:.2f} of its weight"
        excluded = (Excluded(reason, observation="wifi"),)
    phases = Phases(int(failed), int(outlier), 0, statistic, threshold, apart_m, excluded)
    check = InnovationCheck("wifi", time_s, innovation, sigma, statistic, threshold, outlier, not outlier)
    return Updated(put_right(track, error, covariance), phases, check)
