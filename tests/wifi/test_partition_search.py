"""A partition moves with its walker, and notices when it has lost him."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.observations import WifiScan
from app.wifi.partition_search import PartitionSettings, SearchState, place_scan
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.strongest_wknn import strongest_wknn
from tests.wifi.surveys import corridor, heard_at

MAP = build_radio_map(corridor())
NEAR = PartitionSettings(radius_m=9.0, per_scatter=0.0, unlike=2.0)


def scan_at(x_m: float, time_s: float, floor: int = 0) -> WifiScan:
    heard = heard_at(x_m, floor, np.random.default_rng(int(time_s)), noise_db=0.5)
    return WifiScan(time_s, heard.bssid, heard.rssi_dbm, np.full(len(heard.bssid), time_s))


def walk(
    places_m: list[tuple[float, float]], settings: PartitionSettings = NEAR, radio_map: RadioMap = MAP
) -> tuple[SearchState, list[tuple[float, bool]]]:
    """Scans at (time, place); gives the last state, and of each scan its place and whether all was searched."""
    state, answers = SearchState(), []
    for time_s, x_m in places_m:
        state, match, everywhere = place_scan(state, radio_map, scan_at(x_m, time_s), 0, settings)
        assert match is not None
        answers.append((float(match.xy_m[0]), everywhere))
    return state, answers


def test_only_the_first_scan_of_a_steady_walk_searches_the_whole_map() -> None:
    state, answers = walk([(2.0 * k, 3.0 + 2.0 * k) for k in range(15)], replace(NEAR, unlike=3.0))
    assert [everywhere for _, everywhere in answers] == [True] + [False] * 14
    assert all(abs(x_m - 3.0 - 2.0 * k) < 3.0 for k, (x_m, _) in enumerate(answers))
    assert state.partition is not None
    apart_m = np.abs(MAP.xy_m[state.partition.points, 0] - answers[-1][0])
    assert apart_m.max() <= NEAR.radius_m


def test_within_the_partition_the_answer_is_that_of_its_points() -> None:
    state, _ = walk([(0.0, 10.0)])
    assert state.partition is not None
    scan = scan_at(11.0, 2.0)
    _, match, everywhere = place_scan(state, MAP, scan, 0, replace(NEAR, unlike=10.0))
    alone = strongest_wknn(MAP, scan.bssid, scan.rssi_dbm, NEAR.strongest, 0, state.partition.points)
    assert not everywhere and match is not None and alone is not None
    assert np.array_equal(match.points, alone.points)


def test_a_walker_who_is_carried_off_is_found_by_the_next_scan() -> None:
    _, answers = walk([(0.0, 3.0), (2.0, 5.0), (4.0, 36.0), (6.0, 37.0)])
    assert [everywhere for _, everywhere in answers] == [True, False, True, False]
    assert abs(answers[2][0] - 36.0) < 3.0


def test_after_a_long_silence_everything_is_searched() -> None:
    _, answers = walk([(0.0, 10.0), (10.0, 12.0)])
    assert answers[1][1]


def test_a_new_radio_map_begins_a_new_partition() -> None:
    state, _ = walk([(0.0, 10.0)])
    _, _, everywhere = place_scan(state, replace(MAP, version=7), scan_at(11.0, 2.0), 0, NEAR)
    assert everywhere


def test_a_partition_of_another_floor_is_lost() -> None:
    state, _ = walk([(0.0, 10.0)])
    _, match, everywhere = place_scan(state, MAP, scan_at(11.0, 2.0, floor=1), 1, NEAR)
    assert everywhere and match is not None and match.floor == 1


def test_a_partition_is_as_wide_as_the_neighbours_it_begins_with_are_scattered() -> None:
    scan = scan_at(10.0, 0.0)
    state, match, _ = place_scan(SearchState(), MAP, scan, 0, replace(NEAR, per_scatter=2.0))
    assert match is not None and state.partition is not None
    assert state.partition.radius_m == 9.0 + 2.0 * np.sqrt(match.covariance_m2.trace())


def test_a_partition_with_hardly_any_points_is_lost() -> None:
    _, answers = walk([(0.0, 10.0), (2.0, 11.0)], replace(NEAR, radius_m=2.5))
    assert [everywhere for _, everywhere in answers] == [True, True]


def test_unless_it_moves_every_scan_searches_the_whole_map() -> None:
    state, answers = walk([(2.0 * k, 3.0 + 2.0 * k) for k in range(5)], replace(NEAR, moving=False))
    assert all(everywhere for _, everywhere in answers)
    assert state.partition is None


def test_a_scan_of_unknown_access_points_leaves_the_state_alone() -> None:
    state, _ = walk([(0.0, 10.0)])
    strange = WifiScan(2.0, np.array([9999]), np.array([-40.0]), np.array([2.0]))
    after, match, _ = place_scan(state, MAP, strange, 0, NEAR)
    assert match is None and after is state
