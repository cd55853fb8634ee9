"""A site that is described is built as described."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from app.evaluation.paper_layouts import evenly, grid, loop
from app.observations import Carrying
from app.simulation.layouts import Rect
from app.simulation.planned_site import Manner, planned_world, surveyed, walked_along
from app.simulation.recording import World
from app.wifi.radio_map import build_radio_map

AROUND = [(0.9, 0.9), (29.1, 0.9), (29.1, 19.1)]
START_S = 1_700_000_000.0


@lru_cache
def world(seed: int = 1) -> World:
    return planned_world("loop", loop(30.0, 20.0, 1.8), evenly(Rect(0.0, 0.0, 30.0, 20.0), 4, 3, (0, 1)), seed)


def test_access_points_hang_where_they_were_put() -> None:
    points = world().access_points
    assert len(points.bssid) == len(set(points.bssid.tolist())) == 24
    assert points.place_m[:12, 2].max() < world().building.floors[0].storey_height_m < points.place_m[12:, 2].min()
    assert points.place_m[0, :2] == pytest.approx([3.75, 20.0 / 6.0])


def test_the_same_seed_is_the_same_building_and_another_seed_another() -> None:
    one, same, other = (
        planned_world("loop", loop(30.0, 20.0, 1.8), evenly(Rect(0.0, 0.0, 30.0, 20.0), 4, 3), seed).access_points
        for seed in (3, 3, 4)
    )
    assert np.array_equal(one.level_at_1m_dbm, same.level_at_1m_dbm)
    assert not np.array_equal(one.level_at_1m_dbm, other.level_at_1m_dbm)


def test_a_reference_point_holds_the_mean_of_all_its_samples() -> None:
    points_m = grid([Rect(0.0, 0.0, 30.0, 1.8)], 1.8)
    found = surveyed(world(), points_m, 40, np.random.default_rng(0))
    assert len(found) == 40 * len(points_m)
    radio_map = build_radio_map(found)
    assert len(radio_map.scans) == len(points_m)
    assert set(radio_map.scans.tolist()) == {40}
    heard = radio_map.count == 40
    assert heard.any()
    assert 1.0 < np.sqrt(radio_map.variance_db2[heard]).mean() < 6.0


@pytest.mark.parametrize("carrying", [Carrying.HANDHELD, Carrying.POCKET])
def test_a_walk_keeps_to_its_way_its_rate_and_its_scans(carrying: Carrying) -> None:
    manner = Manner(rate_hz=20.0, scan_every_s=0.5, carrying=carrying)
    recording = walked_along(world(), np.array(AROUND), manner, START_S, np.random.default_rng(2))
    walk = recording.walk
    length_m = np.linalg.norm(np.diff(walk.xy_m, axis=0), axis=1).sum()
    around_m = np.linalg.norm(np.diff(np.array(AROUND), axis=0), axis=1).sum()
    assert length_m == pytest.approx(around_m, abs=1.5)
    assert np.diff(walk.time_s) == pytest.approx(0.05, abs=1e-3)
    assert np.diff([scan.time_ms for scan in recording.scans]) == pytest.approx(500.0, abs=1.0)
    still = (walk.speed_mps < 0.1) & (walk.time_s > walk.time_s[0] + 2.0) & (walk.time_s < walk.time_s[-1] - 2.0)
    assert not still.any()


def test_a_fast_scan_is_not_late_by_the_time_of_a_slow_one() -> None:
    def lag_s(every_s: float | None) -> float:
        manner = Manner(scan_every_s=every_s)
        recording = walked_along(world(), np.array(AROUND), manner, START_S, np.random.default_rng(2))
        return float(np.mean([scan.time_ms - scan.seen_ms.max() for scan in recording.scans])) / 1000.0

    assert lag_s(0.5) < 0.5 < lag_s(None)


def test_a_layout_that_does_not_begin_at_the_origin_is_refused() -> None:
    moved = loop(30.0, 20.0, 1.8)
    shifted = type(moved)(Rect(5.0, 0.0, 30.0, 20.0).corners, moved.corridors, moved.rooms, (3.0,), 10.0)
    with pytest.raises(ValueError, match="origin"):
        planned_world("loop", shifted, [(1.0, 1.0, 0)], 1)
