from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.integrity.map_quality import (
    LEAST_REPEATS,
    between_walk_spread,
    conformal_level,
    coverage_gaps,
    distinct_pairs,
    error_cells,
    look_alikes,
    smallest_risk,
)


def test_errors_are_gathered_by_place() -> None:
    xy_m = np.array([[1.0, 1.0], [3.9, 3.9], [4.1, 1.0], [-1.0, 1.0]])
    error_m, level_m = np.array([2.0, 4.0, 7.0, 1.0]), np.array([10.0, 12.0, 9.0, 8.0])
    cells = error_cells(xy_m, error_m, level_m, np.array([0, 1, 1, 1]), 4.0)
    columns = cells.mean_m, cells.worst_m, cells.level_m, cells.scans, cells.walks
    found = {tuple(at): row for at, *row in zip(cells.xy_m.tolist(), *columns, strict=True)}
    assert found == {
        (2.0, 2.0): [3.0, 4.0, 11.0, 2, 2],
        (6.0, 2.0): [7.0, 7.0, 9.0, 1, 1],
        (-2.0, 2.0): [1.0, 1.0, 8.0, 1, 1],
    }


def test_without_errors_there_are_no_cells() -> None:
    assert len(error_cells(np.empty((0, 2)), np.empty(0), np.empty(0), np.empty(0, np.int64), 4.0).xy_m) == 0


def test_what_is_out_of_reach_of_every_scan_is_a_gap_and_the_largest_comes_first() -> None:
    walkable = np.ones((10, 60), bool)
    walkable[:, 40:] = False
    walkable[5, 58] = True  # too small to be named
    share, missing, gaps = coverage_gaps(walkable, 1.0, np.array([[10.0, 5.0], [30.0, 5.0]]), 8.0)
    assert missing.sum() == round((1.0 - share) * walkable.sum()) > 0
    assert not (missing & ~walkable).any()
    assert [gap.area_m2 for gap in gaps] == sorted((gap.area_m2 for gap in gaps), reverse=True)
    assert sum(gap.area_m2 for gap in gaps) == missing.sum() - 1
    for gap in gaps:
        west, south, east, north = gap.bounds_m
        assert west < gap.xy_m[0] < east and south < gap.xy_m[1] < north
        nearest_m = min(np.hypot(gap.xy_m[0] - x, gap.xy_m[1] - 5.0) for x in (10.0, 30.0))
        assert gap.distance_m == pytest.approx(nearest_m) and gap.distance_m > 8.0


def test_a_floor_without_any_scan_is_one_gap_and_one_without_area_has_none() -> None:
    share, missing, gaps = coverage_gaps(np.ones((5, 8), bool), 2.0, np.empty((0, 2)), 5.0)
    assert (share, bool(missing.all()), [gap.area_m2 for gap in gaps]) == (0.0, True, [160.0])
    assert coverage_gaps(np.zeros((5, 8), bool), 2.0, np.array([[1.0, 1.0]]), 5.0)[0] == 1.0


def survey(seed: int, spread_db: list[float], walks: int = 12, cells: int = 15) -> tuple[np.ndarray, ...]:
    """Readings of every access point in every cell on every walk; each walk has an offset of its own."""
    rng = np.random.default_rng(seed)
    ap, cell, walk = (
        axis.ravel() for axis in np.meshgrid(range(len(spread_db)), range(cells), range(walks), indexing="ij")
    )
    level_dbm = rng.uniform(-80.0, -50.0, (len(spread_db), cells))[ap, cell]
    offset_db = rng.normal(0.0, 6.0, walks)[walk]
    return ap, cell, walk, level_dbm + offset_db + rng.normal(0.0, 1.0, ap.shape) * np.array(spread_db)[ap]


def test_the_spread_of_an_access_point_is_found_beneath_the_offsets_of_the_walks() -> None:
    truth_db = [1.0, 2.0, 2.0, 3.0, 9.0]
    spread_db, repeats = between_walk_spread(*survey(1, truth_db))
    np.testing.assert_allclose(spread_db, truth_db, rtol=0.25)
    assert repeats.tolist() == [11 * 15] * 5


def test_an_access_point_that_was_heard_too_seldom_is_not_judged() -> None:
    ap, cell, walk, rssi_dbm = survey(2, [2.0, 2.0, 2.0])
    few = (ap != 2) | ((cell == 0) & (walk <= LEAST_REPEATS - 1))
    spread_db, repeats = between_walk_spread(ap[few], cell[few], walk[few], rssi_dbm[few])
    assert np.isfinite(spread_db).tolist() == [True, True, False]
    assert repeats[2] == LEAST_REPEATS - 1


def test_of_no_readings_nothing_is_told() -> None:
    none = np.empty(0, np.int64)
    spread_db, repeats = between_walk_spread(none, none, none, np.empty(0))
    assert len(spread_db) == len(repeats) == 0


def test_look_alikes_are_far_apart_and_as_alike_as_neighbours() -> None:
    xy_m = np.array([[0.0, 0.0], [1.0, 0.0], [30.0, 0.0], [31.0, 0.0], [0.5, 0.0]])
    floor = np.array([0, 0, 0, 0, 1])
    distance = np.full((5, 5), 0.9)
    for one, other, value in ((0, 1, 0.1), (2, 3, 0.2), (0, 2, 0.12), (1, 3, 0.05), (0, 4, 0.14), (1, 4, 0.16)):
        distance[one, other] = distance[other, one] = value
    limit, pairs = look_alikes(xy_m, floor, distance, 3.0, 15.0)
    assert limit == pytest.approx(0.15)
    assert pairs.tolist() == [[1, 3], [0, 2], [0, 4]]
    assert distinct_pairs(pairs, xy_m, floor, 5.0, 20).tolist() == [[1, 3], [0, 4]]
    assert distinct_pairs(pairs, xy_m, floor, 0.5, 20).tolist() == pairs.tolist()
    assert distinct_pairs(pairs, xy_m, floor, 0.5, 1).tolist() == [[1, 3]]


def test_a_map_without_neighbours_has_no_look_alikes() -> None:
    limit, pairs = look_alikes(np.array([[0.0, 0.0], [40.0, 0.0]]), np.array([0, 0]), np.ones((2, 2)), 3.0, 15.0)
    assert (limit, pairs.shape) == (0.0, (0, 2))


@given(st.integers(1, 2000), st.floats(0.0005, 0.5))
def test_a_risk_is_supported_exactly_where_its_level_exists(walks: int, risk: float) -> None:
    level_m = conformal_level(np.arange(float(walks)), risk)
    if abs(risk - smallest_risk(walks)) > 1e-6:
        assert (level_m is not None) == (risk > smallest_risk(walks))


@pytest.mark.parametrize("risk", [0.05, 0.1, 0.3])
def test_a_further_walk_stays_within_the_level_as_often_as_it_is_said_to(risk: float) -> None:
    rng = np.random.default_rng(3)
    kept = []
    for _ in range(4000):
        scores_m = rng.gamma(2.0, 2.0, 40)
        level_m = conformal_level(scores_m[:-1], risk)
        assert level_m is not None
        kept.append(scores_m[-1] <= level_m)
    assert 1.0 - risk - 0.015 < np.mean(kept) < 1.0 - risk + 1.0 / 40 + 0.015
