"""A recorded walk with a fault in it, and what a fault may draw on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from app.estimation.arrays import FloatArray
from app.evaluation.recordings import RecordedWalk
from app.observations import WifiScan

FAR_M = 40.0
"""From how far away foreign readings come, and how far a wrong start is off."""
Dice = np.random.Generator


@dataclass(frozen=True, slots=True, eq=False)
class Elsewhere:
    """Scans of one floor's survey walks, one walk after the other. xy_m : (n, 2) where each was taken."""

    xy_m: FloatArray
    scans: tuple[WifiScan, ...]


@dataclass(frozen=True, slots=True, eq=False)
class FaultyWalk:
    """A walk with a fault that is there from begin_s to end_s. access_points : those that are not as surveyed."""

    walk: RecordedWalk
    begin_s: float
    end_s: float
    access_points: frozenset[int] = frozenset()


Injector = Callable[[RecordedWalk, Elsewhere, Dice], FaultyWalk | None]
"""None where the walk offers nothing to fault: no scan after the middle, no place far enough away."""


def elsewhere_of(survey: Sequence[RecordedWalk]) -> Elsewhere:
    """The scans of these walks of one floor that were taken between waypoints."""
    scans: list[WifiScan] = []
    for walk in survey:
        first_s, last_s = walk.trace.waypoint_time_s[[0, -1]]
        scans += [scan for scan in walk.trace.scans if first_s <= scan.time_s <= last_s]
    places = [walk.scan_xy_m for walk in survey]
    return Elsewhere(np.concatenate([np.empty((0, 2)), *places]), tuple(scans))


def middle_s(walk: RecordedWalk) -> float:
    """Halfway in time from the first waypoint to the last."""
    return float(walk.trace.waypoint_time_s[[0, -1]].mean())


def with_trace(walk: RecordedWalk, **changes: Any) -> RecordedWalk:
    """The walk with other fields of its trace."""
    return replace(walk, trace=replace(walk.trace, **changes))


def from_middle(walk: RecordedWalk) -> FaultyWalk:
    """The walk with a fault from its middle to its end."""
    return FaultyWalk(walk, middle_s(walk), float(walk.trace.waypoint_time_s[-1]))
