"""Unit quaternions (w, x, y, z) in compiled code: the few operations that attitude tracking needs.

A quaternion q turns a vector of the device frame into the reference frame: v_reference = q v_device q*.
All functions write their result into an array of the caller, so that the loops over samples allocate nothing.
"""

from __future__ import annotations

import math

from numba import njit

from app.estimation.arrays import FloatArray


@njit(cache=True)
def multiply(a: FloatArray, b: FloatArray, product: FloatArray) -> None:
    """Hamilton product a b of two quaternions (4,): first b, then a. `product` may be `a` or `b` itself."""
    w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]
    scale = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    product[0], product[1], product[2], product[3] = w * scale, x * scale, y * scale, z * scale


@njit(cache=True)
def rotate(q: FloatArray, v: FloatArray, turned: FloatArray) -> None:
    """Turn the vector v (3,) by the unit quaternion q (4,). `turned` may be `v` itself."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    a, b, c = v[0], v[1], v[2]
    p, r, s = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    turned[0] = a + w * p + y * s - z * r
    turned[1] = b + w * r + z * p - x * s
    turned[2] = c + w * s + x * r - y * p


@njit(cache=True)
def turn_by(q: FloatArray, x_rad: float, y_rad: float, z_rad: float) -> None:
    """q <- q exp(r / 2) in place: append the rotation vector (x, y, z), given in the device frame, radians."""
    angle = math.sqrt(x_rad * x_rad + y_rad * y_rad + z_rad * z_rad)
    s = 0.5 - angle * angle / 48.0 if angle < 1e-4 else math.sin(0.5 * angle) / angle
    c = math.cos(0.5 * angle)
    bx, by, bz = s * x_rad, s * y_rad, s * z_rad
    w = q[0] * c - q[1] * bx - q[2] * by - q[3] * bz
    x = q[0] * bx + q[1] * c + q[2] * bz - q[3] * by
    y = q[0] * by - q[1] * bz + q[2] * c + q[3] * bx
    z = q[0] * bz + q[1] * by - q[2] * bx + q[3] * c
    scale = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    q[0], q[1], q[2], q[3] = w * scale, x * scale, y * scale, z * scale


@njit(cache=True)
def of_rotation_vector(vector: FloatArray, q: FloatArray) -> None:
    """Android's rotation vector (3,) as a unit quaternion; the wire's rounding may make it longer than one."""
    squared = vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2
    scale = 1.0 / math.sqrt(squared) if squared > 1.0 else 1.0
    q[0] = math.sqrt(max(1.0 - squared, 0.0))
    q[1], q[2], q[3] = vector[0] * scale, vector[1] * scale, vector[2] * scale


@njit(cache=True)
def azimuth(q: FloatArray) -> float:
    """Direction in which a phone points, radians clockwise from the reference frame's y axis (north).

    The device's y axis (the top edge) projected to the horizontal; as the phone is raised towards upright its back
    (-z) takes over, as Android's apps do, since the projection of y vanishes there. Held without roll the two agree.
    """
    w, x, y, z = q[0], q[1], q[2], q[3]
    top_east, top_north, top_up = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
    upright = min(max((abs(top_up) - 0.7) / 0.2, 0.0), 1.0)
    if upright > 0.0:
        back = -upright if top_up > 0.0 else upright
        top_east = (1.0 - upright) * top_east + back * 2.0 * (x * z + w * y)
        top_north = (1.0 - upright) * top_north + back * 2.0 * (y * z - w * x)
    return math.atan2(top_east, top_north)
