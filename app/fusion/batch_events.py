"""A batch in the order in which the phone came to know it, whatever the batches are cut like.

Scans and the samples between them alternate: each scan comes with all that the inertial sensors had told by then, so
that a step found late, with its true time before a scan, meets that scan in the same order in a batch of a tenth of a
second and in one of a minute.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from app.observations import Batch, BluetoothScan, WifiScan
from app.pdr import sample_order
from app.pdr.gyroscope_stuck import gyroscope_stuck
from app.pdr.tracker import PdrOutput, PdrState, advance_pdr

GYROSCOPE_STALE_S = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Event:
    """What happened up to a moment.

    time_s : the moment; None in a session that has reported nothing yet.  pdr : dead reckoning's state then.
    moved : what it says of the samples since the event before.  scan, beacons : what was delivered at the
    moment, one of the two; both None at the end.
    """

    time_s: float | None
    pdr: PdrState
    moved: PdrOutput
    scan: WifiScan | None
    beacons: BluetoothScan | None = None


def events(pdr: PdrState, time_s: float | None, batch: Batch, bluetooth: bool = False) -> Iterator[Event]:
    """Every scan of the batch in order of time, then the end of the batch.

    Parameters
    ----------
    pdr, time_s : as the last event of the batch before left them.
    bluetooth : scans of beacons are events, too.

    Notes
    -----
    Time never runs back: a scan older than what was reported before counts as delivered now.
    """
    scans: tuple[WifiScan | BluetoothScan, ...] = (*batch.wifi, *batch.bluetooth) if bluetooth else batch.wifi
    for scan in sorted(scans, key=lambda one: one.time_s):
        pdr, moved = advance_pdr(pdr, batch, until_s=scan.time_s)
        time_s = scan.time_s if time_s is None else max(time_s, scan.time_s)
        if isinstance(scan, WifiScan):
            yield Event(time_s, pdr, moved, scan)
        else:
            yield Event(time_s, pdr, moved, None, scan)
    pdr, moved = advance_pdr(pdr, batch)
    yield Event(end_of(batch, time_s), pdr, moved, None)


def end_of(batch: Batch, before_s: float | None) -> float | None:
    """Up to when the phone has reported: what the batch says, else its newest sample, never before what is known."""
    newest = -math.inf if before_s is None else before_s
    if batch.end_s is not None:
        newest = max(newest, batch.end_s)
    else:
        streams = (batch.accelerometer, batch.gyroscope, batch.magnetometer, batch.rotation_vector, batch.barometer)
        for stream in streams:
            if len(stream.time_s):
                newest = max(newest, float(stream.time_s[-1]))
        newest = max([newest, *(scan.time_s for scan in batch.wifi), *(scan.time_s for scan in batch.bluetooth)])
    return newest if math.isfinite(newest) else None


def knows_turns(event: Event) -> bool:
    """Whether there is a gyroscope that works, without which a phone that lacks north knows no turns either."""
    attitude = event.pdr.attitude
    newest = attitude.time_s
    fresh = bool(newest[sample_order.GYR] > newest[sample_order.ACC] - GYROSCOPE_STALE_S)
    return fresh and not gyroscope_stuck(attitude.scalars, attitude.rest, attitude.magnetic)
