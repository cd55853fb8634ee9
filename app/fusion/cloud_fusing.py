"""What a cloud of particles expects of a fix, and the cloud with a fix in it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.estimation.arrays import FloatArray
from app.floorplan.free_space import FreeSpace
from app.fusion import cloud_kernels as kernels
from app.fusion import cloud_weighing as weighing
from app.fusion.cloud_settings import CloudSettings
from app.fusion.particle_cloud import RENEW, SEEDS, Cloud, ahead_m, resampled, stirred
from app.pdr.tracker import PdrOutput


def expected(cloud: Cloud, moved: PdrOutput, by_wifi: bool = True) -> tuple[FloatArray, FloatArray]:
    """Mean (2,) and covariance (2, 2) of where a fix is expected, without the fix's own noise."""
    biased = 1.0 if by_wifi else 0.0
    mean, covariance = weighing.expected(cloud.particles, cloud.weight, ahead_m(cloud, moved), biased)
    return mean, covariance + (cloud.unseen_m2 + biased * cloud.bias_m2) * np.eye(2)


def fused(
    cloud: Cloud,
    xy_m: FloatArray,
    own_m2: float,
    lasting_m2: float | None,
    weakened: float,
    moved: PdrOutput,
    space: FreeSpace,
    settings: CloudSettings,
) -> Cloud:
    """The cloud after a fix (2,).

    Parameters
    ----------
    own_m2, lasting_m2 : as for begun; lasting_m2 None of a fix that has nothing in common with WiFi's lasting error.
    weakened : 1, or the factor on the variances of a fix that is a little far off.
    """
    cloud = stirred(cloud, space)
    shared_m2 = 0.0 if lasting_m2 is None else cloud.bias_m2
    spread_m2 = (shared_m2 + own_m2) * weakened
    gain = shared_m2 / spread_m2
    particles, weight = weighing.weighed(
        cloud.particles,
        cloud.weight,
        xy_m,
        spread_m2,
        gain,
        ahead_m(cloud, moved),
        0.0 if lasting_m2 is None else 1.0,
    )
    cloud = replace(
        cloud,
        particles=particles,
        weight=weight,
        bias_m2=cloud.bias_m2 * (1.0 - gain),
        lasting_m2=cloud.lasting_m2 if lasting_m2 is None else lasting_m2,
    )
    before = cloud.particles
    cloud = resampled(cloud, space, settings)
    if cloud.particles is before or settings.renewed == 0.0:
        return replace(cloud, seed=cloud.seed + SEEDS)
    particles = kernels.renewed(
        cloud.particles,
        cloud.seed + RENEW,
        settings.renewed,
        xy_m,
        own_m2,
        0.0 if lasting_m2 is None else lasting_m2,
        settings.scale_sigma,
        cloud.north_rad,
        settings.facing_sigma_rad,
        space.cells,
        space.cell_m,
    )
    return replace(cloud, particles=particles, seed=cloud.seed + SEEDS)
