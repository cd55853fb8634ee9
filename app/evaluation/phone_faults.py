"""Faults of the phone itself and of its user: inertial sensors, compass, clock, and a start that is not true."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.evaluation.faulty_walk import FAR_M, Dice, Elsewhere, FaultyWalk, from_middle, middle_s, with_trace
from app.evaluation.recordings import RecordedWalk
from app.observations import AxisSamples, Position

_STREAMS = ("accelerometer", "gyroscope", "magnetometer", "rotation_vector")


def without_rotation_vector(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice) -> FaultyWalk:
    """A phone without that sensor: no fault, but what those of the gyroscope are to be compared with."""
    return from_middle(with_trace(walk, rotation_vector=AxisSamples()))


def gyroscope_stuck(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice) -> FaultyWalk:
    """The gyroscope repeats its last value, in a phone without rotation vector."""
    stream, begin_s = walk.trace.gyroscope, middle_s(walk)
    index = np.minimum(np.arange(len(stream.time_s)), max(int(np.searchsorted(stream.time_s, begin_s)) - 1, 0))
    stuck = AxisSamples(stream.time_s, stream.values[index])
    return from_middle(with_trace(walk, gyroscope=stuck, rotation_vector=AxisSamples()))


def gyroscope_biased(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, bias_rad_per_s: float = 0.2) -> FaultyWalk:
    """The gyroscope gains a bias about the device's z axis, in a phone without rotation vector."""
    biased = _shifted(walk.trace.gyroscope, np.array([0.0, 0.0, bias_rad_per_s]), middle_s(walk))
    return from_middle(with_trace(walk, gyroscope=biased, rotation_vector=AxisSamples()))


def magnet(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, field_ut: float = 200.0) -> FaultyWalk:
    """A magnet comes to rest on the phone: a constant field, several times the earth's, in any direction.

    The rotation vector is left out: what a maker's fusion makes of a magnet cannot be told from an undisturbed walk.
    """
    direction = dice.normal(size=3)
    field = field_ut * direction / np.linalg.norm(direction)
    shifted = _shifted(walk.trace.magnetometer, field, middle_s(walk))
    return from_middle(with_trace(walk, magnetometer=shifted, rotation_vector=AxisSamples()))


def held_across(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice) -> FaultyWalk:
    """The phone is held across, to either side, or the wrong way round: all that it senses is turned about its z axis.

    So is every phone in a building whose plan is not drawn north up.
    """
    turned = Rotation.from_euler("z", dice.choice([-90.0, 90.0, 180.0]), degrees=True)
    trace = walk.trace
    sensed = {
        name: AxisSamples(getattr(trace, name).time_s, turned.inv().apply(getattr(trace, name).values))
        for name in ("accelerometer", "gyroscope", "magnetometer")
        if len(getattr(trace, name).time_s)
    }
    vector = trace.rotation_vector
    if len(vector.time_s):
        w = np.sqrt(np.clip(1.0 - np.square(vector.values).sum(axis=1, keepdims=True), 0.0, 1.0))
        held = Rotation.from_quat(np.hstack([vector.values, w])) * turned
        sensed["rotation_vector"] = AxisSamples(vector.time_s, held.as_quat(canonical=True)[:, :3])
    first_s, last_s = trace.waypoint_time_s[[0, -1]]
    return FaultyWalk(with_trace(walk, **sensed), float(first_s), float(last_s))


def clock_jump(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, jump_s: float = 30.0) -> FaultyWalk:
    """The phone's clock leaps ahead at the waypoint nearest the middle; another at the same place follows the leap."""
    trace = walk.trace
    times = trace.waypoint_time_s
    at = int(np.argmin(np.abs(times - middle_s(walk))))
    begin_s = float(times[at])

    def late(stream: AxisSamples) -> AxisSamples:
        return AxisSamples(stream.time_s + jump_s * (stream.time_s > begin_s), stream.values)

    jumped = with_trace(
        walk,
        waypoint_time_s=np.concatenate((times[: at + 1], times[at:] + jump_s)),
        waypoint_xy_m=np.concatenate((trace.waypoint_xy_m[: at + 1], trace.waypoint_xy_m[at:])),
        scans=tuple(
            replace(scan, time_s=scan.time_s + jump_s, seen_s=scan.seen_s + jump_s * (scan.seen_s > begin_s))
            if scan.time_s > begin_s
            else scan
            for scan in trace.scans
        ),
        **{name: late(getattr(trace, name)) for name in _STREAMS},
    )
    return FaultyWalk(jumped, begin_s, float(times[-1]) + jump_s)


def wrong_start(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice) -> FaultyWalk:
    """The session says that it begins FAR_M from where it does, in any direction."""
    x_m, y_m = walk.trace.waypoint_xy_m[0].tolist()
    angle_rad = dice.uniform(-math.pi, math.pi)
    start = Position(x_m + FAR_M * math.sin(angle_rad), y_m + FAR_M * math.cos(angle_rad), walk.floor)
    first_s, last_s = walk.trace.waypoint_time_s[[0, -1]]
    return FaultyWalk(replace(walk, start=start), float(first_s), float(last_s))


def _shifted(stream: AxisSamples, by: FloatArray, from_s: float) -> AxisSamples:
    return AxisSamples(stream.time_s, stream.values + by * (stream.time_s >= from_s)[:, None])
