"""Position, heading and what a session learns, moved by steps, by time, and begun from a scan.

The state of the unscented filter in app/fusion/walking_ukf.py and everything that is done to it except measuring.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion import walking_ukf as ukf
from app.fusion.interface import START_SIGMA_M
from app.fusion.state_codec import storable
from app.fusion.unseen import BLIND_SPEED_MPS, drifted, is_blind
from app.observations import Step
from app.pdr.tracker import PdrOutput


@dataclass(frozen=True, slots=True)
class TrackSettings:
    """Of the walking model. Chosen on folds 1-4 of the mall walks, never on fold 0, unless said otherwise.

    alpha : spread of the sigma points; with seven components 0.65 puts them where 1.0 does with three.
    learning : seven components of state; False: the paper's three.
    turned_before : share of a turn that comes before the step's displacement; 0 in Eq. 26.
    step_sigma_m, turn_sigma_rad : noise of one step's displacement in each direction, and of its turn.
    scale_sigma, scale_drift : of the logarithm of the step-length scale, at first and per step.
    askew_sigma_rad, askew_drift_rad : of the angle between phone and walking direction, at first and per step.
    heading_noise_rad : of one heading observation beside the askew angle; large, since neighbouring ones err alike.
    bias_reach_m : distance over which the error of WiFi fixes is forgotten.
    lost_share : variance of a step in an unknown direction, in squared step lengths; more than 0.5 since steps go on in
    the direction of those before.
    """

    alpha: float = 0.65
    learning: bool = True
    turned_before: float = 0.5
    step_sigma_m: float = 0.2
    turn_sigma_rad: float = 0.015
    scale_sigma: float = 0.1
    scale_drift: float = 0.003
    askew_sigma_rad: float = 0.25
    askew_drift_rad: float = 0.02
    heading_noise_rad: float = 0.5
    bias_reach_m: float = 12.0
    lost_share: float = 5.0


@storable
@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A walker's track at the last step.

    mean, covariance : (n,), (n, n) as in app/fusion/walking_ukf.py.  bias_variance_m2 : of WiFi fixes around here, in
    each direction.  headed : whether the heading is known at all.  stride_m, stride_s : of the newest step, unscaled.
    time_s : up to when passing time is accounted for.
    """

    mean: FloatArray
    covariance: FloatArray
    bias_variance_m2: float
    headed: bool
    stride_m: float
    stride_s: float
    time_s: float


def begun(
    xy_m: FloatArray,
    noise_m2: FloatArray,
    bias_variance_m2: float,
    time_s: float,
    settings: TrackSettings,
    earlier: Track | None = None,
) -> Track:
    """A track that begins at a fix.

    Parameters
    ----------
    xy_m, noise_m2 : (2,), (2, 2) the fix and its independent noise.  bias_variance_m2 : of its lasting error.
    earlier : a track given up; its step-length scale is kept.
    """
    size = ukf.LEARNING if settings.learning else ukf.PLAIN
    mean, covariance = np.zeros(size), np.zeros((size, size))
    mean[:2] = xy_m
    covariance[:2, :2] = noise_m2 + bias_variance_m2 * np.eye(2)
    covariance[ukf.HEADING, ukf.HEADING] = math.pi**2 / 3.0
    if settings.learning:
        # the fix is position plus lasting error: what one has too much, the other has too little
        for place, error in ((ukf.X, ukf.WIFI_X), (ukf.Y, ukf.WIFI_Y)):
            covariance[error, error] = bias_variance_m2
            covariance[place, error] = covariance[error, place] = -bias_variance_m2
        covariance[ukf.LOG_SCALE, ukf.LOG_SCALE] = settings.scale_sigma**2
        covariance[ukf.ASKEW, ukf.ASKEW] = settings.askew_sigma_rad**2
        if earlier is not None:
            mean[ukf.LOG_SCALE] = earlier.mean[ukf.LOG_SCALE]
            covariance[ukf.LOG_SCALE, ukf.LOG_SCALE] = earlier.covariance[ukf.LOG_SCALE, ukf.LOG_SCALE]
    stride_m, stride_s = (0.0, 1.0) if earlier is None else (earlier.stride_m, earlier.stride_s)
    return Track(mean, covariance, bias_variance_m2, False, stride_m, stride_s, time_s)


def begun_at_prior(xy_m: FloatArray, bias_variance_m2: float, time_s: float, settings: TrackSettings) -> Track:
    """A track that begins where the phone says, (2,): its error has nothing in common with WiFi's."""
    noise_m2 = START_SIGMA_M**2 * np.eye(2)
    track = begun(xy_m, noise_m2, bias_variance_m2, time_s, settings)
    covariance = track.covariance.copy()
    covariance[:2, :] = covariance[:, :2] = 0.0
    covariance[:2, :2] = noise_m2
    return replace(track, covariance=covariance)


