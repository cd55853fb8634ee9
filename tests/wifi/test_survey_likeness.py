from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import calibrated_map
from app.wifi.left_out import LeftOutScans, left_out_scans
from app.wifi.radio_map import build_radio_map
from app.wifi.radio_map_codec import decode_radio_map, encode_radio_map
from app.wifi.survey_likeness import (
    CELLS,
    FLOORS,
    LEAST_DISTANCE,
    LEAST_WITHIN,
    REACH_M,
    USUAL_BETWEEN,
    USUAL_MEAN,
    USUAL_WITHIN,
    Likeness,
    likeness_of,
    likeness_sections,
    square_of,
    stored_likeness,
)
from tests.wifi.test_fix_calibration import walks

PLACES, VISITS, SCANS = 60, 6, 3


def drawn(between: float, within: float, seed: int) -> tuple[list[Fingerprint], LeftOutScans]:
    """A survey of one floor whose left-out distances are drawn: squares in a row, walks through each, scans of each."""
    rng = np.random.default_rng(seed)
    nothing = np.empty(0, np.int64), np.empty(0)
    survey, walk, logarithm = list[Fingerprint](), list[int](), list[float]()
    for place in range(PLACES):
        usual = -2.0 + rng.normal(0.0, math.sqrt(between))
        for visit in range(VISITS):
            level = usual + rng.normal(0.0, math.sqrt(within))
            for scan in range(SCANS):
                survey.append(Fingerprint("F1", 10.0 * place + 5.0, 5.0, float(scan), f"walk{visit}", *nothing))
                walk.append(visit)
                logarithm.append(level)
    count = len(survey)
    zeros = np.zeros(count)
    return survey, LeftOutScans(
        scan=np.arange(count),
        walk=np.array(walk),
        missed_m=np.zeros((count, 2)),
        floor_right=np.ones(count, np.bool_),
        signal_distance=np.exp(logarithm),
        nearest_m=zeros,
        match=(),
        tried=np.arange(count),
    )


def test_the_variances_between_and_within_squares_are_found_again() -> None:
    found = likeness_of(*drawn(0.4, 0.1, 3), ["F1"])
    assert found.floor_mean[0] == pytest.approx(-2.0, abs=0.25)
    assert found.between[0] == pytest.approx(0.4, rel=0.4)
    assert found.within[0] == pytest.approx(0.1, rel=0.25)
    assert set(found.walks.tolist()) == {VISITS} and set(found.scans.tolist()) == {VISITS * SCANS}


def test_scans_of_one_walk_count_as_one() -> None:
    survey, left_out = drawn(0.4, 0.1, 3)
    distance = left_out.signal_distance.copy()
    distance[1::SCANS] = distance[::SCANS] * 2.0
    distance[2::SCANS] = distance[::SCANS] / 2.0
    noisier = likeness_of(survey, replace(left_out, signal_distance=distance), ["F1"])
    np.testing.assert_allclose(noisier.within, likeness_of(survey, left_out, ["F1"]).within)


def test_where_a_walk_was_alone_nothing_is_learnt_from_leaving_it_out() -> None:
    survey, left_out = drawn(0.4, 0.1, 3)
    nearest_m = left_out.nearest_m.copy()
    nearest_m[: VISITS * SCANS] = REACH_M + 0.1
    found = likeness_of(survey, replace(left_out, nearest_m=nearest_m), ["F1"])
    first = np.flatnonzero((found.square == (0, 0)).all(axis=1))
    assert (found.walks[first].tolist(), found.scans[first].tolist()) == ([0], [VISITS * SCANS])


def test_a_square_of_few_walks_is_drawn_to_its_floor_and_one_of_none_is_as_squares_are() -> None:
    found = Likeness(
        floor=np.zeros(2, np.int64),
        square=np.array([[0, 0], [1, 0]]),
        scans=np.array([9, 90]),
        walks=np.array([1, 100]),
        mean=np.array([-1.0, -1.0]),
        floor_mean=np.array([-2.0]),
        between=np.array([0.3]),
        within=np.array([0.3]),
    )
    once, often, never = found.expected(0, (0, 0)), found.expected(0, (1, 0)), found.expected(0, (7, 7))
    assert (once.mean, once.variance, once.scans) == pytest.approx((-1.5, 0.15, 9))
    assert often.mean == pytest.approx(-1.0, abs=0.02) and often.variance < 0.004
    assert (never.mean, never.variance, never.scans) == pytest.approx((-2.0, 0.3, 0))


def test_a_survey_too_small_to_tell_is_taken_to_be_as_others_are() -> None:
    lone = walks(1, 2.0)
    found = likeness_of(lone, left_out_scans(lone), ["F1"])
    assert (found.floor_mean[0], found.between[0], found.within[0]) == (USUAL_MEAN, USUAL_BETWEEN, USUAL_WITHIN)


def test_what_was_learnt_is_stored_with_the_map_and_old_maps_have_none() -> None:
    survey = walks(20, 3.0)
    stored = stored_likeness(decode_radio_map(encode_radio_map(calibrated_map(survey, version=3))).sections)
    assert stored is not None
    learnt = likeness_of(survey, left_out_scans(survey), ["F1"])
    for name, rows in likeness_sections(learnt).items():
        np.testing.assert_array_equal(likeness_sections(stored)[name], rows)
    assert stored_likeness(build_radio_map(survey).sections) is None


def test_squares_begin_at_the_origin_and_reach_to_both_sides_of_it() -> None:
    assert [square_of(x_m, 0.0) for x_m in (-0.1, 0.0, 9.9, 10.0)] == [(-1, 0), (0, 0), (0, 0), (1, 0)]
    assert LEAST_DISTANCE > 0.0


def test_a_report_of_a_survey_without_wifi_is_read_back() -> None:
    stored = stored_likeness({CELLS: np.array([]), FLOORS: np.array([])})
    assert stored is not None
    assert (len(stored.scans), len(stored.floor_mean)) == (0, 0)


def test_walks_that_were_sent_in_twice_leave_a_spread_to_expect() -> None:
    survey = walks(40, 2.0)
    again = [replace(one, walk=f"{one.walk} again") for one in survey]
    radio_map = calibrated_map([*survey, *again])
    likeness = stored_likeness(radio_map.sections)
    assert likeness is not None
    expected = likeness.expected(0, (1, 0))
    assert expected.within >= LEAST_WITHIN and math.isfinite(expected.mean) and expected.variance > 0.0
