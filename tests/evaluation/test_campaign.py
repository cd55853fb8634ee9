from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.errors import InvalidInput, SurefixError
from app.evaluation.campaign import Protocol, coverage_of, read_walks, run, walked_in
from app.evaluation.recordings import FloorFolder, RecordedWalk, floor_folders, is_test_walk
from app.evaluation.replay import Answer, replay
from app.fusion.interface import Method, SessionStart, Site
from app.observations import Batch, Fix, Position
from tests.evaluation.small_site import START_MS, WALKS
from tests.odometer import ODOMETER


@pytest.fixture(scope="module")
def folders(small_site: Path) -> list[FloorFolder]:
    return floor_folders(small_site)


@pytest.fixture(scope="module")
def walks(folders: list[FloorFolder]) -> list[RecordedWalk]:
    return read_walks(folders)


def _timeless(answers: list[Answer]) -> list[Answer]:
    return [replace(answer, spent_s=0.0) for answer in answers]


def test_walks_read_by_two_processes_are_those_read_by_one(
    folders: list[FloorFolder], walks: list[RecordedWalk]
) -> None:
    both = read_walks(folders, jobs=2)
    assert [walk.trace.trace for walk in both] == [walk.trace.trace for walk in walks]
    assert all(len(walk.fingerprints) == len(other.fingerprints) for walk, other in zip(both, walks, strict=True))


def test_answers_do_not_depend_on_the_number_of_processes(
    folders: list[FloorFolder], walks: list[RecordedWalk]
) -> None:
    methods = {"one": ODOMETER, "two": ODOMETER}
    protocol = Protocol(folds=3, tested=(0, 2), limit=2)
    alone, shared = (run(folders, walks, methods, protocol, jobs) for jobs in (1, 2))
    assert list(alone) == ["one", "two"]
    assert {name: _timeless(found) for name, found in alone.items()} == {
        name: _timeless(found) for name, found in shared.items()
    }


def test_folds_are_pooled_and_every_walk_is_walked_once(folders: list[FloorFolder], walks: list[RecordedWalk]) -> None:
    tested = tuple(fold for fold in range(3) if walked_in(walks, Protocol(folds=3), fold))
    answers = run(folders, walks, {"m": ODOMETER}, Protocol(folds=3, tested=tested))["m"]
    assert len({(a.floor, a.walk) for a in answers}) == 2 * WALKS
    assert all(is_test_walk(a.walk, 3, a.fold) for a in answers)


@given(share=st.tuples(st.floats(0.01, 1.0), st.floats(0.01, 1.0)), fold=st.integers(0, 4))
def test_a_thinner_survey_is_a_part_of_a_denser_one_and_never_holds_a_test_walk(
    share: tuple[float, float], fold: int
) -> None:
    names = [f"walk-{number}" for number in range(60)]
    thin, dense, whole = (
        {name for name in names if Protocol(survey_share=one).surveys(name, fold)} for one in (*sorted(share), 1.0)
    )
    assert thin <= dense <= whole == {name for name in names if not is_test_walk(name, 5, fold)}


def test_no_more_walks_of_a_floor_than_the_limit_are_replayed_and_none_of_the_rest_becomes_survey(
    folders: list[FloorFolder], walks: list[RecordedWalk]
) -> None:
    maps: list[int] = []

    def looking(state: object, batch: Batch, site: Site) -> tuple[object, Fix]:
        assert site.radio_map is not None
        maps.append(id(site.radio_map))
        return ODOMETER.advance(state, batch, site)

    method = Method("looking", ODOMETER.start, looking)
    answers = run(folders, walks, {"m": method}, Protocol(folds=2, limit=1))["m"]
    assert sorted({a.floor for a in answers}) == ["F1", "F2"]
    assert len({(a.floor, a.walk) for a in answers}) == 2
    assert len(set(maps)) == 1


def test_each_piece_of_work_is_reported_once(folders: list[FloorFolder], walks: list[RecordedWalk]) -> None:
    reported: list[int] = []
    methods = {"one": ODOMETER, "two": ODOMETER}
    run(folders, walks, methods, Protocol(), done=lambda: reported.append(1))
    assert len(reported) == 2 * len(walked_in(walks, Protocol(), 0))


def test_an_answer_stands_beside_the_truth_of_its_time(walks: list[RecordedWalk]) -> None:
    start = SessionStart(alert_limit_m=7.0, floor="F1")
    answers = replay(ODOMETER, start, walks[0], Site(), coverage_of([walks[1]]), 1.0)
    assert [round(1000 * a.time_s) - START_MS for a in answers] == [1000 * k for k in range(21)]
    assert [a.waypoint for a in answers] == [True, *[False] * 19, True]
    assert [a.scanned for a in answers] == [False, *[True] * 20]
    assert answers[0].xy_m is None and answers[0].error_m is None
    assert answers[10].truth_xy_m == pytest.approx((17.5, 5.0))
    # up to second 10: eleven batches; 50 samples before the walk, one at its start, 500 in it
    assert answers[10].xy_m == (11.0, 551.0)
    assert answers[10].error_m == pytest.approx(math.hypot(11.0 - 17.5, 551.0 - 5.0))
    assert all(a.alert_limit_m == 7.0 for a in answers)
    assert all(a.floor_right for a in answers[1:])
    upstairs = replay(ODOMETER, start, walks[WALKS], Site(), coverage_of([walks[1]]), 1.0)
    assert not any(a.floor_right or a.covered for a in upstairs)


def test_a_place_is_covered_within_five_metres_of_a_survey_scan_of_its_floor(walks: list[RecordedWalk]) -> None:
    near = replay(ODOMETER, SessionStart(floor="F1"), walks[0], Site(), coverage_of([walks[1]]), 1.0)
    far = replay(ODOMETER, SessionStart(floor="F1"), walks[0], Site(), coverage_of([walks[2]]), 1.0)
    assert all(a.covered for a in near)  # 3 m beside
    assert not any(a.covered for a in far)  # 6 m beside


def test_a_position_that_is_not_finite_stops_the_evaluation(walks: list[RecordedWalk]) -> None:
    def lost(state: object, batch: Batch, site: Site) -> tuple[object, Fix]:
        state, fix = ODOMETER.advance(state, batch, site)
        return state, replace(fix, position=Position(float("nan"), 0.0, "F1"))

    with pytest.raises(SurefixError, match="nan"):
        replay(Method("lost", ODOMETER.start, lost), SessionStart(floor="F1"), walks[0], Site(), coverage_of([]), 1.0)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("folds", 1),
        ("tested", (5,)),
        ("tested", ()),
        ("seconds", 0.0),
        ("risk", 0.5),
        ("alert_limit_m", 0.0),
        ("survey_share", 0.0),
    ],
)
def test_a_protocol_that_cannot_be_run_is_refused(field: str, value: object) -> None:
    with pytest.raises(InvalidInput):
        Protocol(**{field: value})  # type: ignore[arg-type]


def test_a_fold_without_survey_or_without_walks_is_refused(
    folders: list[FloorFolder], walks: list[RecordedWalk]
) -> None:
    only = [walk for walk in walks if is_test_walk(walk.trace.trace, 5, 0)]
    for some in (only, [walk for walk in walks if walk not in only]):
        with pytest.raises(InvalidInput, match="fold 0 leaves"):
            run(folders, some, {"m": ODOMETER}, Protocol())
