"""A walker's track as a cloud of particles: any shape that fixes, steps and walls leave, not an ellipse.

What is done to it with what it is told; the arithmetic over particles is in app/fusion/cloud_kernels.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from app.estimation.arrays import Float32Array, FloatArray
from app.floorplan.free_space import FreeSpace
from app.fusion import cloud_kernels as kernels
from app.fusion.cloud_settings import CloudSettings
from app.fusion.state_codec import storable
from app.fusion.unseen import BLIND_SPEED_MPS, drift_m2_per_s, is_blind
from app.pdr.tracker import PdrOutput
from app.pdr.turn_doubt import LedStep

NO_HEADING = math.inf
_STIR, _FACE, _STEP, _RESAMPLE, RENEW = 0, 4, 8, 12, 16
"""Seeds of what a step or a fix may draw, beside its own: what is not drawn must not shift what is."""
SEEDS = 20
"""Of one step or fix."""
NOWHERE: FloatArray = np.empty((0, 2))


@storable
@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """A walker's track at the last step.

    particles, weight : (n, 6) and (n,) as in app/fusion/cloud_kernels.py.
    bias_m2 : variance of each particle's WiFi error, in each direction.  lasting_m2 : what it grows to with distance.
    unseen_m2 : of moves that nobody saw and the particles do not know of yet.
    headed : whether headings mean anything yet.  north_rad : where the phone says that the newest step went, NaN of one
    that does not know north.  stride_m, stride_s : of the newest step, unscaled.
    time_s : up to when passing time is accounted for.  seed : counts what was drawn.
    """

    particles: Float32Array
    weight: Float32Array
    bias_m2: float
    lasting_m2: float
    unseen_m2: float
    headed: bool
    north_rad: float
    stride_m: float
    stride_s: float
    time_s: float
    seed: int


def begun(
    xy_m: FloatArray,
    own_m2: float,
    lasting_m2: float,
    time_s: float,
    space: FreeSpace,
    settings: CloudSettings,
    earlier: Cloud | None = None,
    by_wifi: bool = True,
    elsewhere_m: FloatArray = NOWHERE,
) -> Cloud:
    """A cloud that begins at a fix, as far as walls allow.

    Parameters
    ----------
    xy_m : (2,) the fix.  own_m2, lasting_m2 : variances of its own and of its lasting error, in each direction.
    earlier : a cloud given up; its step-length scales are kept.
    by_wifi : False of a place that has nothing in common with WiFi's lasting error.
    elsewhere_m : (k, 2) places that the fix may be of as well: a share of the cloud begins there, until the place is
    certain.
    """
    seed, shared_m2 = 0 if earlier is None else earlier.seed + SEEDS, lasting_m2 if by_wifi else 0.0
    particles = kernels.begun(
        settings.particles,
        seed,
        xy_m,
        own_m2,
        shared_m2,
        settings.scale_sigma,
        elsewhere_m,
        settings.elsewhere,
        space.cells,
        space.cell_m,
    )
    stride_m, stride_s = (0.0, 1.0) if earlier is None else (earlier.stride_m, earlier.stride_s)
    if earlier is not None and len(earlier.particles) == len(particles):
        particles[:, kernels.LOG_SCALE] = earlier.particles[:, kernels.LOG_SCALE]
    weight = np.full(len(particles), 1.0 / len(particles), np.float32)
    bias_m2 = lasting_m2 * own_m2 / (own_m2 + lasting_m2) if by_wifi else lasting_m2
    return Cloud(particles, weight, bias_m2, lasting_m2, 0.0, False, math.nan, stride_m, stride_s, time_s, seed + SEEDS)


def stepped(cloud: Cloud, led: LedStep, space: FreeSpace, settings: CloudSettings) -> Cloud:
    """The cloud after a step."""
    cloud, step, turns = stirred(cloud, space), led.step, led.turns
    absolute = step.absolute
    if led.afresh or not (absolute or turns):
        cloud = replace(cloud, headed=False)
    turn_rad = step.heading_change_rad
    if not cloud.headed:
        sigma_rad = math.hypot(settings.facing_sigma_rad, step.heading_sigma_rad) if absolute else math.tau
        astray = settings.astray if absolute else 1.0
        particles = kernels.faced(cloud.particles, cloud.seed + _FACE, step.heading_rad, sigma_rad, astray)
        cloud, turn_rad = replace(cloud, particles=particles, headed=True), 0.0
    kept = math.exp(-step.length_m / settings.bias_reach_m)
    particles, weight = kernels.stepped(
        cloud.particles,
        cloud.weight,
        cloud.seed + _STEP,
        step.length_m,
        turn_rad,
        settings.turn_sigma_rad if turns else settings.turn_unknown_rad,
        step.heading_rad,
        math.hypot(settings.heading_noise_rad, step.heading_sigma_rad) if absolute else NO_HEADING,
        settings.step_sigma_m,
        settings.scale_drift,
        kept,
        settings.blocked,
        settings.through,
        space.cells,
        space.cell_m,
    )
    bias_m2 = cloud.bias_m2 * kept * kept + cloud.lasting_m2 * (1.0 - kept * kept)
    cloud = replace(
        cloud,
        particles=particles,
        weight=weight,
        bias_m2=bias_m2,
        north_rad=step.heading_rad if absolute else math.nan,
        stride_m=step.length_m,
        stride_s=step.duration_s,
    )
    cloud = resampled(cloud, space, settings)
    return replace(cloud, seed=cloud.seed + SEEDS)


def aged(cloud: Cloud, until_s: float, moved: PdrOutput, settings: CloudSettings) -> Cloud:
    """The cloud after time has passed that no step accounts for: nothing changes for a walker who stands still."""
    seconds = until_s - cloud.time_s
    if seconds <= 0.0:
        return cloud
    unseen_m2 = cloud.unseen_m2 + seconds * drift_m2_per_s(until_s, moved)
    if not is_blind(until_s, moved):
        return replace(cloud, unseen_m2=unseen_m2, time_s=until_s)
    kept = math.exp(-BLIND_SPEED_MPS * seconds / settings.bias_reach_m)
    particles = cloud.particles.copy()
    particles[:, kernels.WIFI_X :] *= np.float32(kept)
    bias_m2 = cloud.bias_m2 * kept * kept + cloud.lasting_m2 * (1.0 - kept * kept)
    return replace(cloud, particles=particles, bias_m2=bias_m2, unseen_m2=unseen_m2, time_s=until_s)


def landed(cloud: Cloud, sigma_m: float) -> Cloud:
    """The cloud on another floor: the place in plan is kept to sigma_m in each direction. WiFi errs differently there,
    and headings are not carried over: people turn while they wait, and steps on stairs are no steps of a walk."""
    particles = cloud.particles.copy()
    particles[:, kernels.WIFI_X :] = 0.0
    return replace(
        cloud,
        particles=particles,
        bias_m2=cloud.lasting_m2,
        unseen_m2=cloud.unseen_m2 + sigma_m**2,
        headed=False,
    )


def ahead_m(cloud: Cloud, moved: PdrOutput) -> float:
    """How far the walker is past the last step's end, before any scale."""
    return cloud.stride_m * moved.pending_fraction if cloud.headed else 0.0


def stirred(cloud: Cloud, space: FreeSpace) -> Cloud:
    """The cloud with moves that nobody saw spread over its particles."""
    if cloud.unseen_m2 == 0.0:
        return cloud
    particles = kernels.stirred(cloud.particles, cloud.seed + _STIR, cloud.unseen_m2, space.cells, space.cell_m)
    return replace(cloud, particles=particles, unseen_m2=0.0)


def resampled(cloud: Cloud, space: FreeSpace, settings: CloudSettings) -> Cloud:
    """The cloud with equal weights, if too few of its particles count; else the same one."""
    count = len(cloud.weight)
    if 1.0 / float(np.square(cloud.weight).sum()) >= settings.least_effective * count:
        return cloud
    particles = kernels.resampled(
        cloud.particles, cloud.weight, cloud.seed + _RESAMPLE, settings.rough_m, space.cells, space.cell_m
    )
    weight = np.full(count, 1.0 / count, np.float32)
    return replace(cloud, particles=particles, weight=weight)
