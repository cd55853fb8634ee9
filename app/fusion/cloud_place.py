"""What a cloud of particles says of the walker now."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion import cloud_kernels as kernels
from app.fusion import cloud_weighing as weighing
from app.fusion.particle_cloud import Cloud, ahead_m
from app.pdr.tracker import PdrOutput

_LEAST_FACING = 0.5
"""Length of the mean unit vector of headings below which there is no heading to speak of."""


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """Where a cloud says that the walker is.

    xy_m : (2,) geometric median, which errs least on average.  covariance_m2 : (2, 2) about it.
    radius_68_m, radius_99_m : about it, that hold so much of the cloud.
    """

    xy_m: FloatArray
    covariance_m2: FloatArray
    radius_68_m: float
    radius_99_m: float


def place(cloud: Cloud, moved: PdrOutput) -> Place:
    """Where the walker is now, with the step that is under way and with what nobody saw."""
    centre_m, covariance_m2, distance_m = weighing.about_median(cloud.particles, cloud.weight, ahead_m(cloud, moved))
    order = np.argsort(distance_m)
    reached = np.cumsum(cloud.weight[order], dtype=np.float64)
    within = np.minimum(np.searchsorted(reached, np.array([0.68, 0.99]) * reached[-1]), len(order) - 1)
    inner_m, outer_m = distance_m[order[within]].tolist()
    unseen = round_place(centre_m, cloud.unseen_m2)
    return Place(
        centre_m,
        covariance_m2 + unseen.covariance_m2,
        math.hypot(inner_m, unseen.radius_68_m),
        math.hypot(outer_m, unseen.radius_99_m),
    )


def round_place(xy_m: FloatArray, variance_m2: float) -> Place:
    """The place (2,) of a Gaussian with this variance in each direction."""
    # -2 ln(1 - share) is the squared radius that holds a share of it
    inner_m2, outer_m2 = (-2.0 * math.log(1.0 - share) * variance_m2 for share in (0.68, 0.99))
    return Place(xy_m, variance_m2 * np.eye(2), math.sqrt(inner_m2), math.sqrt(outer_m2))


def scale_of(cloud: Cloud) -> float:
    """By what the walker's steps are longer than the model says."""
    return math.exp(float(cloud.weight @ cloud.particles[:, kernels.LOG_SCALE]))


def heading_of(cloud: Cloud) -> float | None:
    """Walking direction, None while the cloud walks in all of them."""
    if not cloud.headed:
        return None
    heading_rad = cloud.particles[:, kernels.HEADING]
    east, north = float(cloud.weight @ np.sin(heading_rad)), float(cloud.weight @ np.cos(heading_rad))
    return math.atan2(east, north) if math.hypot(east, north) >= _LEAST_FACING else None
