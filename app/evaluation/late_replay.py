"""Walks as their smoothed tracks have them: after the whole walk, and some seconds late."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from app.evaluation.campaign import Protocol, coverage_of, parted, surveyed
from app.evaluation.parallel import in_order
from app.evaluation.recordings import FloorFolder, RecordedWalk
from app.evaluation.replay import Answer, Coverage, replay
from app.fusion.interface import Method, SessionStart, Site
from app.fusion.smoothed_track import KnownThen, SmoothedTrack
from app.fusion.track_smoothing import smoothed
from app.fusion.walk_timeline import Moment
from app.observations import Batch, Fix

LATE_S = 4.0
"""Of the fixed lag: every place is told so much later, from what was measured by then."""


@dataclass(frozen=True, slots=True, eq=False)
class _Fold:
    """What all walks of a fold have in common."""

    fold: int
    site: Site
    coverage: Coverage
    protocol: Protocol


def late_rows(
    floors: Sequence[FloorFolder],
    walks: Sequence[RecordedWalk],
    methods: Mapping[str, Method],
    protocol: Protocol,
    jobs: int = 1,
    done: Callable[[], None] = lambda: None,
) -> dict[str, list[Answer]]:
    """Answers of each method's smoothed tracks, in the order of folds, floors, walks and time.

    Parameters
    ----------
    done : called after each walk; there are as many as methods times test walks.

    Returns
    -------
    Of each method `NAME smoothed`, by the whole walk, and `NAME 4 s late`.
    """
    rows: dict[str, list[Answer]] = {}
    for fold in protocol.tested:
        survey, walked = parted(walks, protocol, fold)
        common = _Fold(fold, surveyed(floors, survey), coverage_of(survey), protocol)
        for name, method in methods.items():
            after, late = rows.setdefault(f"{name} smoothed", []), rows.setdefault(f"{name} {LATE_S:g} s late", [])
            for found in in_order(partial(_both, method, common), walked, jobs):
                done()
                after += found[0]
                late += found[1]
    return rows


def _both(method: Method, common: _Fold, walk: RecordedWalk) -> tuple[list[Answer], list[Answer]]:
    protocol = common.protocol
    start = SessionStart(alert_limit_m=protocol.alert_limit_m, risk=protocol.risk, start=walk.start)
    fixes: list[Fix] = []

    def advance(state: Any, batch: Batch, site: Site) -> tuple[Any, Fix]:
        state, fix = method.advance(state, batch, site)
        fixes.append(fix)
        return state, fix

    answers = replay(
        replace(method, advance=advance),
        start,
        walk,
        common.site,
        common.coverage,
        protocol.seconds,
        common.fold,
        protocol.bluetooth,
    )
    walls = method.walls and common.site.space(walk.floor).walled
    after = smoothed_answers(answers, fixes, walk.floor, protocol.risk, walls=walls)
    return after, smoothed_answers(answers, fixes, walk.floor, protocol.risk, LATE_S, walls)


def smoothed_answers(
    answers: Sequence[Answer],
    fixes: Sequence[Fix],
    floor: str,
    risk: float,
    late_s: float = math.inf,
    walls: bool = False,
) -> list[Answer]:
    """The answers to a walk's batches as the smoothed track has them; those without a position stay as they are.

    Parameters
    ----------
    fixes : one to each answer.  floor : the walker's.
    late_s : from what was measured up to so long after each.  walls : whether these had a part in the fixes.
    """
    times = np.array([answer.time_s for answer in answers])
    tracks: dict[int, SmoothedTrack | None] = {}
    found = []
    for index, (answer, fix) in enumerate(zip(answers, fixes, strict=True)):
        known = int(np.searchsorted(times, answer.time_s + late_s, side="right"))
        if known not in tracks:
            evidence = list(chain.from_iterable(one.evidence for one in fixes[:known]))
            moments = [Moment(time_s, one.motion) for time_s, one in zip(times[:known].tolist(), fixes, strict=False)]
            tracks[known] = smoothed(evidence, moments)
        track = tracks[known]
        level_m = fix.integrity.protection_level_m
        if track is None or fix.position is None or level_m is None:
            found.append(answer)
            continue
        at, integrity = fix.position, fix.integrity
        then = KnownThen(
            at.x_m,
            at.y_m,
            level_m,
            integrity.alert_limit_m,
            integrity.if2,
            integrity.if3,
            fix.floor_certain,
            fix.unsurveyed_m2,
            walls,
        )
        told = track.answer(index, risk, then)
        (xx, xy), (_, yy) = told.covariance_m2.tolist()
        x_m, y_m = told.xy_m.tolist()
        found.append(
            replace(
                answer,
                xy_m=(x_m, y_m),
                error_m=math.hypot(x_m - answer.truth_xy_m[0], y_m - answer.truth_xy_m[1]),
                floor_right=track.floor[index] == floor,
                accuracy_m=told.accuracy_m,
                covariance_m2=((xx, xy), (xy, yy)),
                protection_level_m=told.level_m,
                usable=told.usable,
            )
        )
    return found
