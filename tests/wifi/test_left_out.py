from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.wifi.fingerprint import Fingerprint
from app.wifi.left_out import FEW_WALKS, GROUPS, left_out_scans
from app.wifi.radio_map import build_radio_map
from app.wifi.soft_match import soft_match
from tests.wifi.surveys import corridor
from tests.wifi.test_fix_calibration import walks


def few(count: int = 4, floors: tuple[str, ...] = ("B1", "F1")) -> list[Fingerprint]:
    """The corridor of each floor, walked so many times; walks of two floors share their names."""
    return [replace(one, walk=f"walk {one.time_s:.0f}") for one in corridor(repeats=count, floors=floors)]


def test_each_scan_is_placed_as_by_a_map_that_its_walk_never_was_in() -> None:
    survey = few()
    found = left_out_scans(survey)
    assert sorted(found.tried.tolist()) == list(range(len(survey)))
    for at, error_m, nearest_m, right in zip(
        found.scan.tolist(), found.error_m, found.nearest_m, found.floor_right, strict=True
    ):
        one = survey[at]
        others = [other for other in survey if (other.floor, other.walk) != (one.floor, one.walk)]
        without = build_radio_map(others)
        match = soft_match(without, one.bssid, one.rssi_dbm, floor=without.floors.index(one.floor))
        assert match is not None
        assert error_m == pytest.approx(np.hypot(*(match.xy_m - (one.x_m, one.y_m))))
        assert right == (without.floors[int(match.floor_probability.argmax())] == one.floor)
        here = without.floor == without.floors.index(one.floor)
        assert nearest_m == pytest.approx(np.hypot(*(without.xy_m[here] - (one.x_m, one.y_m)).T).min())


def test_the_same_name_on_two_floors_is_two_walks() -> None:
    assert len(set(left_out_scans(few(3)).walk.tolist())) == 6


def test_many_walks_are_left_out_in_groups_and_none_is_in_its_own_map() -> None:
    survey = walks(FEW_WALKS + GROUPS, 0.0)
    found = left_out_scans(survey)
    assert len(found.scan) == len(survey)
    assert found.nearest_m.min() > 0.0


def test_a_walk_that_has_no_other_is_placed_nowhere_and_no_survey_has_no_scans() -> None:
    alone = left_out_scans(few(1, ("F1",)))
    assert len(alone.scan) == 0 < len(alone.tried)
    assert len(left_out_scans([]).scan) == 0


def test_of_a_large_survey_every_so_manyth_scan_is_placed() -> None:
    survey = few()
    assert len(left_out_scans(survey, largest_sample=len(survey) // 3).scan) == pytest.approx(len(survey) / 3, abs=8)
