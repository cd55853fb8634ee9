"""The compiled quaternion operations agree with scipy's."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.pdr import quaternion

numbers = st.floats(-3.0, 3.0)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)


def ours(rotation: Rotation) -> FloatArray:
    return np.ascontiguousarray(np.roll(rotation.as_quat(), 1))


def theirs(q: FloatArray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1))


@given(vectors, vectors)
def test_the_product_is_one_rotation_after_the_other(a: FloatArray, b: FloatArray) -> None:
    first, second = Rotation.from_rotvec(a), Rotation.from_rotvec(b)
    product = np.empty(4)
    quaternion.multiply(ours(first), ours(second), product)
    assert (theirs(product) * (first * second).inv()).magnitude() < 1e-12


@given(vectors, vectors)
def test_a_vector_is_rotated_as_scipy_does(a: FloatArray, v: FloatArray) -> None:
    turned = np.empty(3)
    quaternion.rotate(ours(Rotation.from_rotvec(a)), v, turned)
    np.testing.assert_allclose(turned, Rotation.from_rotvec(a).apply(v), atol=1e-12)


@given(vectors, vectors, st.sampled_from([1.0, 1e-3, 1e-6, 0.0]))
def test_turning_by_a_rotation_vector_appends_it_in_the_device_frame(a: FloatArray, r: FloatArray, size: float) -> None:
    q = ours(Rotation.from_rotvec(a))
    quaternion.turn_by(q, *(size * r))
    expected = Rotation.from_rotvec(a) * Rotation.from_rotvec(size * r)
    assert (theirs(q) * expected.inv()).magnitude() < 1e-12


@given(st.floats(-math.pi, math.pi), st.floats(-80.0, 90.0))
def test_the_azimuth_of_a_phone_without_roll_is_its_heading_at_any_tilt(heading_rad: float, pitch_deg: float) -> None:
    q = ours(Rotation.from_euler("ZX", [-heading_rad, np.radians(pitch_deg)]))
    assert abs(math.remainder(quaternion.azimuth(q) - heading_rad, math.tau)) < 1e-9
