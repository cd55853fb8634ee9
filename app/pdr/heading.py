"""Heading of the integrity paper: mostly the gyroscope, a little of the compass."""

from __future__ import annotations

import math

MAGNETIC_WEIGHT = 0.01


def combined_heading_rad(
    previous_rad: float, change_rad: float, magnetic_rad: float, weight: float = MAGNETIC_WEIGHT
) -> float:
    """Heading after a step: (1 - W) H_gyro + W H_magnetic, integrity paper Eq. 17-19.

    Parameters
    ----------
    previous_rad : heading after the step before, clockwise from north.
    change_rad : turn since then by the gyroscope.
    magnetic_rad : heading by the compass; NaN: the gyroscope alone.
    weight : W, 0.01 in the paper.

    Returns
    -------
    float
        In (-pi, pi].

    Notes
    -----
    Differs from the paper: the weighted mean is taken along the shorter arc; as printed it breaks at +-pi.
    """
    turned = previous_rad + change_rad
    if math.isfinite(magnetic_rad):
        turned += weight * math.remainder(magnetic_rad - turned, math.tau)
    wrapped = math.remainder(turned, math.tau)
    return math.pi if wrapped == -math.pi else wrapped
