from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.evaluation.new_buildings import FEWEST_WALKS, VISIT_M, new_building, visits
from app.evaluation.recordings import RecordedWalk
from app.simulation.ageing import aged
from app.simulation.varied_world import Traits
from tests.evaluation.small_buildings import SMALL, small_building


@pytest.fixture(scope="module")
def walked() -> list[RecordedWalk]:
    return list(visits(small_building(), 4))


def test_a_floor_is_surveyed_by_as_much_way_as_its_size_asks_for() -> None:
    def metres(traits: Traits) -> float:
        walks = new_building(traits).survey
        assert len(walks) >= FEWEST_WALKS
        return sum(float(np.hypot(*np.diff(w.trace.waypoint_xy_m, axis=0).T).sum()) for w in walks)

    plain = small_building().traits
    area_m2 = 66.0 * plain.stretch_x * 39.0 * plain.stretch_y
    assert 0.3 * area_m2 < metres(replace(plain, survey_m_per_m2=0.35)) < 0.35 * area_m2 + 95.0


def test_every_floor_has_fingerprints_in_the_map_and_a_calibration() -> None:
    building = small_building()
    assert building.site.radio_map is not None
    assert set(building.site.radio_map.floors) == set(building.site.floors) == {"F1"}
    assert "fix_calibration" in building.site.radio_map.sections
    assert building.coverage.covers("F1", building.survey[0].scan_xy_m[:1]) == [True]


def test_the_truth_of_a_visit_is_known_at_every_second_and_its_length_is_as_asked(walked: list[RecordedWalk]) -> None:
    for walk in walked:
        assert np.diff(walk.trace.waypoint_time_s) == pytest.approx(1.0)
        way_m = float(np.hypot(*np.diff(walk.trace.waypoint_xy_m, axis=0).T).sum())
        assert 0.8 * VISIT_M[0] < way_m < VISIT_M[1]
        assert walk.fingerprints == ()
        assert len(walk.trace.scans) > 10


def test_the_same_seed_gives_the_same_visits_however_many_there_are(walked: list[RecordedWalk]) -> None:
    first = next(visits(new_building(Traits.draw(SMALL)), 1))
    assert first.trace.trace == walked[0].trace.trace
    assert np.array_equal(first.trace.waypoint_xy_m, walked[0].trace.waypoint_xy_m)
    assert np.array_equal(first.trace.accelerometer.values, walked[0].trace.accelerometer.values)
    assert [scan.rssi_dbm.tolist() for scan in first.trace.scans] == [
        scan.rssi_dbm.tolist() for scan in walked[0].trace.scans
    ]


def test_visits_are_no_survey_walks_and_differ_from_one_another(walked: list[RecordedWalk]) -> None:
    names = {walk.trace.trace for walk in walked} | {walk.trace.trace for walk in small_building().survey}
    assert len(names) == len(walked) + len(small_building().survey)
    starts = {tuple(walk.trace.waypoint_xy_m[0].tolist()) for walk in walked}
    assert len(starts) == len(walked)


def test_months_later_the_same_way_is_walked_and_something_else_is_heard(walked: list[RecordedWalk]) -> None:
    building = small_building()
    later = aged(building.world.access_points, 25.0, SMALL).access_points
    then, now = walked[0], next(visits(building, 1, later))
    assert np.array_equal(then.trace.waypoint_xy_m, now.trace.waypoint_xy_m)
    assert np.array_equal(then.trace.gyroscope.values, now.trace.gyroscope.values)
    names = {int(bssid) for scan in now.trace.scans for bssid in scan.bssid}
    known = set(building.world.access_points.bssid.tolist())
    assert names & known and names - known
