"""Every method over every test walk of the folds asked for, in one process or several."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from app.errors import InvalidInput
from app.evaluation.parallel import in_order
from app.evaluation.recordings import FloorFolder, RecordedWalk, is_test_walk, read_walk
from app.evaluation.replay import Answer, Coverage, replay
from app.fusion.interface import Method, SessionStart, Site, spaces_of
from app.wifi.fix_calibration import calibrated_map

Advance = Callable[[], None]
"""Called once for every piece of work done."""


@dataclass(frozen=True, slots=True)
class Protocol:
    """How walks are split, replayed and judged.

    folds : parts that the walks fall into by the hash of their name.  tested : which of them are walked, one after the
    other, each on a map of the rest.  limit : test walks a floor and fold at most.  seconds : longest batch.
    bluetooth : phones report beacons, too.  survey_share : of the survey walks that the map is made of, for buildings
    that were surveyed with gaps; which ones, the hash of their name decides.
    """

    folds: int = 5
    tested: tuple[int, ...] = (0,)
    limit: int | None = None
    seconds: float = 1.0
    alert_limit_m: float = 10.0
    risk: float = 0.01
    bluetooth: bool = False
    survey_share: float = 1.0

    def __post_init__(self) -> None:
        if self.folds < 2:
            raise InvalidInput("folds must be 2 or more: with one there is no survey left", "folds")
        if not self.tested or not all(0 <= fold < self.folds for fold in self.tested):
            raise InvalidInput(f"fold must be one of 0 to {self.folds - 1}, or all", "fold")
        if not 0.0 < self.seconds <= 60.0:
            raise InvalidInput("seconds must be in (0, 60]", "seconds")
        if not 0.001 <= self.risk <= 0.05:
            raise InvalidInput("risk must be in 0.001 to 0.05", "risk")
        if not self.alert_limit_m > 0.0:
            raise InvalidInput("the alert limit must be positive", "alert_limit")
        if not 0.0 < self.survey_share <= 1.0:
            raise InvalidInput("the share of the survey must be in (0, 1]", "survey_share")

    def surveys(self, trace: str, fold: int) -> bool:
        """Whether the map that a fold is walked on is made of this trace."""
        kept = zlib.crc32(trace.encode()) < self.survey_share * 2**32
        return kept and not is_test_walk(trace, self.folds, fold)


@dataclass(frozen=True, slots=True, eq=False)
class _Setting:
    """What all replays of a fold have in common."""

    fold: int
    site: Site
    coverage: Coverage
    methods: Mapping[str, Method]
    protocol: Protocol


def read_walks(floors: Sequence[FloorFolder], jobs: int = 1, done: Advance = lambda: None) -> list[RecordedWalk]:
    """Read and place every trace of the floors, in order; traces without truth are left out."""
    files = [(folder.floor.floor, path) for folder in floors for path in folder.traces]
    walks = []
    for walk in in_order(_read, files, jobs):
        done()
        if walk is not None:
            walks.append(walk)
    return walks


def walked_in(walks: Sequence[RecordedWalk], protocol: Protocol, fold: int) -> list[RecordedWalk]:
    """The walks of a fold that are replayed: the first so many of each floor."""
    chosen: list[RecordedWalk] = []
    taken: Counter[str] = Counter()
    for walk in walks:
        if is_test_walk(walk.trace.trace, protocol.folds, fold) and taken[walk.floor] != protocol.limit:
            taken[walk.floor] += 1
            chosen.append(walk)
    return chosen


def parted(
    walks: Sequence[RecordedWalk], protocol: Protocol, fold: int
) -> tuple[list[RecordedWalk], list[RecordedWalk]]:
    """The survey walks of a fold, and those that are replayed on their map.

    Raises
    ------
    InvalidInput : there are none of one kind.
    """
    survey = [walk for walk in walks if protocol.surveys(walk.trace.trace, fold)]
    walked = walked_in(walks, protocol, fold)
    if not survey or not walked:
        raise InvalidInput(f"fold {fold} leaves {len(survey)} survey walks and {len(walked)} test walks", "fold")
    return survey, walked


def surveyed(floors: Sequence[FloorFolder], survey: Sequence[RecordedWalk]) -> Site:
    """The site with the map of these walks, and the walls that its plans draw."""
    radio_map = calibrated_map([one for walk in survey for one in walk.fingerprints])
    plans = {folder.floor.floor: folder.plan for folder in floors}
    named = {folder.floor.floor: folder.floor for folder in floors}
    return Site(named, radio_map, spaces=spaces_of(named.values(), plans, radio_map))


def run(
    floors: Sequence[FloorFolder],
    walks: Sequence[RecordedWalk],
    methods: Mapping[str, Method],
    protocol: Protocol,
    jobs: int = 1,
    done: Advance = lambda: None,
) -> dict[str, list[Answer]]:
    """Replay the test walks of every fold through every method.

    Parameters
    ----------
    done : called after each replayed walk; there are as many as methods times test walks.

    Returns
    -------
    Answers of each method in the order of folds, floors, walks and time, whatever the number of jobs.

    Raises
    ------
    InvalidInput : a fold without survey or without test walks.
    """
    answers: dict[str, list[Answer]] = {name: [] for name in methods}
    for fold in protocol.tested:
        survey, walked = parted(walks, protocol, fold)
        found = replayed(surveyed(floors, survey), coverage_of(survey), walked, methods, protocol, fold, jobs, done)
        for name, of_fold in found.items():
            answers[name] += of_fold
    return answers


def replayed(
    site: Site,
    coverage: Coverage,
    walked: Sequence[RecordedWalk],
    methods: Mapping[str, Method],
    protocol: Protocol,
    fold: int = 0,
    jobs: int = 1,
    done: Advance = lambda: None,
) -> dict[str, list[Answer]]:
    """Answers of each method on a site, in the order of walks and time. fold : what to call these walks in them."""
    answers: dict[str, list[Answer]] = {name: [] for name in methods}
    setting = _Setting(fold, site, coverage, methods, protocol)
    tasks = [(name, walk) for name in methods for walk in walked]
    for (name, _), found in zip(tasks, in_order(partial(_replay, setting), tasks, jobs), strict=True):
        done()
        answers[name] += found
    return answers


def coverage_of(survey: Sequence[RecordedWalk]) -> Coverage:
    """Where these walks took scans."""
    floors = {walk.floor for walk in survey}
    return Coverage({floor: np.concatenate([w.scan_xy_m for w in survey if w.floor == floor]) for floor in floors})


def _read(file: tuple[str, Path]) -> RecordedWalk | None:
    return read_walk(*file)


def _replay(setting: _Setting, task: tuple[str, RecordedWalk]) -> list[Answer]:
    name, walk = task
    protocol = setting.protocol
    start = SessionStart(alert_limit_m=protocol.alert_limit_m, risk=protocol.risk, start=walk.start)
    return replay(
        setting.methods[name],
        start,
        walk,
        setting.site,
        setting.coverage,
        protocol.seconds,
        setting.fold,
        protocol.bluetooth,
    )
