"""Every fault in every test walk, and what the method said meanwhile."""

from __future__ import annotations

import math
import statistics
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from app.evaluation.campaign import Advance, Protocol, coverage_of, parted, replayed, surveyed
from app.evaluation.exclusions import InPlay, exclusions, in_play
from app.evaluation.faulty_walk import Elsewhere, FaultyWalk, Injector, elsewhere_of
from app.evaluation.recordings import FloorFolder, RecordedWalk
from app.evaluation.replay import Answer
from app.evaluation.scoring import quantile
from app.fusion.interface import Method
from app.observations import Flag

CLEAN = "none"
"""The row of the walks as recorded."""
DETECTION_S = 6.0
"""Within which a fault is to be told: three scans of a phone in the hand, the detection time of the first paper."""
WalkKey = tuple[int, str, str]
"""Fold, floor, walk."""


@dataclass(frozen=True, slots=True)
class Answered:
    """Answers to the walks with one fault; of each walk window : when it was there, in_play : what is to be found."""

    answers: list[Answer]
    window: dict[WalkKey, tuple[float, float]]
    in_play: dict[WalkKey, InPlay] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class FaultScore:
    """One row of the table. Shares are of the answers while the fault is there, NaN of nothing.

    walks : with an answer under the fault.  alarmed : walks with flag fault meanwhile.  alarmed_in_time : within
    DETECTION_S.  median_alert_s : of those alarmed, from the first answer under the fault.  missed : walks with a
    hazardous answer later than DETECTION_S and no alarm before it.  hazardous_late : share of answers after DETECTION_S
    that are hazardous, hazardous_unalerted : and before any alarm.  inside_level : share of positions.  error_usable_m,
    error_end_m : mean error of usable answers, and at the last position under the fault.  waypoints_m,
    waypoints_clean_m : mean error at covered waypoints of these walks, all along, with the fault and without it.
    faulty_found, sound_excluded : shares of the faulty and of the sound access points that were left out at any time.
    """

    walks: int
    alarmed: int
    alarmed_in_time: int
    median_alert_s: float
    missed: int
    usable: float
    hazardous: float
    hazardous_late: float
    hazardous_unalerted: float
    inside_level: float
    error_usable_m: float
    error_end_m: float
    waypoints_m: float
    waypoints_clean_m: float
    faulty_found: float
    sound_excluded: float


def injected(
    walked: Sequence[RecordedWalk], elsewhere: Mapping[str, Elsewhere], fault: str, injector: Injector, seed: int
) -> list[FaultyWalk]:
    """The walks with this fault; those that offer nothing to fault are left out.

    What befalls a walk depends on the seed, the fault and the walk's name alone, not on the other walks or faults.
    """
    found = []
    for walk in walked:
        names = [zlib.crc32(name.encode()) for name in (fault, walk.floor, walk.trace.trace)]
        faulty = injector(walk, elsewhere[walk.floor], np.random.default_rng([seed, *names]))
        if faulty is not None:
            found.append(faulty)
    return found


def run_faults(
    floors: Sequence[FloorFolder],
    walks: Sequence[RecordedWalk],
    methods: Mapping[str, Method],
    faults: Mapping[str, Injector],
    protocol: Protocol,
    seed: int,
    jobs: int = 1,
    done: Advance = lambda: None,
) -> dict[str, dict[str, Answered]]:
    """Replay the test walks of every fold, as recorded and with each fault, through every method.

    Returns
    -------
    Method -> fault -> answers, CLEAN first. The map and its calibration are of the survey walks, without any fault.

    Raises
    ------
    InvalidInput : a fold without survey or without test walks.
    """
    found = {name: {fault: Answered([], {}) for fault in (CLEAN, *faults)} for name in methods}
    for fold in protocol.tested:
        survey, walked = parted(walks, protocol, fold)
        site, coverage = surveyed(floors, survey), coverage_of(survey)
        elsewhere = {
            floor: elsewhere_of([w for w in survey if w.floor == floor]) for floor in {w.floor for w in walked}
        }
        rows = {CLEAN: [FaultyWalk(walk, -math.inf, math.inf) for walk in walked]}
        rows |= {fault: injected(walked, elsewhere, fault, injector, seed) for fault, injector in faults.items()}
        for fault, faulty in rows.items():
            window = {(fold, f.walk.floor, f.walk.trace.trace): (f.begin_s, f.end_s) for f in faulty}
            as_recorded = {(walk.floor, walk.trace.trace): walk for walk in walked}
            playing = {
                (fold, *key): in_play(f, as_recorded[key])
                for f in faulty
                if (key := (f.walk.floor, f.walk.trace.trace))
            }
            of_fold = replayed(site, coverage, [f.walk for f in faulty], methods, protocol, fold, jobs, done)
            for name, answers in of_fold.items():
                found[name][fault].answers.extend(answers)
                found[name][fault].window.update(window)
                found[name][fault].in_play.update(playing)
    return found


