"""The one clock of a session, the phone's: whether a batch's times follow on those the session has seen."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from app.errors import InvalidInput
from app.estimation.arrays import FloatArray
from app.observations import Batch

LATE_S = 2.0
"""Samples older than the session's newest time by less are late, not wrong: sensors deliver in bursts."""
AHEAD_S = 3600.0
"""The longest silence within a session; a phone that slept for longer opens a new one."""


def refuse_out_of_window(batch: Batch, newest_s: float | None) -> None:
    """Refuses a batch whose times run backwards or jump ahead. The server's clock has no part in it.

    Parameters
    ----------
    newest_s : the newest time that the session accounts for; None before there is one.

    Raises
    ------
    InvalidInput : names the first offending element, or `end`.
    """
    if newest_s is None:
        return
    earliest_s, latest_s = newest_s - LATE_S, newest_s + AHEAD_S
    for field, times_s in _times(batch):
        if times_s[0] < earliest_s:
            raise InvalidInput(
                f"the time runs backwards: over {LATE_S:g} s before what the session has already reported",
                field.format(0),
            )
        if times_s[-1] > latest_s:
            raise InvalidInput(
                f"the time is over {AHEAD_S / 3600:g} h ahead of the session; after such a silence open a new one",
                field.format(int(np.argmax(times_s > latest_s))),
            )
    if batch.end_s is not None and not earliest_s <= batch.end_s <= latest_s:
        raise InvalidInput(
            f"`end` is {'before' if batch.end_s < earliest_s else 'far ahead of'} what the session has reported", "end"
        )


def _times(batch: Batch) -> Iterator[tuple[str, FloatArray]]:
    """The times of every stream that has samples, with the pattern of its elements' names."""
    for name in ("accelerometer", "gyroscope", "magnetometer", "rotation_vector", "barometer"):
        times_s: FloatArray = getattr(batch, name).time_s
        if times_s.size:
            yield f"{name}.t[{{}}]", times_s
    for name in ("wifi", "bluetooth"):
        scans = getattr(batch, name)
        if scans:
            yield f"{name}[{{}}].t", np.array([scan.time_s for scan in scans])
