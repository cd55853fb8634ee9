"""A cloud of particles moved by steps, stopped by walls and weighed by fixes, compiled.

One row a particle: x, y, walking heading, logarithm of the step-length scale, and what it holds for the lasting error
of WiFi fixes (x, y). That error is linear in all the rest, so each particle carries the mean of a Kalman filter for it,
and all share one variance (Rao-Blackwell): the cloud need not be large enough to guess it.

What is drawn depends on a seed (and the three after it) that the caller counts up, so the same events give the same
cloud on any worker.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.estimation.angles import wrap
from app.estimation.arrays import BoolArray, Float32Array, FloatArray
from app.estimation.draws import normals, uniform

X, Y, HEADING, LOG_SCALE, WIFI_X, WIFI_Y = range(6)
COLUMNS = 6
_TRIES = 30
"""Draws of a place before one inside a wall is accepted."""


@njit(cache=True, nogil=True)
def is_free(cells: BoolArray, cell_m: float, x_m: float, y_m: float) -> bool:
    """Whether one can be at a place; everywhere, where there are no cells."""
    if cells.size == 0:
        return True
    row, column = math.floor(y_m / cell_m), math.floor(x_m / cell_m)
    return bool(0 <= row < cells.shape[0] and 0 <= column < cells.shape[1] and cells[row, column])


@njit(cache=True, nogil=True)
def drawn(
    particles: Float32Array,
    which: int,
    seed: int,
    xy_m: FloatArray,
    own_m2: float,
    lasting_m2: float,
    scale_sigma: float,
    cells: BoolArray,
    cell_m: float,
) -> None:
    """Put one particle where a fix may come from, in the free space; its heading stays. Changes particles in place."""
    variance_m2 = own_m2 + lasting_m2
    sigma_m = math.sqrt(variance_m2)
    x_m, y_m = xy_m[0], xy_m[1]
    for attempt in range(_TRIES):
        east, north = normals(seed, _TRIES * which + attempt)
        x_m, y_m = xy_m[0] + east * sigma_m, xy_m[1] + north * sigma_m
        if is_free(cells, cell_m, x_m, y_m):
            break
    share = lasting_m2 / variance_m2 if variance_m2 > 0.0 else 0.0
    particles[which, X], particles[which, Y] = x_m, y_m
    particles[which, WIFI_X], particles[which, WIFI_Y] = (xy_m[0] - x_m) * share, (xy_m[1] - y_m) * share
    particles[which, LOG_SCALE] = normals(seed + 1, which)[0] * scale_sigma


@njit(cache=True, nogil=True)
def begun(
    count: int,
    seed: int,
    xy_m: FloatArray,
    own_m2: float,
    lasting_m2: float,
    scale_sigma: float,
    elsewhere_m: FloatArray,
    share: float,
    cells: BoolArray,
    cell_m: float,
) -> Float32Array:
    """(count, 6) a cloud at a fix; headings are anything. elsewhere_m : (k, 2) other places, k may be 0, around which
    this share of the cloud begins."""
    particles = np.zeros((count, COLUMNS), np.float32)
    for i in range(count):
        particles[i, HEADING] = (2.0 * uniform(seed + 2, i) - 1.0) * math.pi
        where_m = xy_m
        if len(elsewhere_m) and uniform(seed + 3, 2 * i) < share:
            where_m = elsewhere_m[min(int(uniform(seed + 3, 2 * i + 1) * len(elsewhere_m)), len(elsewhere_m) - 1)]
        drawn(particles, i, seed, where_m, own_m2, lasting_m2, scale_sigma, cells, cell_m)
    return particles


@njit(cache=True, nogil=True)
def faced(particles: Float32Array, seed: int, heading_rad: float, sigma_rad: float, astray: float) -> Float32Array:
    """The cloud with headings about one; a share astray faces anywhere."""
    particles = particles.copy()
    for i in range(len(particles)):
        anywhere = uniform(seed + 1, 2 * i) < astray
        about_rad, any_rad = normals(seed, i)[0] * sigma_rad, (2.0 * uniform(seed + 1, 2 * i + 1) - 1.0) * math.pi
        particles[i, HEADING] = wrap(heading_rad + (any_rad if anywhere else about_rad))
    return particles


@njit(cache=True, nogil=True)
def stirred(particles: Float32Array, seed: int, variance_m2: float, cells: BoolArray, cell_m: float) -> Float32Array:
    """The cloud after moves that nobody saw, of this variance in each direction; walls hold."""
    particles = particles.copy()
    sigma_m = math.sqrt(variance_m2)
    for i in range(len(particles)):
        east, north = normals(seed, i)
        x_m, y_m = particles[i, X] + east * sigma_m, particles[i, Y] + north * sigma_m
        if is_free(cells, cell_m, x_m, y_m) or not is_free(cells, cell_m, particles[i, X], particles[i, Y]):
            particles[i, X], particles[i, Y] = x_m, y_m
    return particles


@njit(cache=True, nogil=True)
def stepped(
    particles: Float32Array,
    weight: Float32Array,
    seed: int,
    length_m: float,
    turn_rad: float,
    turn_sigma_rad: float,
    heading_rad: float,
    heading_sigma_rad: float,
    step_sigma_m: float,
    scale_drift: float,
    bias_kept: float,
    blocked: float,
    through: float,
    cells: BoolArray,
    cell_m: float,
) -> tuple[Float32Array, Float32Array]:
    """Cloud and weights (n,) after a step.

    Parameters
    ----------
    length_m, turn_rad : before any scale.  heading_rad, heading_sigma_rad : what the compass says; sigma inf: nothing.
    bias_kept : share of the WiFi error that is still the same.
    blocked : factor on the weight of a particle that meets a wall, or walks where the plan says that nobody does.
    through : share of those that meet a wall that go on, into a room of which plan and survey know no door. The others
    stay where they were.
    """
    particles, weight = particles.copy(), weight.copy()
    total = 0.0
    for i in range(len(particles)):
        direction = particles[i, HEADING] + 0.5 * turn_rad
        turned, drifted = normals(seed, i)
        east, north = normals(seed + 1, i)
        after_rad = wrap(particles[i, HEADING] + turn_rad + turned * turn_sigma_rad)
        particles[i, HEADING] = after_rad
        particles[i, LOG_SCALE] += drifted * scale_drift
        particles[i, WIFI_X] *= bias_kept
        particles[i, WIFI_Y] *= bias_kept
        reach_m = length_m * math.exp(particles[i, LOG_SCALE])
        from_x_m, from_y_m = particles[i, X], particles[i, Y]
        x_m = from_x_m + reach_m * math.sin(direction) + east * step_sigma_m
        y_m = from_y_m + reach_m * math.cos(direction) + north * step_sigma_m
        way_free = is_free(cells, cell_m, 0.5 * (x_m + from_x_m), 0.5 * (y_m + from_y_m))
        to_free = is_free(cells, cell_m, x_m, y_m)
        if not (to_free and way_free):
            weight[i] *= blocked
        if (to_free and way_free) or not is_free(cells, cell_m, from_x_m, from_y_m) or uniform(seed + 2, i) < through:
            particles[i, X], particles[i, Y] = x_m, y_m
        if math.isfinite(heading_sigma_rad):
            weight[i] *= math.exp(-0.5 * (wrap(after_rad - heading_rad) / heading_sigma_rad) ** 2)
        total += weight[i]
    return particles, weight / np.float32(total) if total > 0.0 else np.full_like(weight, 1.0 / len(weight))


@njit(cache=True, nogil=True)
def resampled(
    particles: Float32Array, weight: Float32Array, seed: int, rough_m: float, cells: BoolArray, cell_m: float
) -> Float32Array:
    """As many particles of equal weight, drawn systematically, each shifted a little within the free space."""
    count = len(particles)
    chosen = np.empty_like(particles)
    at, reached = 0, float(weight[0])
    first = uniform(seed, 2 * count) / count
    for i in range(count):
        while first + i / count > reached and at < count - 1:
            at += 1
            reached += weight[at]
        chosen[i] = particles[at]
        east, north = normals(seed, i)
        x_m, y_m = chosen[i, X] + east * rough_m, chosen[i, Y] + north * rough_m
        if is_free(cells, cell_m, x_m, y_m):
            chosen[i, X], chosen[i, Y] = x_m, y_m
    return chosen


@njit(cache=True, nogil=True)
def renewed(
    particles: Float32Array,
    seed: int,
    share: float,
    xy_m: FloatArray,
    own_m2: float,
    lasting_m2: float,
    scale_sigma: float,
    north_rad: float,
    facing_sigma_rad: float,
    cells: BoolArray,
    cell_m: float,
) -> Float32Array:
    """A cloud of equal weights with a share of its particles drawn anew at a fix, facing where the phone says; if it
    says nothing (NaN), as before."""
    particles = particles.copy()
    every = max(1, round(1.0 / share))
    for which in range(seed % every, len(particles), every):
        drawn(particles, which, seed, xy_m, own_m2, lasting_m2, scale_sigma, cells, cell_m)
        if math.isfinite(north_rad):
            particles[which, HEADING] = wrap(north_rad + normals(seed + 2, which)[0] * facing_sigma_rad)
    return particles
