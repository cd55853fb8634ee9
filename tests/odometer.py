"""A positioning method so simple that tests can foretell its every Fix: it counts.

x grows by one per batch, y by one per accelerometer sample; there is a position from the first scan on. Access points
with meanings of their own steer its flag.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from app.fusion.interface import Method, SessionStart, Site
from app.fusion.state_codec import storable
from app.observations import Batch, Carrying, Excluded, Fix, Flag, Integrity, Motion, Position

FAULT_BSSID = 0x0A00000000FA
NOT_FINITE_BSSID = 0x0A00000000FB
RAISE_BSSID = 0x0A00000000FC


@storable
@dataclass(frozen=True, slots=True)
class Odometer:
    """State of the method."""

    start: SessionStart
    time_s: float | None = None
    batches: int = 0
    samples: int = 0
    positioned: bool = False


def _start(start: SessionStart) -> Odometer:
    return Odometer(start)


def _advance(state: Odometer, batch: Batch, site: Site) -> tuple[Odometer, Fix]:
    heard = {bssid for scan in batch.wifi for bssid in scan.bssid.tolist()}
    if RAISE_BSSID in heard:
        raise ZeroDivisionError("a defect in the method")
    ends = [time_s for time_s in (state.time_s, batch.end_s) if time_s is not None]
    state = dataclasses.replace(
        state,
        time_s=max(ends, default=None),
        batches=state.batches + 1,
        samples=state.samples + batch.accelerometer.time_s.size,
        positioned=state.positioned or bool(heard),
    )
    return state, _fix(state, FAULT_BSSID in heard, site, float("nan") if NOT_FINITE_BSSID in heard else 2.5)


def _fix(state: Odometer, fault: bool, site: Site, accuracy_m: float) -> Fix:
    flag = Flag.FAULT if fault else Flag.NOMINAL if state.positioned else Flag.INITIALISING
    start = state.start
    integrity: dict[str, Any] = {"alert_limit_m": start.alert_limit_m, "risk": start.risk}
    integrity |= {"usable": state.positioned and not fault, "if1": int(fault), "if2": int(fault), "if3": int(fault)}
    if not state.positioned:
        empty = Integrity(flag=flag, statistic=None, threshold=None, protection_level_m=None, **integrity)
        return Fix(state.time_s, None, None, None, None, None, 0, Motion.UNKNOWN, Carrying.UNKNOWN, empty)
    excluded = (Excluded("weak", observation="wifi"), Excluded("moved", bssid=FAULT_BSSID)) if fault else ()
    level = Integrity(flag=flag, statistic=1.0, threshold=30.0, protection_level_m=6.0, excluded=excluded, **integrity)
    floor = start.floor or sorted(site.floors)[0]
    return Fix(
        time_s=state.time_s,
        position=Position(float(state.batches), float(state.samples), floor),
        accuracy_m=accuracy_m,
        covariance_m2=((1.0, 0.0), (0.0, 1.0)),
        heading_rad=0.5,
        speed_mps=1.25,
        step_count=state.batches,
        motion=Motion.WALKING,
        carrying=Carrying.HANDHELD,
        integrity=level,
    )


ODOMETER = Method("odometer", _start, _advance)
