"""What the sensors of a phone in the hand feel of a walk, in the Android device frame (x right, y up, z out of screen).

The phone is held flat in front, top forward, with the wobble of walking. Rates and sizes follow the open data: norm of
the acceleration with a standard deviation of 3.4 m/s^2, 4 at its lowest and 21 at heel strikes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.observations import AxisSamples
from app.pdr.gravity import GRAVITY_MPS2
from app.simulation.random_field import RandomField
from app.simulation.walker import Walk

EARTH_FIELD_UT = np.array([0.0, 31.0, -29.0])
"""East, north, up; magnetic north is taken for true north."""
MAGNETIC_DISTURBANCE_UT, MAGNETIC_DISTURBANCE_M = 6.5, 2.5
HEADING_LAG_S = 4.0
"""Over which Android's rotation vector follows the magnetometer rather than the gyroscope."""


@dataclass(frozen=True, slots=True, eq=False)
class InertialRecord:
    """The four three-axis streams of a recording, at common times."""

    accelerometer: AxisSamples
    gyroscope: AxisSamples
    magnetometer: AxisSamples
    rotation_vector: AxisSamples


def magnetic_disturbance(rng: np.random.Generator) -> RandomField:
    """The steel of a building: three field components, fixed in space, that bend compasses."""
    return RandomField.draw(rng, 3, MAGNETIC_DISTURBANCE_UT, MAGNETIC_DISTURBANCE_M)


def feel(walk: Walk, disturbance: RandomField, rng: np.random.Generator) -> InertialRecord:
    """The sensors' samples along a walk, one each at every time of the walk."""
    return sensed(walk, held(walk, rng), body_motion_mps2(walk, rng), disturbance, rng)


def sensed(
    walk: Walk, attitude: Rotation, motion_mps2: FloatArray, disturbance: RandomField, rng: np.random.Generator
) -> InertialRecord:
    """What the sensors say of an attitude (device to east-north-up) and an acceleration (n, 3) in that frame."""
    rate_hz = walk.rate_hz
    force = motion_mps2 + np.array([0.0, 0.0, GRAVITY_MPS2])
    accelerometer = attitude.inv().apply(force) + rng.normal(0.0, 0.25, 3) + rng.normal(0.0, 0.12, force.shape)

    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec() * rate_hz
    gyroscope = np.vstack([turned, turned[-1:]]) + rng.normal(0.0, 0.004, 3) + rng.normal(0.0, 0.008, force.shape)

    field = EARTH_FIELD_UT + disturbance.all_at(np.column_stack([walk.xy_m, walk.height_m]))
    magnetometer = attitude.inv().apply(field) + rng.normal(0.0, 1.0, 3) + rng.normal(0.0, 0.5, force.shape)

    # clockwise positive: north appears where the disturbed field points
    bent_rad = np.arctan2(field[:, 0], field[:, 1])
    error_rad = gaussian_filter1d(bent_rad, HEADING_LAG_S / 2 * rate_hz, mode="nearest")
    error_rad += wander(rng, len(field), 12.0 * rate_hz, np.radians(7.0))
    quaternion = (Rotation.from_rotvec(np.outer(error_rad, [0.0, 0.0, 1.0])) * attitude).as_quat(canonical=True)

    time_s = np.round(walk.time_s + rng.uniform(0.0, 1.0) / rate_hz, 3)
    streams = (accelerometer, gyroscope, magnetometer, quaternion[:, :3])
    return InertialRecord(*(AxisSamples(time_s, np.ascontiguousarray(values)) for values in streams))


def held(walk: Walk, rng: np.random.Generator) -> Rotation:
    """Attitude, device to east-north-up: heading, then pitch about the device's x, then roll about its y."""
    rate_hz, count, swing = walk.rate_hz, len(walk.time_s), np.minimum(walk.speed_mps / 1.1, 1.3)
    steps, strides = 2 * np.pi * walk.step_phase, np.pi * walk.step_phase
    phase = rng.uniform(0.0, 2 * np.pi, 3)
    yaw = walk.heading_rad + rng.normal(0.0, np.radians(7.0)) + wander(rng, count, 6.0 * rate_hz, np.radians(4.0))
    yaw += swing * np.radians(rng.uniform(2.0, 5.0)) * np.sin(strides + phase[0])
    pitch = np.radians(rng.normal(4.0, 2.0)) + wander(rng, count, 4.0 * rate_hz, np.radians(2.5))
    pitch += swing * np.radians(rng.uniform(3.5, 8.0)) * np.sin(steps + phase[1])
    roll = np.radians(rng.normal(3.5, 2.0)) + wander(rng, count, 4.0 * rate_hz, np.radians(2.0))
    roll += swing * np.radians(rng.uniform(2.0, 4.5)) * np.sin(strides + phase[2])
    return Rotation.from_euler("ZXY", np.column_stack([-yaw, pitch, roll]))


def body_motion_mps2(walk: Walk, rng: np.random.Generator) -> FloatArray:
    """Acceleration (n, 3) of the phone in east, north, up: up and down with every step, fore and aft, side to side."""
    rate_hz = walk.rate_hz
    step_m = walk.speed_mps / np.maximum(np.gradient(walk.step_phase) * rate_hz, 0.5)
    # the swing from trough to peak grows with the fourth power of the step length, as Weinberg found
    size = np.clip((step_m / walk.person.bounce) ** 4, 0.0, 21.0) * (walk.speed_mps > 0.15)
    size = gaussian_filter1d(size, 0.15 * rate_hz, mode="nearest")
    size = size * np.exp(wander(rng, len(size), 1.2 * rate_hz, 0.25))
    angle = 2 * np.pi * (walk.step_phase + wander(rng, len(size), 2.0 * rate_hz, 0.02))
    a, b = rng.uniform(0.2, 0.4), rng.uniform(0.08, 0.2)
    up = 0.44 * size * (np.cos(angle) + a * np.cos(2 * angle + 0.3) + b * np.cos(3 * angle + 0.6))
    # ahead of the lift, as on mall walks: 38 degrees, 23 from walk to walk
    forward = 0.17 * size * np.cos(angle + rng.normal(0.66, 0.4)) + 0.05 * size * np.sin(2 * angle)
    forward += gaussian_filter1d(np.gradient(walk.speed_mps) * rate_hz, 0.1 * rate_hz)
    if walk.climbed_m is not None:  # lifts press and lift
        up += np.gradient(np.gradient(walk.climbed_m)) * rate_hz**2
    side = 0.08 * size * np.sin(angle / 2 + rng.uniform(0.0, 6.0))
    sin, cos = np.sin(walk.heading_rad), np.cos(walk.heading_rad)
    return np.column_stack([forward * sin + side * cos, forward * cos - side * sin, up])


def wander(rng: np.random.Generator, count: int, scale: float, sigma: float) -> FloatArray:
    """Smooth noise (count,) of standard deviation sigma that forgets itself over `scale` samples."""
    knots = rng.normal(0.0, sigma, int(count / scale) + 4)
    smooth = gaussian_filter1d(np.interp(np.arange(count) / scale, np.arange(len(knots)), knots), scale / 4)
    return np.asarray(1.3 * smooth, dtype=np.float64)
