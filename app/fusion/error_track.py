"""Dead reckoning put right by an error-state filter: position, and what is wrong with step length and heading.

Adaptive filter paper Eq. 7-9. The nominal track goes where the steps lead; the filter holds the covariance of its
error (dx, dy, ds, dh), which every feedback makes zero again. The paper's north and east are our y and x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.estimation.extended_kalman import predict_covariance
from app.fusion.adaptive_robust_settings import AdaptiveRobustSettings
from app.fusion.state_codec import storable
from app.fusion.unseen import drifted
from app.observations import Step
from app.pdr.tracker import PdrOutput

X, Y, LENGTH, HEADING = range(4)


@storable
@dataclass(frozen=True, slots=True, eq=False)
class ErrorTrack:
    """A walker's track at the last step.

    xy_m : (2,) nominal position.  length_m, heading_rad : what is added to the length and the heading of every step.
    covariance : (4, 4) of the error of x, y, length_m, heading_rad.
    absolute : whether the phone knew north at the last step.  headed : whether the walking direction is known at all.
    stride_m, stride_s, direction_rad : length, duration and direction of the newest step.
    time_s : up to when passing time is accounted for.
    """

    xy_m: FloatArray
    length_m: float
    heading_rad: float
    covariance: FloatArray
    absolute: bool
    headed: bool
    stride_m: float
    stride_s: float
    direction_rad: float
    time_s: float


def begun(
    xy_m: FloatArray,
    spread_m2: FloatArray,
    time_s: float,
    settings: AdaptiveRobustSettings,
    earlier: ErrorTrack | None = None,
) -> ErrorTrack:
    """A track that begins at a place (2,) of covariance (2, 2). earlier : one given up, of which the rest is kept."""
    covariance = np.zeros((4, 4))
    covariance[:2, :2] = spread_m2
    if earlier is not None:
        covariance[LENGTH, LENGTH] = earlier.covariance[LENGTH, LENGTH]
        covariance[HEADING, HEADING] = settings.askew_sigma_rad**2
        return replace(
            earlier,
            xy_m=xy_m.copy(),
            heading_rad=0.0,
            covariance=covariance,
            absolute=False,
            headed=False,
            time_s=time_s,
        )
    covariance[LENGTH, LENGTH] = settings.length_sigma_m**2
    covariance[HEADING, HEADING] = math.pi**2 / 3.0
    return ErrorTrack(xy_m.copy(), 0.0, 0.0, covariance, False, False, 0.0, 1.0, 0.0, time_s)


def headed(track: ErrorTrack, offset_rad: float, sigma_rad: float) -> ErrorTrack:
    """The track with what is wrong with its headings set from outside."""
    covariance = track.covariance.copy()
    covariance[HEADING, :] = covariance[:, HEADING] = 0.0
    covariance[HEADING, HEADING] = sigma_rad**2
    return replace(track, heading_rad=offset_rad, covariance=covariance, headed=True)


def stepped(
    track: ErrorTrack, step: Step, length_m: float, turns: bool, noise: FloatArray, settings: AdaptiveRobustSettings
) -> ErrorTrack:
    """The track after a step, Eq. 5 and 8. One whose heading is unknown goes nowhere, but gets less certain by a step.

    Parameters
    ----------
    length_m : of the step by the model.  turns : whether the phone knows its turns.  noise : (4,) variances.
    """
    absolute = step.absolute
    if absolute and not track.absolute:
        track = headed(track, 0.0, settings.askew_sigma_rad)
    elif not absolute and (track.absolute or not turns):
        track = replace(track, headed=False)  # its headings have another zero from here on, or none
    track = replace(track, absolute=absolute)
    length_m = max(length_m + track.length_m, 0.0)
    direction_rad = wrap(step.heading_rad + track.heading_rad)
    east, north = math.sin(direction_rad), math.cos(direction_rad)
    transition = np.eye(4)
    xy_m = track.xy_m
    if track.headed:
        xy_m = xy_m + length_m * np.array([east, north])
        transition[:2, LENGTH] = east, north
        transition[:2, HEADING] = length_m * north, -length_m * east
    else:
        noise = noise + settings.lost_share * length_m**2 * np.array([1.0, 1.0, 0.0, 0.0])
    return replace(
        track,
        xy_m=xy_m,
        covariance=predict_covariance(track.covariance, transition, np.diag(noise)),
        stride_m=length_m,
        stride_s=step.duration_s,
        direction_rad=direction_rad,
    )


def aged(track: ErrorTrack, until_s: float, moved: PdrOutput) -> ErrorTrack:
    """The track after time has passed that no step accounts for: nothing changes for a walker who stands still."""
    if until_s <= track.time_s:
        return track
    return replace(track, covariance=drifted(track.covariance, track.time_s, until_s, moved), time_s=until_s)


def place(track: ErrorTrack, moved: PdrOutput) -> tuple[FloatArray, FloatArray]:
    """Position (2,) now, with the step that is under way, and its Jacobian (2, 4) to the error: H of Eq. 13."""
    jacobian = np.eye(2, 4)
    if not track.headed:
        return track.xy_m.copy(), jacobian
    share = moved.pending_fraction
    east, north = math.sin(track.direction_rad), math.cos(track.direction_rad)
    jacobian[:, LENGTH] = share * east, share * north
    jacobian[:, HEADING] = share * track.stride_m * north, -share * track.stride_m * east
    return track.xy_m + share * track.stride_m * np.array([east, north]), jacobian


def put_right(track: ErrorTrack, error: FloatArray, covariance: FloatArray) -> ErrorTrack:
    """The track after the estimated error (4,) of covariance (4, 4) is moved into it."""
    return replace(
        track,
        xy_m=track.xy_m + error[:2],
        length_m=track.length_m + float(error[LENGTH]),
        heading_rad=wrap(track.heading_rad + float(error[HEADING])),
        direction_rad=wrap(track.direction_rad + float(error[HEADING])),
        stride_m=max(track.stride_m + float(error[LENGTH]), 0.0),
        covariance=covariance,
    )
