"""A corridor is narrow across, however long it is, and whichever way it runs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.floorplan.free_space import NO_PLAN, FreeSpace
from app.floorplan.openness import REACH_M, Surroundings, free_width_m, surroundings_of

HERE, CELL_M = np.array([40.0, 40.0]), 0.1
LOUD, QUIET = np.array([-40.0, -45.0, -50.0, -90.0]), np.array([-70.0, -75.0])


def strip(width_m: float, angle_rad: float = 0.0) -> FreeSpace:
    """A corridor through HERE, running along the direction clockwise from north."""
    north_m, east_m = (np.mgrid[0:800, 0:800] + 0.5) * CELL_M - HERE[0]
    across_m = east_m * math.cos(angle_rad) - north_m * math.sin(angle_rad)
    return FreeSpace(np.abs(across_m) <= width_m / 2.0, CELL_M)


NOWHERE = FreeSpace(np.zeros((800, 800), np.bool_), CELL_M)


@pytest.mark.parametrize("angle_deg", [0.0, 22.5, 45.0, 90.0, 135.0])
@pytest.mark.parametrize("width_m", [2.0, 3.0, 8.0])
def test_the_width_is_that_of_the_narrowest_way_across(width_m: float, angle_deg: float) -> None:
    assert free_width_m(strip(width_m, math.radians(angle_deg)), HERE) == pytest.approx(width_m, abs=0.6)


def test_in_a_hall_no_edge_is_in_reach_and_within_a_wall_there_is_no_width() -> None:
    assert free_width_m(strip(100.0), HERE) >= 2.0 * REACH_M
    assert free_width_m(NOWHERE, HERE) == 0.0


def test_the_plan_decides_whatever_the_signal() -> None:
    for rssi_dbm in (LOUD, QUIET, np.empty(0)):
        assert surroundings_of(rssi_dbm, HERE, strip(2.4)) is Surroundings.CORRIDOR
        assert surroundings_of(rssi_dbm, HERE, strip(20.0)) is Surroundings.OPEN


@pytest.mark.parametrize("space", [NO_PLAN, NOWHERE])
def test_without_a_plan_that_knows_the_place_the_signal_decides(space: FreeSpace) -> None:
    assert surroundings_of(LOUD, HERE, space) is Surroundings.CORRIDOR
    assert surroundings_of(QUIET, HERE, space) is Surroundings.OPEN
    assert surroundings_of(np.empty(0), HERE, space) is Surroundings.OPEN


def test_beyond_its_edge_a_plan_is_free_nowhere() -> None:
    cells = np.zeros((80, 120), np.bool_)
    cells[20:25, :] = True
    space = FreeSpace(cells, 0.5)
    inside = np.array([[5.0, 10.1], [5.0, 12.4], [5.0, 9.9], [5.0, 12.6]])
    assert space.is_free(inside).tolist() == [True, True, False, False]
    assert not space.is_free(np.array([[-0.1, 11.0], [60.1, 11.0], [5.0, -1.0], [5.0, 41.0]])).any()
    assert free_width_m(space, np.array([30.0, 11.25])) == pytest.approx(2.5, abs=0.6)
