from __future__ import annotations

import dataclasses
import random

import numpy as np
import pytest

from app.wifi.fingerprint import Fingerprint
from app.wifi.match_index import index_of
from app.wifi.radio_map import build_radio_map
from app.wifi.signal_distance import Distance, distances
from app.wifi.similarity import point_distances
from app.wifi.walk_errors import leave_one_walk_out
from app.wifi.wknn import wknn
from tests.wifi.surveys import corridor


def walked(walks: int = 4) -> list[Fingerprint]:
    """The corridor, walked so many times, in a random order."""
    survey = [dataclasses.replace(one, walk=f"walk {one.time_s:.0f}") for one in corridor(repeats=walks)]
    random.Random(5).shuffle(survey)
    return survey


def test_each_scan_is_placed_as_by_a_map_that_its_walk_never_was_in() -> None:
    survey = walked()
    errors = leave_one_walk_out(survey)
    assert sorted(errors.scan.tolist()) == list(range(len(survey)))
    for at, error_m, right in zip(errors.scan.tolist(), errors.error_m, errors.floor_right, strict=True):
        one = survey[at]
        without = build_radio_map([other for other in survey if other.walk != one.walk], cell_m=0.0)
        match = wknn(without, one.bssid, one.rssi_dbm)
        assert match is not None
        assert right == (without.floors[match.floor] == one.floor)
        if right:
            assert error_m == pytest.approx(np.hypot(*(match.xy_m - (one.x_m, one.y_m))))
        else:
            assert np.isnan(error_m)


def test_the_order_of_the_survey_does_not_matter() -> None:
    survey = walked()
    forward, backward = leave_one_walk_out(survey), leave_one_walk_out(survey[::-1])
    assert np.nanmean(forward.error_m) == pytest.approx(np.nanmean(backward.error_m))


def test_a_walk_that_has_no_other_is_placed_nowhere() -> None:
    errors = leave_one_walk_out(corridor())
    assert not errors.placed.any() and np.isnan(errors.error_m).all() and len(errors.scan) > 0


def test_no_survey_has_no_errors() -> None:
    assert len(leave_one_walk_out([]).scan) == 0


def test_a_large_survey_is_judged_by_some_scans_taken_evenly() -> None:
    survey = walked()
    whole, some = leave_one_walk_out(survey), leave_one_walk_out(survey, most_comparisons=len(survey) ** 2 // 3)
    assert len(some.scan) == -(-len(survey) // 3)
    at = dict(zip(whole.scan.tolist(), whole.error_m.tolist(), strict=True))
    np.testing.assert_allclose(some.error_m, [at[scan] for scan in some.scan.tolist()])
    assert {survey[scan].floor for scan in some.scan.tolist()} == {"B1", "F1"}


def test_distances_of_points_are_those_of_scans_that_sound_like_them() -> None:
    radio_map = build_radio_map(walked(1))
    points = np.arange(0, len(radio_map.scans), 2)
    found = point_distances(radio_map, points)
    np.testing.assert_allclose(found, found.T)
    np.testing.assert_allclose(np.diag(found), 0.0, atol=1e-6)
    for row, point in zip(found, points.tolist(), strict=True):
        pairs = np.flatnonzero(radio_map.point == point)
        heard = radio_map.bssid[radio_map.access_point[pairs]]
        scan_dbm = radio_map.mean_dbm[pairs].astype(np.float64)
        expected = distances(index_of(radio_map), heard, scan_dbm, Distance.COSINE, points)
        np.testing.assert_allclose(row, np.clip(expected, 0.0, 1.0), atol=1e-5)
