"""The two-stage paper's second extended filter: position, step length and heading, a step at a time.

Two-stage WiFi/MEMS integration, Micromachines 2019, 10, 198, Eq. 18-25 (docs/methods/two_stage_ekf.md). State: x, y,
step length, heading clockwise from north.

Differs from the paper: its four measurements are one vector of every step, here each is fused when it is there; a step
goes along the heading in its middle, not at its beginning; a heading that nobody knows yet moves nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.estimation.extended_kalman import correct, predict_covariance
from app.fusion.state_codec import storable
from app.fusion.two_stage_settings import PositionNoise
from app.fusion.unseen import drifted
from app.pdr.tracker import PdrOutput

X, Y, LENGTH, HEADING = range(4)
LOST_SHARE = 5.0
"""Variance of a step in an unknown direction, in squared step lengths: steps go on in the direction of those before."""


@storable
@dataclass(frozen=True, slots=True, eq=False)
class StepTrack:
    """The filter at the last step.

    mean, covariance : (4,), (4, 4).  headed : whether the heading is known at all.
    pointed_rad : heading by the attitude filter at the last step, from its own zero and unwrapped; NaN before there was
    one.  stretch : of the attitude that it belongs to.  stride_s : duration of the last step.
    time_s : up to when passing time is accounted for.
    """

    mean: FloatArray
    covariance: FloatArray
    headed: bool
    pointed_rad: float
    stretch: int
    stride_s: float
    time_s: float


def begun(xy_m: FloatArray, variance_m2: float, time_s: float, noise: PositionNoise) -> StepTrack:
    """A track that begins at a place known with a variance in each direction."""
    mean = np.array([xy_m[0], xy_m[1], noise.start_length_m, 0.0])
    covariance = np.diag([variance_m2, variance_m2, noise.start_length_m2, math.pi**2 / 3.0])
    return StepTrack(mean, covariance, False, math.nan, 0, 1.0, time_s)


def headed(track: StepTrack, heading_rad: float, sigma_rad: float) -> StepTrack:
    """The track with its heading set from outside."""
    mean, covariance = track.mean.copy(), track.covariance.copy()
    mean[HEADING] = wrap(heading_rad)
    covariance[HEADING, :] = covariance[:, HEADING] = 0.0
    covariance[HEADING, HEADING] = sigma_rad**2
    return replace(track, mean=mean, covariance=covariance, headed=True)


def stepped(track: StepTrack, turn_rad: float, noise: PositionNoise) -> StepTrack:
    """The track after a step, Eq. 21. turn_rad : of the attitude since the step before."""
    mean, transition = track.mean.copy(), np.eye(4)
    process = np.array([noise.place_m2, noise.place_m2, noise.length_m2, noise.heading_rad2])
    length_m = float(mean[LENGTH])
    if track.headed:
        along = float(mean[HEADING]) + 0.5 * turn_rad
        east, north = math.sin(along), math.cos(along)
        mean[X] += length_m * east
        mean[Y] += length_m * north
        mean[HEADING] = wrap(float(mean[HEADING]) + turn_rad)
        transition[X, LENGTH], transition[Y, LENGTH] = east, north
        transition[X, HEADING], transition[Y, HEADING] = length_m * north, -length_m * east
    else:
        process[:2] += LOST_SHARE * length_m**2
    covariance = predict_covariance(track.covariance, transition, np.diag(process))
    if not track.headed:
        covariance[HEADING, HEADING] = math.pi**2 / 3.0
    return replace(track, mean=mean, covariance=covariance)


def measured(track: StepTrack, innovation: FloatArray, jacobian: FloatArray, noise: FloatArray) -> StepTrack:
    """The track after a measurement: innovation (m,), jacobian (m, 4) and noise (m, m)."""
    mean, covariance = correct(track.mean, track.covariance, innovation, jacobian, noise)
    mean[HEADING] = wrap(float(mean[HEADING]))
    mean[LENGTH] = max(float(mean[LENGTH]), 0.0)
    return replace(track, mean=mean, covariance=covariance)


def of(component: int) -> FloatArray:
    """(1, 4) Jacobian of a measurement of one component."""
    return np.eye(4)[component : component + 1].copy()


def aged(track: StepTrack, until_s: float, moved: PdrOutput) -> StepTrack:
    """The track after time has passed that no step accounts for: nothing changes for a walker who stands still."""
    if until_s <= track.time_s:
        return track
    return replace(track, covariance=drifted(track.covariance, track.time_s, until_s, moved), time_s=until_s)


def place(track: StepTrack, moved: PdrOutput) -> tuple[FloatArray, FloatArray]:
    """Position (2,) now, with the share of the step that is under way, and its Jacobian (2, 4)."""
    jacobian = np.zeros((2, 4))
    jacobian[0, X] = jacobian[1, Y] = 1.0
    xy_m = track.mean[:2].copy()
    if track.headed and moved.pending_fraction > 0.0:
        share, length_m, heading_rad = moved.pending_fraction, float(track.mean[LENGTH]), float(track.mean[HEADING])
        direction = np.array([math.sin(heading_rad), math.cos(heading_rad)])
        xy_m += share * length_m * direction
        jacobian[:, LENGTH] = share * direction
        jacobian[:, HEADING] = share * length_m * np.array([direction[1], -direction[0]])
    return xy_m, jacobian
