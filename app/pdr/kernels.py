"""Compile the Numba functions of this package before the first request needs them."""

from __future__ import annotations

import numpy as np

from app.observations import AxisSamples, Batch
from app.pdr.attitude_ekf import AttitudeNoise, EulerState, advance_attitude
from app.pdr.motion_state import ShakingState, advance_shaking
from app.pdr.tracker import advance_pdr, initial_pdr_state


def warm_up() -> None:
    """Run one tiny batch through every compiled function; a second or less from the cache."""
    time_s = np.linspace(0.0, 0.06, 4)
    still = AxisSamples(time_s, np.tile([0.0, 0.0, 9.81], (4, 1)))
    rotation = AxisSamples(time_s, np.zeros((4, 3)))
    batch = Batch(0, None, accelerometer=still, gyroscope=rotation, magnetometer=still, rotation_vector=rotation)
    advance_pdr(initial_pdr_state(), batch)
    advance_attitude(EulerState(), batch, AttitudeNoise())
    advance_shaking(ShakingState(), batch)