def fault_score(faulty: Answered, clean: Sequence[Answer], alert_limit_m: float) -> FaultScore:
    """Judge the answers of one method to one fault; clean : its answers to the walks as recorded."""
    under: dict[WalkKey, list[Answer]] = {}
    for answer in faulty.answers:
        begin_s, end_s = faulty.window[_walk(answer)]
        if begin_s <= answer.time_s <= end_s:
            under.setdefault(_walk(answer), []).append(answer)
    waits = [_until_alarm_s(found) for found in under.values()]
    hazards = [
        [a.time_s - found[0].time_s for a in found if a.usable and a.beyond(alert_limit_m)] for found in under.values()
    ]
    late = [sum(DETECTION_S < at_s < wait_s for at_s in times) for times, wait_s in zip(hazards, waits, strict=True)]
    ends = [[a.error_m for a in found if a.error_m is not None][-1:] for found in under.values()]
    answers = [a for found in under.values() for a in found]
    after = sum(a.time_s - found[0].time_s > DETECTION_S for found in under.values() for a in found)
    placed = [a for a in answers if a.error_m is not None]
    out = exclusions(faulty.answers, faulty.in_play)
    return FaultScore(
        walks=len(under),
        alarmed=sum(map(math.isfinite, waits)),
        alarmed_in_time=sum(wait_s <= DETECTION_S for wait_s in waits),
        median_alert_s=quantile([wait_s for wait_s in waits if math.isfinite(wait_s)], 0.5),
        missed=sum(count > 0 for count in late),
        usable=_share(sum(a.usable for a in answers), len(answers)),
        hazardous=_share(sum(map(len, hazards)), len(answers)),
        hazardous_late=_share(sum(at_s > DETECTION_S for times in hazards for at_s in times), after),
        hazardous_unalerted=_share(sum(late), after),
        inside_level=_share(sum(not a.beyond(a.protection_level_m) for a in placed), len(placed)),
        error_usable_m=_mean([a.error_m for a in answers if a.usable and a.error_m is not None]),
        error_end_m=_mean([error_m for last in ends for error_m in last]),
        waypoints_m=_mean(_waypoint_errors(faulty.answers)),
        waypoints_clean_m=_mean(_waypoint_errors([a for a in clean if _walk(a) in faulty.window])),
        faulty_found=_share(out.found, out.faulty),
        sound_excluded=_share(out.wrong, out.sound),
    )


def at_limit(answered: Answered, alert_limit_m: float) -> Answered:
    """What sessions with a smaller alert limit than these had would have been told."""

    def told(answer: Answer) -> Answer:
        level_m = answer.protection_level_m
        usable = answer.usable and level_m is not None and level_m <= alert_limit_m
        return replace(answer, usable=usable, alert_limit_m=alert_limit_m)

    return replace(answered, answers=list(map(told, answered.answers)))


def _until_alarm_s(answers: Sequence[Answer]) -> float:
    """Seconds from the first answer to the first with flag fault, infinite without one."""
    return min((a.time_s - answers[0].time_s for a in answers if a.flag is Flag.FAULT), default=math.inf)


def _waypoint_errors(answers: Sequence[Answer]) -> list[float]:
    return [a.error_m for a in answers if a.waypoint and a.covered and a.error_m is not None]


def _walk(answer: Answer) -> WalkKey:
    return answer.fold, answer.floor, answer.walk


def _mean(values: Sequence[float]) -> float:
    return statistics.fmean(values) if values else math.nan


def _share(part: int, whole: int) -> float:
    return part / whole if whole else math.nan
