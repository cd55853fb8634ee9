from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.evaluation.campaign import Protocol, read_walks, run, walked_in
from app.evaluation.fault_campaign import CLEAN, Answered, at_limit, fault_score, injected, run_faults
from app.evaluation.faults import FAULTS
from app.evaluation.faulty_walk import Elsewhere, FaultyWalk, elsewhere_of
from app.evaluation.recordings import FloorFolder, RecordedWalk, floor_folders
from app.evaluation.replay import Answer
from app.observations import Flag
from tests.evaluation.answers import answer
from tests.odometer import ODOMETER

PROTOCOL = Protocol(folds=3, tested=(0, 2), limit=2)
SOME = {fault: FAULTS[fault] for fault in ("half_gone", "silence_20", "replay")}


@pytest.fixture(scope="module")
def folders(small_site: Path) -> list[FloorFolder]:
    return floor_folders(small_site)


@pytest.fixture(scope="module")
def walks(folders: list[FloorFolder]) -> list[RecordedWalk]:
    return read_walks(folders)


def _walk(name: str, flags: str, errors_m: float = 3.0) -> list[Answer]:
    """An answer a second from 0 s on: `.` usable, `F` in fault, `H` usable and 30 m off, `-` not usable."""
    kinds = {
        ".": answer(errors_m, walk=name),
        "F": answer(30.0, walk=name, flag=Flag.FAULT, usable=False, protection_level_m=40.0),
        "H": answer(30.0, walk=name),
        "-": answer(errors_m, walk=name, usable=False),
    }
    return [replace(kinds[flag], time_s=float(second), waypoint=False) for second, flag in enumerate(flags)]


def _score(*walks: tuple[str, str, float, float], clean: tuple[Answer, ...] = ()) -> dict[str, object]:
    answers = [a for name, flags, _, _ in walks for a in _walk(name, flags)]
    window = {(0, "F1", name): (begin_s, end_s) for name, _, begin_s, end_s in walks}
    score = fault_score(Answered(answers, window), clean, 10.0)
    return {name: getattr(score, name) for name in score.__slots__}


def test_only_what_is_said_while_the_fault_is_there_counts() -> None:
    score = _score(("one", "HHH....HH", 3.0, 6.0))
    assert (score["walks"], score["hazardous"], score["usable"]) == (1, 0.0, 1.0)
    assert score["error_usable_m"] == score["error_end_m"] == 3.0


def test_the_time_to_alert_runs_from_the_first_answer_under_the_fault() -> None:
    score = _score(("one", "...--F..", 2.5, 9.0), ("two", "F---------F", 1.0, 20.0), ("three", "......", 0.0, 9.0))
    assert (score["walks"], score["alarmed"], score["alarmed_in_time"]) == (3, 2, 1)
    assert score["median_alert_s"] == 9.0  # 2 s and 9 s, the later of the two middle ones


def test_a_hazard_is_missed_when_no_alarm_came_before_it_within_the_detection_time() -> None:
    soon, warned, missed = "HHHHHHH---", "H--F----HH", "--------HF"
    scores = [_score((name, flags, 0.0, 20.0)) for name, flags in (("s", soon), ("w", warned), ("m", missed))]
    assert [score["missed"] for score in scores] == [0, 0, 1]
    assert [score["hazardous"] for score in scores] == pytest.approx([0.7, 0.3, 0.1])
    assert [score["hazardous_late"] for score in scores] == pytest.approx([0.0, 2 / 3, 1 / 3])
    assert [score["hazardous_unalerted"] for score in scores] == pytest.approx([0.0, 0.0, 1 / 3])


def test_a_smaller_alert_limit_leaves_fewer_answers_usable_and_the_rest_as_it_was() -> None:
    answers = [answer(), answer(protection_level_m=15.0), answer(usable=False), answer(None)]
    answered = at_limit(Answered([replace(a, alert_limit_m=20.0) for a in answers], {}), 10.0)
    assert [a.usable for a in answered.answers] == [True, False, False, False]
    assert [replace(a, usable=b.usable) for a, b in zip(answered.answers, answers, strict=True)] == answers


