"""Where a walker goes, whatever way the phone is turned: rotated accelerations and their first principal component.

Unconstrained-smartphones paper section 5.3, its equations 19 to 31. The accelerations of a step, turned into the frame
by the attitude at each sample, spread furthest along the way; the axis has two ends, of which one is the heading. An
error of the attitude turns what was measured and so the axis: sigma points of the quaternion carry its covariance
through.

Differs from the paper: a quaternion error turns all samples of a step alike, so their second moments (3, 3) are
turned instead of the samples; moments of earlier steps are kept for a while, turned with the walker (`keep` 0 is the
paper); the axis' own doubt, which the paper leaves out, follows from how round the spread is; the paper does not say
which end is the heading, here it is told by `forward_evidence`, or by where a phone points that is looked at.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.estimation.unscented_kalman import lower_root, scaled_weights
from app.observations import Carrying
from app.pdr.carried_state import EAST, FACES, POINTS, TURNED, UP
from app.pdr.carrying_position import FACES_UP
from app.pdr.quaternion import multiply, rotate

ALPHA, BETA, KAPPA = 1.0, 2.0, 0.0
LEAST_CELLS = 5
"""Of 40 ms: a step has ten or more."""
AXIS_LARGEST_RAD = 1.2
LOOKED_AT = (Carrying.HANDHELD, Carrying.UNKNOWN)
"""Positions in which a phone points where its walker goes; what is not recognised is taken for the commonest."""


@njit(cache=True)
def step_moments(cells: FloatArray) -> FloatArray:
    """(3, 3) second moments about the mean of a step's accelerations, cells (n, 8), (m/s^2)^2, Eq. 24-26."""
    centred = cells[:, EAST : UP + 1].copy()
    for axis in range(3):
        centred[:, axis] -= np.mean(centred[:, axis])
    return centred.T @ centred / len(cells)


@njit(cache=True)
def forward_evidence(cells: FloatArray) -> FloatArray:
    """(2,) east and north: towards where the horizontal acceleration goes while the vertical one rises.

    A body is pushed forward as it is lifted. Of the steps of the mall walks of folds 1-4 three quarters say so by
    themselves.
    """
    up, rising = cells[:, UP], np.empty(len(cells))
    rising[0], rising[-1] = up[1] - up[0], up[-1] - up[-2]
    rising[1:-1] = 0.5 * (up[2:] - up[:-2])
    evidence = np.empty(2)
    for axis in range(2):
        along = cells[:, EAST + axis]
        evidence[axis] = np.mean((along - np.mean(along)) * rising)
    return evidence


@njit(cache=True)
def turned_clockwise(moments: FloatArray, forward: FloatArray, turn_rad: float) -> tuple[FloatArray, FloatArray]:
    """Moments (3, 3) and a direction (2,) after a turn about the vertical."""
    cos, sin = math.cos(turn_rad), math.sin(turn_rad)
    turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return turn @ moments @ turn.T, np.ascontiguousarray(turn[:2, :2]) @ forward


@njit(cache=True)
def principal_heading(moments: FloatArray) -> float:
    """Azimuth of the horizontal axis of most spread, clockwise from north, in (-pi / 2, pi / 2], Eq. 27-29."""
    return float(0.5 * math.atan2(2.0 * moments[0, 1], moments[1, 1] - moments[0, 0]))


@njit(cache=True)
def nearer_end(axis_rad: float, heading_rad: float) -> float:
    """The end of an axis that lies nearer to a heading, in (-pi, pi]."""
    half = wrap(2.0 * (axis_rad - heading_rad)) / 2.0
    return float(wrap(heading_rad + half))


@njit(cache=True)
def axis_variance(moments: FloatArray, least_rad: float, samples: float) -> float:
    """rad^2, how uncertain the axis of moments (3, 3) itself is: a round spread has none.

    least_rad : of a thin spread.  samples : independent ones that the spread was seen in.

    The first-order variance of an eigenvector's angle, a b / (n (a - b)^2) with a and b the spreads along and across.
    """
    half, middle = 0.5 * (moments[1, 1] - moments[0, 0]), 0.5 * (moments[1, 1] + moments[0, 0])
    apart = 2.0 * math.sqrt(half * half + moments[0, 1] ** 2)
    along, across = middle + 0.5 * apart, max(middle - 0.5 * apart, 0.0)
    if apart < 1e-6 * along or along <= 0.0:
        return AXIS_LARGEST_RAD**2
    return float(min(least_rad**2 + along * across / (samples * apart * apart), AXIS_LARGEST_RAD**2))


