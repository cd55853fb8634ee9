"""A corridor is narrow across, however long it is, and whichever way it runs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.estimation.arrays import BoolArray, FloatArray
from app.floorplan.openness import REACH_M, Surroundings, Walkable, free_width_m, surroundings_of, walkable_on

HERE = np.array([40.0, 40.0])
LOUD, QUIET = np.array([-40.0, -45.0, -50.0, -90.0]), np.array([-70.0, -75.0])


def strip(width_m: float, angle_rad: float = 0.0) -> Walkable:
    """An endless corridor through HERE, running along the direction clockwise from north."""

    def walkable(xy_m: FloatArray) -> BoolArray:
        apart_m = xy_m - HERE
        across_m = apart_m @ np.array([math.cos(angle_rad), -math.sin(angle_rad)])
        return np.asarray(np.abs(across_m) <= width_m / 2.0)

    return walkable


def nowhere(xy_m: FloatArray) -> BoolArray:
    return np.zeros(len(xy_m), np.bool_)


@pytest.mark.parametrize("angle_deg", [0.0, 22.5, 45.0, 90.0, 135.0])
@pytest.mark.parametrize("width_m", [2.0, 3.0, 8.0])
def test_the_width_is_that_of_the_narrowest_way_across(width_m: float, angle_deg: float) -> None:
    assert free_width_m(strip(width_m, math.radians(angle_deg)), HERE) == pytest.approx(width_m, abs=0.6)


def test_in_a_hall_no_edge_is_in_reach_and_within_a_wall_there_is_no_width() -> None:
    assert free_width_m(strip(100.0), HERE) >= 2.0 * REACH_M
    assert free_width_m(nowhere, HERE) == 0.0


def test_the_plan_decides_whatever_the_signal() -> None:
    for rssi_dbm in (LOUD, QUIET, np.empty(0)):
        assert surroundings_of(rssi_dbm, HERE, strip(2.4)) is Surroundings.CORRIDOR
        assert surroundings_of(rssi_dbm, HERE, strip(20.0)) is Surroundings.OPEN


@pytest.mark.parametrize(("xy_m", "walkable"), [(None, None), (HERE, None), (None, strip(2.0)), (HERE, nowhere)])
def test_without_a_plan_that_knows_the_place_the_signal_decides(
    xy_m: FloatArray | None, walkable: Walkable | None
) -> None:
    assert surroundings_of(LOUD, xy_m, walkable) is Surroundings.CORRIDOR
    assert surroundings_of(QUIET, xy_m, walkable) is Surroundings.OPEN
    assert surroundings_of(np.empty(0), xy_m, walkable) is Surroundings.OPEN


def test_a_grid_of_cells_is_walkable_where_it_says_and_nowhere_beyond_its_edge() -> None:
    cells = np.zeros((80, 120), np.bool_)
    cells[20:25, :] = True
    walkable = walkable_on(cells, 0.5)
    assert walkable(np.array([[5.0, 10.1], [5.0, 12.4], [5.0, 9.9], [5.0, 12.6]])).tolist() == [
        True,
        True,
        False,
        False,
    ]
    assert walkable(np.array([[-0.1, 11.0], [60.1, 11.0], [5.0, -1.0], [5.0, 41.0]])).tolist() == [False] * 4
    assert free_width_m(walkable, np.array([30.0, 11.25])) == pytest.approx(2.5, abs=0.6)
