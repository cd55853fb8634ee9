"""Smoothed rows stand beside the causal ones: the same moments of the same walks, told later."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from app.evaluation.campaign import Protocol, read_walks, run
from app.evaluation.late_replay import LATE_S, late_rows, smoothed_answers
from app.evaluation.recordings import floor_folders
from app.evaluation.replay import Answer
from app.evaluation.scoring import score
from app.fusion.methods import METHODS
from app.observations import Flag
from tests.evaluation.small_site import write_small_site
from tests.fusion.walks import run as walk_through
from tests.fusion.walks import walked

PROTOCOL = Protocol(folds=2, limit=2)
SUREFIX = {"surefix": METHODS["surefix"]}
Rows = dict[str, list[Answer]]


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> Rows:
    folders = floor_folders(write_small_site(tmp_path_factory.mktemp("late") / "site"))
    walks, done = read_walks(folders), list[None]()
    found = late_rows(folders, walks, SUREFIX, PROTOCOL, 1, lambda: done.append(None))
    assert len(done) == 4
    return {**run(folders, walks, SUREFIX, PROTOCOL), **found}


def test_every_method_has_a_row_after_the_walk_and_one_some_seconds_late(rows: Rows) -> None:
    assert list(rows) == ["surefix", "surefix smoothed", f"surefix {LATE_S:g} s late"]
    moments = [[(a.walk, a.time_s, a.error_m is None, a.flag) for a in answers] for answers in rows.values()]
    assert moments == [moments[0]] * 3


def test_smoothing_moves_what_has_a_position_and_keeps_levels_that_hold(rows: Rows) -> None:
    before, after = rows["surefix"], rows["surefix smoothed"]
    assert score(after).every_answer.n == score(before).every_answer.n > 50
    assert any(one.xy_m != other.xy_m for one, other in zip(before, after, strict=True))
    assert score(after).inside_protection_level >= 0.95
    assert all(a.usable is False for a in after if a.protection_level_m is None or a.protection_level_m > 10.0)


def test_an_answer_told_late_knows_nothing_of_what_came_later_still() -> None:
    walk = walked(5)
    fixes = walk_through(METHODS["surefix"], walk.batches)
    asked = [_unanswered(float(fix.time_s or 0.0)) for fix in fixes]
    whole = smoothed_answers(asked, fixes, "F1", 0.01, LATE_S)
    cut = 20
    known = sum(answer.time_s <= asked[cut].time_s + LATE_S for answer in asked)
    shorter = smoothed_answers(asked[:known], fixes[:known], "F1", 0.01, LATE_S)
    assert whole[: cut + 1] == shorter[: cut + 1]
    assert whole[cut] != smoothed_answers(asked, fixes, "F1", 0.01)[cut]


def test_what_has_no_evidence_stays_as_it_was() -> None:
    walk = walked(5)
    fixes = [replace(fix, evidence=()) for fix in walk_through(METHODS["surefix"], walk.batches[:8])]
    asked = [_unanswered(float(fix.time_s or 0.0)) for fix in fixes]
    assert smoothed_answers(asked, fixes, "F1", 0.01) == asked


def _unanswered(time_s: float) -> Answer:
    """An answer to be filled in, at a place of no importance."""
    return Answer(
        fold=0,
        floor="F1",
        walk="walk",
        time_s=time_s,
        truth_xy_m=(0.0, 0.0),
        waypoint=False,
        covered=True,
        scanned=True,
        xy_m=None,
        error_m=None,
        floor_right=True,
        accuracy_m=None,
        covariance_m2=None,
        flag=Flag.NOMINAL,
        usable=False,
        protection_level_m=None,
        alert_limit_m=math.inf,
        spent_s=0.0,
    )
