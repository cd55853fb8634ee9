"""The way is found from accelerations however the phone is turned, and its doubt is stated."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.observations import Carrying
from app.pdr.carried_state import EAST, FACES, NORTH, POINTS, TURNED, UP
from app.pdr.quaternion_ukf import turn_covariance
from app.pdr.rmpca import (
    AXIS_LARGEST_RAD,
    Direction,
    DirectionSettings,
    attitude_share,
    axis_variance,
    forward_evidence,
    nearer_end,
    principal_heading,
    step_moments,
    turned_clockwise,
    walked_on,
)

headings = st.floats(-math.pi, math.pi)
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
CERTAIN = (LEVEL, np.zeros((4, 4)))
AS_PAPER = DirectionSettings(keep=0.0, axis_rad=0.0, axis_samples=math.inf, pointed_rad=math.inf)


def step_cells(heading_rad: float, across: float = 0.3, turned_rad: float = 0.0, faces: float = 0.0) -> FloatArray:
    """Cells of one step: pushed ahead while it is lifted, swaying a little to the side."""
    phase = 2.0 * np.pi * np.arange(14) / 14.0
    along, aside = 2.0 * np.cos(phase), 2.0 * across * np.sin(phase)
    cells = np.zeros((14, 8))
    cells[:, EAST] = along * math.sin(heading_rad) + aside * math.cos(heading_rad)
    cells[:, NORTH] = along * math.cos(heading_rad) - aside * math.sin(heading_rad)
    cells[:, UP] = 3.0 * np.sin(phase)
    cells[:, FACES], cells[:, TURNED], cells[:, POINTS] = faces, turned_rad, 0.4
    return cells


def apart(one_rad: float, other_rad: float) -> float:
    return abs(wrap(one_rad - other_rad))


@settings(deadline=None)
@given(headings)
def test_the_axis_of_most_spread_is_the_way_and_the_push_tells_which_end(heading_rad: float) -> None:
    cells = step_cells(heading_rad)
    axis = principal_heading(step_moments(cells))
    east, north = forward_evidence(cells)
    assert apart(math.atan2(east, north), heading_rad) < math.radians(45.0)
    assert apart(nearer_end(axis, math.atan2(east, north)), heading_rad) < 1e-6


@settings(deadline=None)
@given(headings, headings)
def test_an_end_is_never_more_than_a_right_angle_away(axis_rad: float, heading_rad: float) -> None:
    end = nearer_end(axis_rad, heading_rad)
    assert apart(end, heading_rad) <= math.pi / 2 + 1e-9
    assert apart(2.0 * end, 2.0 * axis_rad) < 1e-9


@settings(deadline=None)
@given(headings, headings)
def test_moments_turn_with_the_walker(heading_rad: float, turn_rad: float) -> None:
    moments, forward = turned_clockwise(
        step_moments(step_cells(heading_rad)), forward_evidence(step_cells(heading_rad)), turn_rad
    )
    assert moments == pytest.approx(step_moments(step_cells(heading_rad + turn_rad)), abs=1e-9)
    assert forward == pytest.approx(forward_evidence(step_cells(heading_rad + turn_rad)), abs=1e-9)


def test_a_rounder_spread_is_a_more_doubtful_axis() -> None:
    doubts = [axis_variance(step_moments(step_cells(0.3, across)), 0.3, 6.0) for across in (0.0, 0.3, 0.6, 0.9, 1.0)]
    assert doubts == sorted(doubts)
    assert doubts[0] == pytest.approx(0.09)
    assert doubts[-1] == AXIS_LARGEST_RAD**2
    assert axis_variance(np.zeros((3, 3)), 0.3, 6.0) == AXIS_LARGEST_RAD**2


@settings(deadline=None)
@given(headings, st.floats(0.01, 0.2))
def test_doubt_about_the_azimuth_is_doubt_about_the_heading(heading_rad: float, sigma_rad: float) -> None:
    covariance = turn_covariance(LEVEL, np.diag([0.0, 0.0, sigma_rad**2]))
    for share in (0.0, 0.4, 1.0):
        found = attitude_share(LEVEL, covariance, step_moments(step_cells(heading_rad)), share)
        assert found == pytest.approx(sigma_rad**2, rel=0.05)


def test_the_transform_agrees_with_many_random_attitudes() -> None:
    """Also for doubt about the level, which bends the axis through the vertical movement."""
    moments = step_moments(step_cells(0.8, across=0.2))
    turn = np.diag([0.05, 0.08, 0.1]) ** 2
    q = np.roll(Rotation.from_euler("zxy", [0.5, 0.9, -0.4]).as_quat(), 1)
    found = attitude_share(q, turn_covariance(q, turn), moments, 1.0)
    errors = np.random.default_rng(2).multivariate_normal(np.zeros(3), turn, 20_000)
    before = principal_heading(moments)
    axes = []
    for matrix in Rotation.from_rotvec(errors).as_matrix():
        flat = matrix @ moments @ matrix.T
        axes.append(wrap(2.0 * (0.5 * math.atan2(2.0 * flat[0, 1], flat[1, 1] - flat[0, 0]) - before)) / 2.0)
    assert found == pytest.approx(np.var(axes), rel=0.1)


@settings(deadline=None)
@given(headings)
def test_a_walk_keeps_its_direction_through_turns_in_any_position(heading_rad: float) -> None:
    direction, total = Direction(), 0.0
    for k in range(12):
        turn = 0.3 if 4 <= k < 9 else 0.0
        total += turn
        cells = step_cells(heading_rad + total, turned_rad=total)
        direction, variance = walked_on(direction, cells, CERTAIN, Carrying.POCKET)
        assert apart(direction.heading_rad, heading_rad + total) < 1e-6
        assert 0.09 <= variance < 0.2


def test_a_phone_that_is_looked_at_points_along_the_way() -> None:
    cells = step_cells(0.9, faces=0.9)
    by_axis, _ = walked_on(Direction(), cells, CERTAIN, Carrying.POCKET)
    both, doubt = walked_on(Direction(), cells, CERTAIN, Carrying.HANDHELD)
    literal, no_doubt = walked_on(Direction(), cells, CERTAIN, Carrying.HANDHELD, AS_PAPER)
    assert by_axis.heading_rad == pytest.approx(0.9)
    assert 0.4 < both.heading_rad < 0.65 and doubt < 0.04  # it points to 0.4
    assert literal.heading_rad == pytest.approx(0.9) and no_doubt == pytest.approx(0.0, abs=1e-12)


def test_a_screen_that_does_not_face_up_is_not_looked_at() -> None:
    for faces in (0.0, -1.0):
        found, _ = walked_on(Direction(), step_cells(2.6, faces=faces), CERTAIN, Carrying.HANDHELD)
        assert found.heading_rad == pytest.approx(2.6)
