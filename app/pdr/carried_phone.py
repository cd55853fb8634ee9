"""A batch's samples through the quaternion filter and, window by window, through the carrying-position forest."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from app.estimation.arrays import FloatArray
from app.observations import Batch
from app.pdr.carried_motion import carry
from app.pdr.carried_state import CELLS, KEPT, TIME, CarriedMotion
from app.pdr.carrying_position import APART_S, WINDOW_S, Recognised, after_window
from app.pdr.quaternion_ukf import QuaternionNoise
from app.pdr.sample_order import ACC, GYR, MAG, ROT
from app.pdr.tracker import fresh_samples

CHUNK_S = 1.0
"""Samples are taken by so much at most, so that no window has left the ring before it is looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class CarriedPhone:
    """What is remembered of a phone: its motion, and where it is carried."""

    motion: CarriedMotion = field(default_factory=CarriedMotion)
    recognised: Recognised = field(default_factory=Recognised)


def advance_carried(
    phone: CarriedPhone, batch: Batch, noise: QuaternionNoise, until_s: float | None = None
) -> CarriedPhone:
    """The phone after a batch's inertial samples that are newer than those already taken, up to until_s.

    Where the samples are cut has no influence, as long as all streams are cut at the same time.
    """
    motion, recognised = phone.motion, phone.recognised
    for later in _moved(motion, batch, noise, until_s):
        motion = later
        windows, next_s = _ended(motion, recognised.next_s)
        recognised = Recognised(next_s, recognised.answers)
        for end_s, cells in windows:
            recognised = after_window(recognised, end_s, cells)
    return CarriedPhone(motion, recognised)


def windows_of(batch: Batch, noise: QuaternionNoise) -> Iterator[FloatArray]:
    """The cells (n, 8) of every window of a recording that begins with this batch and ends with it."""
    next_s = math.nan
    for motion in _moved(CarriedMotion(), batch, noise, None):
        windows, next_s = _ended(motion, next_s)
        for _, cells in windows:
            yield cells


def _moved(
    motion: CarriedMotion, batch: Batch, noise: QuaternionNoise, until_s: float | None
) -> Iterator[CarriedMotion]:
    """The motion after every second of the samples, and after the last."""
    values = noise.values()
    last = False
    while not last:
        newest = motion.time_s
        first = int(np.searchsorted(batch.accelerometer.time_s, newest[ACC], side="right"))
        waiting = first < len(batch.accelerometer.time_s)
        end_s = float(batch.accelerometer.time_s[first]) + CHUNK_S if waiting else math.inf
        last = not waiting or (until_s is not None and end_s >= until_s)
        cut_s = until_s if last else end_s
        acc = fresh_samples(batch.accelerometer, newest[ACC], cut_s)
        gyr = fresh_samples(batch.gyroscope, newest[GYR], cut_s)
        mag = fresh_samples(batch.magnetometer, newest[MAG], cut_s)
        rot = fresh_samples(batch.rotation_vector, newest[ROT], cut_s)
        if len(acc[0]) or len(gyr[0]) or len(mag[0]) or len(rot[0]):
            arrays = motion.arrays()
            carry(arrays, values, *acc, *gyr, *mag, *rot)
            motion = CarriedMotion(*arrays)
            yield motion


def _ended(motion: CarriedMotion, next_s: float) -> tuple[list[tuple[float, FloatArray]], float]:
    """End and cells of the windows that have ended by now, and when the next one does."""
    kept = int(motion.scalars[KEPT])
    if kept == 0:
        return [], next_s
    newest_s = float(motion.cells[(kept - 1) % CELLS, TIME])
    if not next_s > newest_s - 2.0 * WINDOW_S:  # the first, or after a gap
        next_s = math.ceil(newest_s / APART_S) * APART_S
    windows = []
    while next_s <= newest_s:
        windows.append((next_s, motion.cells_between(next_s - WINDOW_S, next_s)))
        next_s += APART_S
    return windows, next_s