@njit(cache=True)
def attitude_share(q: FloatArray, covariance: FloatArray, moments: FloatArray, axis_share: float) -> float:
    """Variance of a heading that the attitude's covariance accounts for, by the unscented transform, Eq. 30-31.

    Parameters
    ----------
    q, covariance : (4,), (4, 4) attitude at one instant of the step.  moments : (3, 3) as of step_moments.
    axis_share : of the heading that follows the axis; the rest follows the phone's own azimuth.
    """
    _, weight, spread = scaled_weights(4, ALPHA, BETA, KAPPA)
    root, scale = lower_root(covariance), math.sqrt(spread)
    before = principal_heading(moments)
    conjugate = np.array([q[0], -q[1], -q[2], -q[3]])
    away, error, turned = np.zeros(9), np.empty(4), np.empty((2, 3))
    for i in range(1, 9):
        sign = scale if i <= 4 else -scale
        multiply(q + sign * root[:, (i - 1) % 4], conjugate, error)  # a rotation of the frame, and normalised
        back = np.array([error[0], -error[1], -error[2], -error[3]])
        rotate(back, np.array([1.0, 0.0, 0.0]), turned[0])
        rotate(back, np.array([0.0, 1.0, 0.0]), turned[1])
        flat = turned @ moments @ turned.T
        axis = 0.5 * math.atan2(2.0 * flat[0, 1], flat[1, 1] - flat[0, 0])
        twist = -2.0 * math.atan2(error[3], error[0])
        away[i] = axis_share * wrap(2.0 * (axis - before)) / 2.0 + (1.0 - axis_share) * wrap(twist)
    mean = np.mean(away[1:])
    variance = 0.0
    for i in range(9):
        variance += weight[i] * (away[i] - mean) ** 2
    return variance


@dataclass(frozen=True, slots=True)
class DirectionSettings:
    """keep : share of earlier steps' moments; 0 is the paper.  axis_rad, axis_samples : doubt of the axis of a thin
    spread, and how many independent samples its roundness counts as; 0 and infinite are the paper.  pointed_rad : of
    the walk to where a phone points that is looked at; infinite leaves that out, as the paper does.
    """

    keep: float = 0.9
    axis_rad: float = 0.3
    axis_samples: float = 6.0
    pointed_rad: float = 0.2


@dataclass(frozen=True, slots=True, eq=False)
class Direction:
    """What is remembered of the way.

    moments : (3, 3) and forward : (2,) as of step_moments and forward_evidence, of the last steps.  turned_rad : turn
    when they were.  heading_rad : of the last step, NaN before the first.
    """

    moments: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    forward: FloatArray = field(default_factory=lambda: np.zeros(2))
    turned_rad: float = 0.0
    heading_rad: float = math.nan


def is_looked_at(cells: FloatArray, carrying: Carrying) -> bool:
    """Whether a phone points where its walker goes: held in front, its screen up. cells : (n, 8) of the step."""
    return carrying in LOOKED_AT and float(np.mean(cells[:, FACES])) > FACES_UP


def walked_on(
    before: Direction,
    cells: FloatArray,
    pose: tuple[FloatArray, FloatArray],
    carrying: Carrying,
    settings: DirectionSettings = DirectionSettings(),
) -> tuple[Direction, float]:
    """The direction of one more step, and the variance of its heading (rad^2).

    Parameters
    ----------
    cells : (n, 8) of the step, at least LEAST_CELLS.  pose : quaternion (4,) and its covariance (4, 4) in the step.
    """
    turn = float(cells[-1, TURNED]) - before.turned_rad
    begun = math.isfinite(before.heading_rad)
    cells = np.ascontiguousarray(cells)
    moments, forward = turned_clockwise(before.moments, before.forward, turn if begun else 0.0)
    moments = settings.keep * moments + step_moments(cells)
    forward = settings.keep * forward + forward_evidence(cells)
    pointed = math.atan2(float(np.sin(cells[:, POINTS]).sum()), float(np.cos(cells[:, POINTS]).sum()))
    looked_at = is_looked_at(cells, carrying)
    if looked_at:
        end = pointed
    else:
        end = before.heading_rad + turn if begun else math.atan2(forward[0], forward[1])
    heading = nearer_end(principal_heading(moments), end)
    variance, share = axis_variance(moments, settings.axis_rad, settings.axis_samples), 1.0
    if looked_at and math.isfinite(settings.pointed_rad):
        share = settings.pointed_rad**2 / (variance + settings.pointed_rad**2)
        heading = wrap(pointed + share * wrap(heading - pointed))
        variance *= share
    variance += attitude_share(*pose, moments, share)
    return Direction(moments, forward, float(cells[-1, TURNED]), heading), variance
