"""Angles on the circle: differences that do not break at +-pi."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.estimation.arrays import FloatArray

DEGREE = math.pi / 180.0


@njit(cache=True)
def wrap(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    wrapped = angle_rad - 2.0 * math.pi * math.floor((angle_rad + math.pi) / (2.0 * math.pi))
    return math.pi if wrapped <= -math.pi else wrapped


def wrap_all(angle_rad: FloatArray) -> FloatArray:
    """The same angles in (-pi, pi], any shape."""
    wrapped = np.remainder(angle_rad + np.pi, 2.0 * np.pi) - np.pi
    return np.where(wrapped <= -np.pi, np.pi, wrapped)
