"""Sensor columns of a batch body: from lists of numbers to checked arrays in SI units and seconds.

Bounds are several times what phone sensors can report (16 g, 35 rad/s, 5 mT, 300-1100 hPa), so what lies beyond is a
unit mistaken or a number corrupted, not a hard knock. Of the barometer, which only says on which floor, it costs the
sample.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.errors import InvalidInput
from app.estimation.arrays import BoolArray, FloatArray
from app.observations import AxisSamples, PressureSamples
from app.survey.admission import LATEST_MS

EARLIEST_MS = 1.0
LARGEST_SPAN_MS = 15 * 60_000.0
"""Between the oldest and the newest time of one batch."""
AXIS_LIMITS = {
    "accelerometer": (400.0, "m/s^2"),
    "gyroscope": (100.0, "rad/s"),
    "magnetometer": (10_000.0, "microtesla"),
    "rotation_vector": (1.01, "as a component of a unit quaternion"),
}
"""Largest magnitude of a component, and its unit."""
ROTATION_NORM_LIMIT = 1.05
PRESSURE_LIMITS_HPA = (100.0, 1200.0)


def axis_samples(
    stream: str, t: Sequence[float], x: Sequence[float], y: Sequence[float], z: Sequence[float]
) -> AxisSamples:
    """Three columns of one stream as samples.

    Raises
    ------
    InvalidInput : names the column, and the index where there is one: lengths differ, time runs backwards or is out of
        bounds, a value is implausible.
    """
    for name, column in (("x", x), ("y", y), ("z", z)):
        _refuse_other_length(f"{stream}.{name}", column, t)
    if not t:
        return AxisSamples()
    values = np.array((x, y, z))
    limit, unit = AXIS_LIMITS[stream]
    beyond = np.abs(values) > limit
    if beyond.any():
        axis, index = np.argwhere(beyond)[0].tolist()
        raise InvalidInput(
            f"a {stream} value beyond +-{limit:g} {unit} is not plausible", f"{stream}.{'xyz'[axis]}[{index}]"
        )
    if stream == "rotation_vector":
        _refuse_where(
            np.einsum("an,an->n", values, values) > ROTATION_NORM_LIMIT**2,
            f"{stream}.x",
            f"x, y, z of a unit quaternion have a norm of at most 1, not beyond {ROTATION_NORM_LIMIT}",
        )
    return AxisSamples(times_s(f"{stream}.t", t), np.ascontiguousarray(values.T))


def pressure_samples(t: Sequence[float], pressure: Sequence[float]) -> tuple[PressureSamples, int]:
    """The barometer's columns as samples, and how many were dropped: those of a broken one, which says 0 hPa.

    Raises
    ------
    InvalidInput : as axis_samples does, but never for a value.
    """
    _refuse_other_length("barometer.pressure", pressure, t)
    if not t:
        return PressureSamples(), 0
    times, values = times_s("barometer.t", t), np.array(pressure)
    low, high = PRESSURE_LIMITS_HPA
    usable = (values >= low) & (values <= high)
    return PressureSamples(times[usable], values[usable]), int(np.count_nonzero(~usable))


def times_s(field: str, t: Sequence[float], item: str = "[{}]") -> FloatArray:
    """Times in seconds of a column in milliseconds that must not run backwards nor jump by hours.

    Parameters
    ----------
    field : name of the column.  item : how its elements are named, after field, by index.

    Raises
    ------
    InvalidInput : names the first offending element.
    """
    times = np.array(t, dtype=np.float64)
    _refuse_where(
        (times < EARLIEST_MS) | (times > LATEST_MS),
        field,
        "a time is Unix epoch milliseconds, before the year 2100",
        item,
    )
    _refuse_where(
        np.diff(times, prepend=times[:1]) < 0.0, field, "the time runs backwards; columns are ordered by time", item
    )
    _refuse_where(
        times - times[:1] > LARGEST_SPAN_MS, field, f"a batch spans at most {LARGEST_SPAN_MS / 60_000:g} minutes", item
    )
    return times / 1000.0


def refuse_scattered(times_ms: dict[str, tuple[float, float]], end_ms: float | None) -> None:
    """Refuses a stream that lies hours away from the rest of its batch, and an `end` that does not fit.

    Parameters
    ----------
    times_ms : oldest and newest time by the name of the field that holds them.  end_ms : the batch's `end`.

    Raises
    ------
    InvalidInput : names the stream that lies farthest from the others, or `end`.
    """
    if not times_ms:
        return
    newest = max(last for _, last in times_ms.values())
    if newest - min(first for first, _ in times_ms.values()) > LARGEST_SPAN_MS:
        anchor = sorted(last for _, last in times_ms.values())[(len(times_ms) - 1) // 2] if end_ms is None else end_ms
        field = max(times_ms, key=lambda name: max(abs(time - anchor) for time in times_ms[name]))
        raise InvalidInput(
            f"lies far from the rest of the batch, which spans at most {LARGEST_SPAN_MS / 60_000:g} minutes", field
        )
    if end_ms is None:
        return
    if end_ms < newest:
        raise InvalidInput(f"`end` is before the newest sample ({newest:.0f})", "end")
    if end_ms - newest > LARGEST_SPAN_MS:
        raise InvalidInput(f"`end` is over {LARGEST_SPAN_MS / 60_000:g} minutes after the newest sample", "end")


def _refuse_other_length(field: str, column: Sequence[float], t: Sequence[float]) -> None:
    if len(column) != len(t):
        raise InvalidInput(f"has {len(column)} values where t has {len(t)}; columns are equally long", field)


def _refuse_where(wrong: BoolArray, field: str, message: str, item: str = "[{}]") -> None:
    if wrong.any():
        raise InvalidInput(message, field + item.format(int(np.argmax(wrong))))
