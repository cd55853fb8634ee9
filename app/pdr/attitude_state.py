"""What the attitude filter remembers between batches."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from app.estimation.arrays import FloatArray
from app.pdr.compass import no_compass_yet
from app.pdr.gyroscope_bias import BIAS_START

LEVEL_S, REST_S, TURN, DRIFT, POINTED = 0, 1, 2, 3, 4
"""Elements of `scalars`."""


def _identity() -> FloatArray:
    return np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeState:
    """What the filter remembers.

    time_s : (4,) newest sample of accelerometer, gyroscope, magnetometer, rotation vector.
    rate : (3,) newest angular rate, rad/s.
    strapdown : (4,) quaternion, gyroscope alone.  inclination : (4,) its correction by gravity.
    gravity : (2, 3) stages of the low-pass.  scalars : (5,) seconds since levelling began, seconds at rest, turn
    about the vertical (clockwise, rad), variance gained by drift (rad^2), newest heading (rad).
    bias : (3,) rad/s.  bias_covariance : (3, 3).  bias_filter : (2, 11) low-passed rotation and rotated bias.
    rest : (2, 6) low-passed rate and acceleration; newest rate, and for how long (s) it has been repeated.
    magnetic : (12,) heading offset, start gain, field norm and dip now, trusted and candidate, timers, bearing.
    anchor : (2, 4) newest rotation vector as a quaternion, and the own attitude then.
    """

    time_s: FloatArray = field(default_factory=lambda: np.full(4, -math.inf))
    rate: FloatArray = field(default_factory=lambda: np.zeros(3))
    strapdown: FloatArray = field(default_factory=_identity)
    inclination: FloatArray = field(default_factory=_identity)
    gravity: FloatArray = field(default_factory=lambda: np.zeros((2, 3)))
    scalars: FloatArray = field(default_factory=lambda: np.zeros(5))
    bias: FloatArray = field(default_factory=lambda: np.zeros(3))
    bias_covariance: FloatArray = field(default_factory=lambda: np.eye(3) * BIAS_START**2)
    bias_filter: FloatArray = field(default_factory=lambda: np.zeros((2, 11)))
    rest: FloatArray = field(default_factory=lambda: np.zeros((2, 6)))
    magnetic: FloatArray = field(default_factory=no_compass_yet)
    anchor: FloatArray = field(default_factory=lambda: np.vstack([_identity(), _identity()]))

    def arrays(self) -> tuple[FloatArray, ...]:
        """Writable copies in the order of `track`'s arguments."""
        return (
            self.time_s.copy(),
            self.rate.copy(),
            self.strapdown.copy(),
            self.inclination.copy(),
            self.gravity.copy(),
            self.scalars.copy(),
            self.bias.copy(),
            self.bias_covariance.copy(),
            self.bias_filter.copy(),
            self.rest.copy(),
            self.magnetic.copy(),
            self.anchor.copy(),
        )