def test_waypoints_are_compared_with_the_same_walks_without_the_fault() -> None:
    faulty = [answer(5.0), answer(50.0, covered=False)]
    clean = [answer(2.0), answer(9.0, walk="one that offers nothing to fault")]
    score = fault_score(Answered(faulty, {(0, "F1", "one"): (-math.inf, math.inf)}), clean, 10.0)
    assert (score.waypoints_m, score.waypoints_clean_m) == (5.0, 2.0)


def test_a_fault_that_befell_no_walk_has_no_figures() -> None:
    score = fault_score(Answered([], {}), [answer()], 10.0)
    assert score.walks == score.alarmed == score.missed == 0
    assert all(math.isnan(value) for value in (score.usable, score.hazardous, score.median_alert_s, score.error_end_m))


def test_what_befalls_a_walk_depends_on_the_seed_and_the_walk_alone(walks: list[RecordedWalk]) -> None:
    elsewhere = {floor: elsewhere_of([w for w in walks if w.floor == floor]) for floor in ("F1", "F2")}

    def heard(faulty: list[FaultyWalk]) -> list[list[int]]:
        return [[int(b) for scan in one.walk.trace.scans for b in scan.bssid] for one in faulty]

    thinned = FAULTS["half_gone"]
    all_of_them, last = (heard(injected(some, elsewhere, "f", thinned, 1)) for some in (walks, walks[-1:]))
    assert all_of_them[-1:] == last
    assert heard(injected(walks, elsewhere, "f", thinned, 2)) != all_of_them


def test_the_clean_row_is_what_the_evaluation_says(folders: list[FloorFolder], walks: list[RecordedWalk]) -> None:
    found = run_faults(folders, walks, {"m": ODOMETER}, SOME, PROTOCOL, seed=1)["m"]
    clean = run(folders, walks, {"m": ODOMETER}, PROTOCOL)["m"]
    assert list(found) == [CLEAN, *SOME]
    assert [replace(a, spent_s=0.0) for a in found[CLEAN].answers] == [replace(a, spent_s=0.0) for a in clean]


def test_every_walk_with_something_to_fault_is_walked_once_a_fault(
    folders: list[FloorFolder], walks: list[RecordedWalk]
) -> None:
    reported: list[int] = []
    found = run_faults(folders, walks, {"m": ODOMETER}, SOME, PROTOCOL, 1, jobs=2, done=lambda: reported.append(1))["m"]
    walked = sum(len(walked_in(walks, PROTOCOL, fold)) for fold in PROTOCOL.tested)
    counts = {fault: len(one.window) for fault, one in found.items()}
    assert counts == {CLEAN: walked, "half_gone": walked, "silence_20": walked, "replay": 0}  # no place is 40 m away
    assert len(reported) == sum(counts.values())
    for one in found.values():
        assert {(a.fold, a.floor, a.walk) for a in one.answers} == set(one.window)


def test_faults_draw_on_the_survey_of_the_walks_own_floor_and_fold_only(
    folders: list[FloorFolder], walks: list[RecordedWalk]
) -> None:
    offered: list[tuple[str, Elsewhere]] = []

    def looking(walk: RecordedWalk, elsewhere: Elsewhere, dice: np.random.Generator) -> None:
        offered.append((walk.floor, elsewhere))

    run_faults(folders, walks, {"m": ODOMETER}, {"looking": looking}, Protocol(folds=3), seed=1)
    tested = {w.trace.trace for w in walked_in(walks, Protocol(folds=3), 0)}
    for floor, elsewhere in offered:
        own = [id(s) for w in walks if w.floor == floor and w.trace.trace not in tested for s in w.trace.scans]
        assert [id(scan) for scan in elsewhere.scans] == own
    assert {floor for floor, _ in offered} == {"F1", "F2"}
