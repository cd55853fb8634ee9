"""Every fault in every test walk, and what the method said meanwhile."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from app.evaluation.campaign import Advance, Protocol, coverage_of, parted, replayed, surveyed
from app.evaluation.exclusions import InPlay, exclusions, in_play
from app.evaluation.faulty_walk import Elsewhere, FaultyWalk, Injector, elsewhere_of
from app.evaluation.recordings import FloorFolder, RecordedWalk
from app.evaluation.replay import Answer, WalkKey
from app.evaluation.scoring import covered_errors_m, errors_m, errors_of, quantile, ratio
from app.fusion.interface import Method, Site
from app.observations import Flag

CLEAN = "none"
"""The row of the walks as recorded."""
DETECTION_S = 6.0
"""Within which a fault is to be told: three scans of a phone in the hand, the detection time of the first paper."""


@dataclass(frozen=True, slots=True)
class Answered:
    """Answers to the walks with one fault; of each walk window : when it was there, in_play : what is to be found."""

    answers: list[Answer]
    window: dict[WalkKey, tuple[float, float]]
    in_play: dict[WalkKey, InPlay] = field(default_factory=dict)


ByFault = dict[str, dict[str, Answered]]
"""Method -> fault -> answers, CLEAN first."""


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
) -> ByFault:
    """Replay the test walks of every fold, as recorded and with each fault, through every method.

    The map and its calibration are of the survey walks, without any fault.

    Raises
    ------
    InvalidInput : a fold without survey or without test walks.
    """
    of_folds = []
    for fold in protocol.tested:
        survey, walked = parted(walks, protocol, fold)
        site = surveyed(floors, survey)
        of_folds.append(faulted(site, survey, walked, methods, faults, protocol, fold, seed, jobs, done))
    return pooled(of_folds)


def faulted(
    site: Site,
    survey: Sequence[RecordedWalk],
    walked: Sequence[RecordedWalk],
    methods: Mapping[str, Method],
    faults: Mapping[str, Injector],
    protocol: Protocol,
    fold: int,
    seed: int,
    jobs: int = 1,
    done: Advance = lambda: None,
) -> ByFault:
    """Replay walks as they are and with each fault on the map of one survey. fold : what to call it in the answers."""
    coverage = coverage_of(survey)
    elsewhere = {floor: elsewhere_of([w for w in survey if w.floor == floor]) for floor in {w.floor for w in walked}}
    as_it_was = {(walk.floor, walk.trace.trace): walk for walk in walked}
    rows = {CLEAN: [FaultyWalk(walk, -math.inf, math.inf) for walk in walked]}
    rows |= {fault: injected(walked, elsewhere, fault, injector, seed) for fault, injector in faults.items()}
    found: ByFault = {name: {} for name in methods}
    for fault, faulty in rows.items():
        keyed = {(one.walk.floor, one.walk.trace.trace): one for one in faulty}
        window = {(fold, *key): (one.begin_s, one.end_s) for key, one in keyed.items()}
        playing = {(fold, *key): in_play(one, as_it_was[key]) for key, one in keyed.items()}
        answers = replayed(site, coverage, [one.walk for one in faulty], methods, protocol, fold, jobs, done)
        for name, of_method in answers.items():
            found[name][fault] = Answered(of_method, window, playing)
    return found


def pooled(parts: Iterable[ByFault]) -> ByFault:
    """The answers of several folds, or buildings, of one campaign."""
    found: ByFault = {}
    for part in parts:
        for name, rows in part.items():
            for fault, one in rows.items():
                whole = found.setdefault(name, {}).setdefault(fault, Answered([], {}))
                whole.answers.extend(one.answers)
                whole.window.update(one.window)
                whole.in_play.update(one.in_play)
    return found


def fault_score(faulty: Answered, clean: Sequence[Answer], alert_limit_m: float) -> FaultScore:
    """Judge the answers of one method to one fault; clean : its answers to the walks as recorded."""
    under: dict[WalkKey, list[Answer]] = {}
    for answer in faulty.answers:
        begin_s, end_s = faulty.window[answer.walk_key]
        if begin_s <= answer.time_s <= end_s:
            under.setdefault(answer.walk_key, []).append(answer)
    waits = [_until_alarm_s(found) for found in under.values()]
    hazards = [
        [a.time_s - found[0].time_s for a in found if a.usable and a.beyond(alert_limit_m)] for found in under.values()
    ]
    late = [sum(DETECTION_S < at_s < wait_s for at_s in times) for times, wait_s in zip(hazards, waits, strict=True)]
    ends = [errors_m(found)[-1:] for found in under.values()]
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
        usable=ratio(sum(a.usable for a in answers), len(answers)),
        hazardous=ratio(sum(map(len, hazards)), len(answers)),
        hazardous_late=ratio(sum(at_s > DETECTION_S for times in hazards for at_s in times), after),
        hazardous_unalerted=ratio(sum(late), after),
        inside_level=ratio(sum(not a.beyond(a.protection_level_m) for a in placed), len(placed)),
        error_usable_m=errors_of(errors_m(a for a in answers if a.usable)).mean_m,
        error_end_m=errors_of([error_m for last in ends for error_m in last]).mean_m,
        waypoints_m=errors_of(covered_errors_m(faulty.answers)).mean_m,
        waypoints_clean_m=errors_of(covered_errors_m(a for a in clean if a.walk_key in faulty.window)).mean_m,
        faulty_found=ratio(out.found, out.faulty),
        sound_excluded=ratio(out.wrong, out.sound),
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