def headed(track: Track, heading_rad: float, sigma_rad: float, by_phone: bool = True) -> Track:
    """The track with its heading set from outside. by_phone : it is the phone's; the walker's differs by the askew
    angle, which is not known yet."""
    mean, covariance = track.mean.copy(), track.covariance.copy()
    mean[ukf.HEADING] = heading_rad
    covariance[ukf.HEADING, :] = covariance[:, ukf.HEADING] = 0.0
    covariance[ukf.HEADING, ukf.HEADING] = sigma_rad**2
    if by_phone and len(mean) > ukf.PLAIN:
        askew = covariance[ukf.ASKEW, ukf.ASKEW]
        mean[ukf.HEADING] -= mean[ukf.ASKEW]
        covariance[ukf.HEADING, ukf.HEADING] += askew
        covariance[ukf.HEADING, :] -= covariance[ukf.ASKEW, :] * (np.arange(len(mean)) != ukf.HEADING)
        covariance[:, ukf.HEADING] = covariance[ukf.HEADING, :]
    return replace(track, mean=mean, covariance=covariance, headed=True)


def stepped(track: Track, step: Step, settings: TrackSettings) -> Track:
    """The track after a step. One whose heading is unknown goes nowhere, but gets less certain by a step."""
    size = len(track.mean)
    noise = np.zeros(size)
    noise[:2] = settings.step_sigma_m**2
    if not track.headed:
        noise[:2] += settings.lost_share * step.length_m**2
    noise[ukf.HEADING] = settings.turn_sigma_rad**2
    kept = math.exp(-step.length_m / settings.bias_reach_m)
    if size > ukf.PLAIN:
        noise[ukf.LOG_SCALE] = settings.scale_drift**2
        noise[ukf.ASKEW] = settings.askew_drift_rad**2
        noise[ukf.WIFI_X :] = track.bias_variance_m2 * (1.0 - kept * kept)
    length_m = step.length_m if track.headed else 0.0
    mean, covariance = ukf.predict(
        track.mean,
        track.covariance,
        length_m,
        step.heading_change_rad if track.headed else 0.0,
        settings.turned_before,
        kept,
        noise,
        settings.alpha,
    )
    return replace(track, mean=mean, covariance=covariance, stride_m=step.length_m, stride_s=step.duration_s)


def aged(track: Track, until_s: float, moved: PdrOutput, settings: TrackSettings) -> Track:
    """The track after time has passed that no step accounts for: nothing changes for a walker who stands still."""
    seconds = until_s - track.time_s
    if seconds <= 0.0:
        return track
    mean, covariance = track.mean, drifted(track.covariance, track.time_s, until_s, moved)
    if is_blind(until_s, moved) and len(mean) > ukf.PLAIN:
        kept = math.exp(-BLIND_SPEED_MPS * seconds / settings.bias_reach_m)
        mean = mean.copy()
        mean[ukf.WIFI_X :] *= kept
        covariance[ukf.WIFI_X :, :] *= kept
        covariance[:, ukf.WIFI_X :] *= kept
        for error in (ukf.WIFI_X, ukf.WIFI_Y):
            covariance[error, error] += track.bias_variance_m2 * (1.0 - kept * kept)
    return replace(track, mean=mean, covariance=covariance, time_s=until_s)


def ahead_m(track: Track, moved: PdrOutput) -> float:
    """How far the walker is past the last step's end, before any scale."""
    return track.stride_m * moved.pending_fraction if track.headed else 0.0


def place(track: Track, moved: PdrOutput) -> tuple[FloatArray, FloatArray]:
    """Position (2,) and covariance (2, 2) now, with the step that is under way."""
    mean, covariance = track.mean, track.covariance
    forward_m = ahead_m(track, moved)
    if forward_m == 0.0:
        return mean[:2].copy(), covariance[:2, :2].copy()
    heading_rad = float(mean[ukf.HEADING])
    forward_m *= scale_of(track)
    east, north = math.sin(heading_rad), math.cos(heading_rad)
    jacobian = np.zeros((2, len(mean)))
    jacobian[0, ukf.X] = jacobian[1, ukf.Y] = 1.0
    jacobian[:, ukf.HEADING] = forward_m * north, -forward_m * east
    if len(mean) > ukf.PLAIN:
        jacobian[:, ukf.LOG_SCALE] = forward_m * east, forward_m * north
    return mean[:2] + forward_m * np.array([east, north]), jacobian @ covariance @ jacobian.T


def scale_of(track: Track) -> float:
    """By what the walker's steps are longer than the model says."""
    return math.exp(float(track.mean[ukf.LOG_SCALE])) if len(track.mean) > ukf.PLAIN else 1.0
