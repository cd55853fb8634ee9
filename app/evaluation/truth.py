"""Where the walker really was, and the batches the phone would have sent."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.observations import AxisSamples, Batch
from app.survey.trace import Trace


def places_at(trace: Trace, time_s: FloatArray) -> FloatArray:
    """(n, 2) true places in metres: exact at waypoints, linear in time between them, the end point beyond them."""
    x_m, y_m = (np.interp(time_s, trace.waypoint_time_s, trace.waypoint_xy_m[:, axis]) for axis in (0, 1))
    return np.column_stack((x_m, y_m))


def scan_places(trace: Trace) -> FloatArray:
    """(n, 2) places of the scans between the first and the last waypoint."""
    times = np.array([scan.time_s for scan in trace.scans])
    within = (times >= trace.waypoint_time_s[0]) & (times <= trace.waypoint_time_s[-1])
    return places_at(trace, times[within])


def cut_times_ms(trace: Trace, seconds: float) -> IntArray:
    """When batches end: at every waypoint, and every so many seconds from the first one to the last, in Unix ms."""
    waypoints = np.rint(1000.0 * trace.waypoint_time_s).astype(np.int64)
    first, last = int(waypoints[0]), int(waypoints[-1])
    count = int((last - first) / 1000.0 / seconds)
    regular = [int(first + 1000.0 * seconds * k) for k in range(1, count + 1)]
    return np.union1d(waypoints, np.array(regular, dtype=np.int64))


def batches_of(trace: Trace, seconds: float = 1.0, bluetooth: bool = False) -> Iterator[Batch]:
    """The walk as the phone sends it: each batch holds every sample up to its end and not one later.

    The first ends at the first waypoint and holds whatever was recorded before it.

    Parameters
    ----------
    seconds : longest batch.  bluetooth : send what was heard of beacons, too.
    """
    heard = trace.bluetooth if bluetooth else ()
    after_s = -np.inf
    for sequence, cut_ms in enumerate(cut_times_ms(trace, seconds).tolist()):
        end_s = cut_ms / 1000.0  # as sample times are made, so that a sample at the cut compares equal
        yield Batch(
            sequence=sequence,
            end_s=end_s,
            accelerometer=_between(trace.accelerometer, after_s, end_s),
            gyroscope=_between(trace.gyroscope, after_s, end_s),
            magnetometer=_between(trace.magnetometer, after_s, end_s),
            rotation_vector=_between(trace.rotation_vector, after_s, end_s),
            wifi=tuple(scan for scan in trace.scans if after_s < scan.time_s <= end_s),
            bluetooth=tuple(scan for scan in heard if after_s < scan.time_s <= end_s),
        )
        after_s = end_s


def _between(stream: AxisSamples, after_s: float, until_s: float) -> AxisSamples:
    first, last = np.searchsorted(stream.time_s, (after_s, until_s), side="right")
    return AxisSamples(stream.time_s[first:last], stream.values[first:last])
