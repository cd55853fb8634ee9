"""The walking model as least squares: what a state of the walk is, and what ties it to its neighbours and to the floor.

The unknowns and the noise are those of the forward filter (app/fusion/walking_track.py). The lasting error of fixes is
counted in its own standard deviations, which differ from fix to fix.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.estimation.angles import wrap_all
from app.estimation.arrays import FloatArray, IntArray
from app.fusion.unseen import BLIND_M2_PER_S, BLIND_SPEED_MPS
from app.fusion.walk_timeline import Timeline

X, Y, HEADING, LOG_SCALE, ASKEW, ERROR_X, ERROR_Y = range(7)
SIZE = 7
_EVERY = range(SIZE)
_LEAST_VARIANCE = 1e-6
_ANYWHERE_M2 = 1e4
"""Of a place on a floor after the one on another."""


@dataclass(frozen=True, slots=True)
class SmoothingSettings:
    """Noise means what it does in TrackSettings; where it differs, it measured better on folds 1-4, never on fold 0.

    unknown_turn_rad : of the turn of a step, or of a moment, that nobody saw.
    unlikely : squared Mahalanobis distance of a fix at which its weight is halved (Cauchy); 2 to 6 give the same track
    of clean walks, and the smaller, the better those with foreign scans.
    doubted_weight : of a fix that the forward track did not bear out, until the track has its shape.
    inflation : of the covariance. Errors of fixes in places that nobody surveyed last for a whole walk, which no
    neighbouring fix can tell; what held 1 - risk of all answers of folds 1-4 with WIFI_TAILS.
    window : links over which the first headings are turned together.
    """

    step_sigma_m: float = 0.3
    turn_sigma_rad: float = 0.015
    scale_sigma: float = 0.07
    scale_drift: float = 0.003
    askew_sigma_rad: float = 0.25
    askew_drift_rad: float = 0.02
    heading_noise_rad: float = 1.0
    bias_reach_m: float = 12.0
    lost_share: float = 5.0
    unknown_turn_rad: float = 1.0
    unlikely: float = 3.0
    doubted_weight: float = 1e-3
    inflation: float = 1.7
    window: int = 60


@dataclass(frozen=True, slots=True, eq=False)
class Links:
    """n links as arrays. length_m, turn_rad, phone_rad : (n,), as in Link; a step whose turn is unknown has no length.

    north : (n,) information of the phone's heading.  kept : (n,) share of the lasting error.  precision : (n, SIZE).
    """

    length_m: FloatArray
    turn_rad: FloatArray
    phone_rad: FloatArray
    north: FloatArray
    kept: FloatArray
    precision: FloatArray


def links_of(line: Timeline, settings: SmoothingSettings) -> Links:
    """The timeline's links with their noise."""
    length_m, turn_rad, phone_rad, blind_s = (
        np.array([getattr(link, name) for link in line.links])
        for name in ("length_m", "turn_rad", "phone_rad", "blind_s")
    )
    turns, north, new_floor = (
        np.array([getattr(link, name) for link in line.links]) for name in ("turns", "north", "new_floor")
    )
    walked = length_m > 0.0
    way_m = length_m + BLIND_SPEED_MPS * blind_s
    kept = np.where(new_floor, 0.0, np.exp(-way_m / settings.bias_reach_m))
    moved_m2 = walked * settings.step_sigma_m**2 + ~turns * settings.lost_share * length_m**2
    moved_m2 += BLIND_M2_PER_S * blind_s + _ANYWHERE_M2 * new_floor
    noise = np.empty((len(length_m), SIZE))
    noise[:, :HEADING] = moved_m2[:, None]
    lost = ~turns | (blind_s > 0.0)
    noise[:, HEADING] = walked * settings.turn_sigma_rad**2 + lost * settings.unknown_turn_rad**2
    noise[:, LOG_SCALE] = walked * settings.scale_drift**2
    noise[:, ASKEW] = walked * settings.askew_drift_rad**2
    noise[:, ERROR_X:] = (1.0 - kept**2)[:, None]
    return Links(
        length_m=np.where(turns, length_m, 0.0),
        turn_rad=turn_rad,
        phone_rad=phone_rad,
        north=np.where(north, settings.heading_noise_rad**-2, 0.0),
        kept=kept,
        precision=1.0 / np.maximum(noise, _LEAST_VARIANCE),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Fixes:
    """n fixes as arrays. link, share : (n,) on which link they lie, and how far along.  xy_m : (n, 2) from the origin.

    precision : (n, 2, 2) of their own noise.  lasting_m : (n,) standard deviation of the lasting error.
    variance_m2 : (n,) of both together, in each direction.  fits : (n,)
    """

    link: IntArray
    share: FloatArray
    xy_m: FloatArray
    precision: FloatArray
    lasting_m: FloatArray
    variance_m2: FloatArray
    fits: FloatArray

    def between(self, values: FloatArray) -> FloatArray:
        """(n, k) what states (m, k) have at the fixes."""
        share = self.share[:, None]
        return (1.0 - share) * values[self.link] + share * values[self.link + 1]

    def residual_m(self, state: FloatArray) -> FloatArray:
        """(n, 2) fixes beyond what the states (m, SIZE) explain."""
        at = self.between(state)
        return self.xy_m - at[:, :HEADING] - self.lasting_m[:, None] * at[:, ERROR_X:]

    def misfit(self, state: FloatArray) -> FloatArray:
        """(n,) squared Mahalanobis distances of the residuals."""
        residual_m = self.residual_m(state)
        return np.asarray(np.einsum("ni,nij,nj->n", residual_m, self.precision, residual_m))


def fixes_of(line: Timeline, origin_m: FloatArray) -> Fixes:
    """The timeline's fixes, from an origin (2,) on."""
    link, share = line.at(np.array([fix.time_s for fix in line.fixes]))
    noise_m2 = np.array([fix.noise_m2 for fix in line.fixes]) + _LEAST_VARIANCE * np.eye(2)
    lasting_m2 = np.array([fix.lasting_m2 for fix in line.fixes])
    return Fixes(
        link=link,
        share=share,
        xy_m=np.array([fix.xy_m for fix in line.fixes]) - origin_m,
        precision=np.asarray(np.linalg.inv(noise_m2), dtype=np.float64),
        lasting_m=np.sqrt(lasting_m2),
        variance_m2=np.trace(noise_m2, axis1=1, axis2=2) / 2.0 + lasting_m2,
        fits=np.array([float(fix.fits) for fix in line.fixes]),
    )


def normal_equations(
    state: FloatArray, links: Links, fixes: Fixes, weight: FloatArray, settings: SmoothingSettings
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Gauss-Newton's equations at these states (n, SIZE).

    Parameters
    ----------
    weight : of each fix.

    Returns
    -------
    Blocks of the matrix on its diagonal (n, SIZE, SIZE) and under it, and the descent (n, SIZE) on the right side.
    """
    count = len(state)
    diagonal, below = np.zeros((count, SIZE, SIZE)), np.zeros((count - 1, SIZE, SIZE))
    right = np.zeros((count, SIZE))
    expected, jacobian = _stepped(state[:-1], links)
    weighed = links.precision[:, :, None] * jacobian
    diagonal[:-1] += np.swapaxes(jacobian, 1, 2) @ weighed
    diagonal[1:, _EVERY, _EVERY] += links.precision
    below -= weighed
    apart = links.precision * (state[1:] - expected)
    right[1:] -= apart
    right[:-1] += np.einsum("nij,ni->nj", jacobian, apart)

    faced = wrap_all(np.nan_to_num(links.phone_rad) - state[1:, HEADING] - state[1:, ASKEW])
    for one in (HEADING, ASKEW):
        right[1:, one] += links.north * faced
        for other in (HEADING, ASKEW):
            diagonal[1:, one, other] += links.north

    # of where and which way the walk begins nothing is known: just enough for the equations to have one solution
    unknown = (1e-6, 1e-6, 1e-2)
    prior = np.array([*unknown, settings.scale_sigma**-2, settings.askew_sigma_rad**-2, 1.0, 1.0])
    diagonal[0, _EVERY, _EVERY] += prior
    right[0, LOG_SCALE:] -= prior[LOG_SCALE:] * state[0, LOG_SCALE:]

    seen = np.zeros((len(weight), 2, SIZE))
    seen[:, 0, X] = seen[:, 1, Y] = 1.0
    seen[:, 0, ERROR_X] = seen[:, 1, ERROR_Y] = fixes.lasting_m
    told = np.swapaxes(seen, 1, 2) @ (weight[:, None, None] * fixes.precision)
    information = told @ seen
    pull = np.einsum("nij,nj->ni", told, fixes.residual_m(state))
    before, after = (1.0 - fixes.share)[:, None, None], fixes.share[:, None, None]
    np.add.at(diagonal, fixes.link, before**2 * information)
    np.add.at(diagonal, fixes.link + 1, after**2 * information)
    np.add.at(below, fixes.link, before * after * information)
    np.add.at(right, fixes.link, before[:, 0] * pull)
    np.add.at(right, fixes.link + 1, after[:, 0] * pull)
    return diagonal, below, right


def _stepped(before: FloatArray, links: Links) -> tuple[FloatArray, FloatArray]:
    """States after the links from those before (n, SIZE), without noise, and the Jacobian (n, SIZE, SIZE)."""
    direction = before[:, HEADING] + 0.5 * links.turn_rad
    length_m = links.length_m * np.exp(before[:, LOG_SCALE])
    east, north = length_m * np.sin(direction), length_m * np.cos(direction)
    jacobian = np.zeros((len(before), SIZE, SIZE))
    jacobian[:, _EVERY, _EVERY] = 1.0
    jacobian[:, X, HEADING], jacobian[:, Y, HEADING] = north, -east
    jacobian[:, X, LOG_SCALE], jacobian[:, Y, LOG_SCALE] = east, north
    jacobian[:, ERROR_X, ERROR_X] = jacobian[:, ERROR_Y, ERROR_Y] = links.kept
    after = before.copy()
    after[:, X] += east
    after[:, Y] += north
    after[:, HEADING] += links.turn_rad
    after[:, ERROR_X:] *= links.kept[:, None]
    return after, jacobian
