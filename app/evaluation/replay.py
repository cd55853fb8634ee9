"""One walk through one method, and what is kept of every answer."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from app.errors import SurefixError
from app.estimation.arrays import FloatArray
from app.evaluation.recordings import RecordedWalk
from app.evaluation.truth import batches_of, places_at
from app.fusion.interface import Method, SessionStart, Site
from app.observations import Flag

WalkKey = tuple[int, str, str]
"""Fold, floor, walk."""
COVERED_WITHIN_M = 5.0
"""A place is covered when a survey scan was taken this near on its floor."""


@dataclass(frozen=True, slots=True)
class Answer:
    """A Fix beside the truth.

    waypoint : the truth is exact here.  scanned : the phone has sent a scan by now.  error_m : horizontal, None without
    a position.  covariance_m2 : ((xx, xy), (xy, yy)).  spent_s : what the method took for the batch.
    excluded : access points that are left out.
    """

    fold: int
    floor: str
    walk: str
    time_s: float
    truth_xy_m: tuple[float, float]
    waypoint: bool
    covered: bool
    scanned: bool
    xy_m: tuple[float, float] | None
    error_m: float | None
    floor_right: bool
    accuracy_m: float | None
    covariance_m2: tuple[tuple[float, float], tuple[float, float]] | None
    flag: Flag
    usable: bool
    protection_level_m: float | None
    alert_limit_m: float
    spent_s: float
    excluded: frozenset[int] = frozenset()

    @property
    def walk_key(self) -> WalkKey:
        """Of the walk that this is an answer of, among those of all folds and floors."""
        return self.fold, self.floor, self.walk

    def beyond(self, bound_m: float | None) -> bool:
        """Whether the truth is outside a radius: a wrong floor, no position and no radius are outside."""
        return self.error_m is None or not self.floor_right or bound_m is None or self.error_m > bound_m


class Coverage:
    """Which places the survey reached, floor by floor."""

    def __init__(self, survey: dict[str, FloatArray]) -> None:
        self._trees = {floor: cKDTree(places) for floor, places in survey.items() if len(places)}

    def covers(self, floor: str, xy_m: FloatArray) -> list[bool]:
        """Of each of the (n, 2) places, whether a survey scan of its floor was taken within COVERED_WITHIN_M."""
        if floor not in self._trees:
            return [False] * len(xy_m)
        distance_m, _ = self._trees[floor].query(xy_m)
        return [bool(covered) for covered in distance_m <= COVERED_WITHIN_M]


def replay(
    method: Method,
    start: SessionStart,
    walk: RecordedWalk,
    site: Site,
    coverage: Coverage,
    seconds: float,
    fold: int = 0,
    bluetooth: bool = False,
) -> list[Answer]:
    """Every answer to the batches of a walk. bluetooth : they hold what was heard of beacons, too.

    Raises
    ------
    SurefixError : a position that is not finite; the answer would be worthless and its figures silently wrong.
    """
    trace = walk.trace
    batches = list(batches_of(trace, seconds, bluetooth))
    ends = np.array([batch.end_s for batch in batches])
    truth = places_at(trace, ends)
    covered = coverage.covers(walk.floor, truth)
    waypoints = set(trace.waypoint_time_s.tolist())
    first_scan_s = trace.scans[0].time_s if trace.scans else math.inf
    answers = []
    state = method.start(start)
    for index, (batch, end_s) in enumerate(zip(batches, ends.tolist(), strict=True)):
        began = time.perf_counter()
        state, fix = method.advance(state, batch, site)
        spent_s = time.perf_counter() - began
        x_m, y_m = truth[index].tolist()
        position = fix.position
        error_m = None if position is None else math.hypot(position.x_m - x_m, position.y_m - y_m)
        if error_m is not None and not math.isfinite(error_m):
            raise SurefixError(f"{trace.trace} batch {batch.sequence}: {method.method} gave {position}")
        answers.append(
            Answer(
                fold=fold,
                floor=walk.floor,
                walk=trace.trace,
                time_s=end_s,
                truth_xy_m=(x_m, y_m),
                waypoint=end_s in waypoints,
                covered=covered[index],
                scanned=end_s >= first_scan_s,
                xy_m=None if position is None else (position.x_m, position.y_m),
                error_m=error_m,
                floor_right=position is not None and position.floor == walk.floor,
                accuracy_m=fix.accuracy_m,
                covariance_m2=fix.covariance_m2,
                flag=fix.integrity.flag,
                usable=fix.integrity.usable,
                protection_level_m=fix.integrity.protection_level_m,
                alert_limit_m=start.alert_limit_m,
                spent_s=spent_s,
                excluded=frozenset(one.bssid for one in fix.integrity.excluded if one.bssid is not None),
            )
        )
    return answers
