from __future__ import annotations

import math

import numpy as np
import pytest

from app.services.map_drift import LEAST_SESSIONS, described_drift, map_drift, session_bit
from app.storage.map_use_rows import UsedSquare, UseRow
from app.wifi.survey_likeness import CELL_M, Likeness

MEAN, BETWEEN, WITHIN = -2.4, 0.25, 0.1
SQUARES = 12
LIKENESS = Likeness(
    floor=np.zeros(SQUARES, np.int64),
    square=np.column_stack([np.arange(SQUARES), np.zeros(SQUARES, np.int64)]),
    scans=np.full(SQUARES, 30),
    walks=np.full(SQUARES, 6),
    mean=np.full(SQUARES, MEAN),
    floor_mean=np.array([MEAN]),
    between=np.array([BETWEEN]),
    within=np.array([WITHIN]),
)


def used(sessions: int, shift: float, visits: int | None = None, seed: int = 0) -> UseRow:
    """So many sessions, each of which visits once unless said otherwise."""
    count = visits or sessions
    mean = MEAN + shift + np.random.default_rng(seed).normal(0.0, math.sqrt(WITHIN), count)
    mean += MEAN + shift - mean.mean()
    bits, number = 0, 0
    while bits.bit_count() < sessions:
        bits |= session_bit(str(number))
        number += 1
    return UseRow(4 * count, 1, count, float(mean.sum()), float((mean**2).sum()), bits, 77)


def judged(*rows: UseRow, changed: UseRow | None = None, east: int = 3) -> dict[UsedSquare, UseRow]:
    """Some use of every square, and another of one."""
    use = {UsedSquare("F1", at, 0, 1): rows[0] for at in range(SQUARES)}
    return use if changed is None else {**use, UsedSquare("F1", east, 0, 1): changed}


def test_only_the_square_that_changed_is_to_be_surveyed_again() -> None:
    drift = map_drift(judged(used(12, 0.0), changed=used(12, 1.4)), LIKENESS, ["F1"])
    (again,) = drift.resurvey
    assert (again.floor, again.x_m, again.y_m) == ("F1", 3.5 * CELL_M, 0.5 * CELL_M)
    assert again.ratio == pytest.approx(math.exp(1.4), rel=0.01) and again.score > 5.0
    assert again.reason == "changed since it was surveyed"
    assert len(drift.judged) == SQUARES
    assert drift.ratio == pytest.approx(math.exp(1.4 / SQUARES), rel=0.02)


def test_a_square_of_few_sessions_is_not_judged_however_often_they_come_back() -> None:
    lone = used(LEAST_SESSIONS - 2, 3.0, visits=200)
    drift = map_drift(judged(used(12, 0.0), changed=lone), LIKENESS, ["F1"])
    assert len(drift.judged) == SQUARES - 1 and drift.resurvey == ()


def test_sessions_that_come_back_tell_no_more_than_their_number_does() -> None:
    once, again = used(6, 0.6), used(6, 0.6, visits=60)
    scores = [map_drift(judged(row), LIKENESS, ["F1"]).judged[0].score for row in (once, again)]
    assert scores[1] == pytest.approx(scores[0], rel=0.1)


def test_what_the_whole_survey_is_better_in_than_a_part_of_it_hides_no_change() -> None:
    def names(usual: float, changed: float) -> int:
        return len(map_drift(judged(used(12, usual), changed=used(12, changed)), LIKENESS, ["F1"]).resurvey)

    assert (names(0.0, 0.5), names(-0.5, 0.5)) == (0, 1)


def test_a_place_that_nobody_surveyed_is_named_when_it_is_worse_than_those_that_somebody_did() -> None:
    def reasons(shift: float) -> list[str]:
        use = {**judged(used(12, 0.0)), UsedSquare("F1", 40, 7, 1): used(12, shift)}
        return [one.reason for one in map_drift(use, LIKENESS, ["F1"]).resurvey]

    assert reasons(0.0) == []
    assert reasons(0.8) == ["never surveyed, and unlike what was"]


def test_periods_are_added_up_and_floors_that_the_map_does_not_have_left_out() -> None:
    row = used(LEAST_SESSIONS + 1, 0.0)
    use = {UsedSquare("F1", 0, 0, 1): row, UsedSquare("F1", 0, 0, 2): row, UsedSquare("roof", 0, 0, 1): row}
    (one,) = map_drift(use, LIKENESS, ["F1"]).judged
    assert (one.use.visits, one.use.scans) == (2 * row.visits, 2 * row.scans)


def test_what_is_told_holds_the_evidence_and_of_no_use_nothing() -> None:
    told = described_drift(map_drift(judged(used(12, 0.0), changed=used(12, 1.4)), LIKENESS, ["F1"]), 5)
    (again,) = told["resurvey"]
    assert (again["visits"], again["scans"], again["unfit"], again["surveyed"], again["last"]) == (12, 48, 1, 30, 77)
    assert again["sessions"] == pytest.approx(12, abs=2)
    nothing = described_drift(map_drift({}, LIKENESS, ["F1"]), 5)
    assert nothing == {"since": 5, "score": None, "squares": 0, "resurvey": []}
