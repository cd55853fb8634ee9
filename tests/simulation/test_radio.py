from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.simulation.random_field import RandomField
from app.simulation.recording import World
from app.simulation.walls import LARGEST_LOSS_DB, Walls
from app.simulation.wifi_scanner import DEAF_BELOW_DBM, KEPT_S, SimulatedScan
from tests.simulation.conftest import recorded


def _turn(a: complex, b: complex, c: complex) -> float:
    return ((b - a).conjugate() * (c - a)).imag


@settings(max_examples=200, deadline=None)
@given(st.lists(st.floats(-50.0, 50.0), min_size=8, max_size=8))
def test_a_wall_costs_exactly_the_lines_that_cross_it(numbers: list[float]) -> None:
    a, b, c, d = (complex(x, y) for x, y in zip(numbers[::2], numbers[1::2], strict=True))
    crosses = _turn(a, b, c) * _turn(a, b, d) < 0 and _turn(c, d, a) * _turn(c, d, b) < 0
    if min(abs(_turn(*p)) for p in ((a, b, c), (a, b, d), (c, d, a), (c, d, b))) < 1e-6:
        return  # they only touch
    walls = Walls(np.array([[c.real, c.imag]]), np.array([[d.real, d.imag]]), np.array([3.0]))
    loss = walls.loss_between_db(np.array([[a.real, a.imag]]), np.array([[b.real, b.imag]]))[0]
    assert loss == pytest.approx(-LARGEST_LOSS_DB * np.expm1(-3.0 / LARGEST_LOSS_DB) if crosses else 0.0)


def test_many_walls_cost_no_more_than_the_way_around() -> None:
    x = np.arange(1.0, 60.0)
    walls = Walls(np.column_stack([x, -np.ones(59)]), np.column_stack([x, np.ones(59)]), np.full(59, 5.0))
    loss = walls.loss_between_db(np.zeros((2, 2)), np.array([[0.5, 0.0], [100.0, 0.0]]))
    assert loss[0] == 0.0
    assert LARGEST_LOSS_DB - 0.1 < loss[1] <= LARGEST_LOSS_DB


def test_a_random_field_has_its_spread_and_forgets_with_distance() -> None:
    rng = np.random.default_rng(1)
    field = RandomField.draw(rng, 400, sigma=4.0, length_m=6.0)
    here, near, far = (field.all_at(np.array([[x, 20.0, 1.0]]))[0] for x in (10.0, 11.0, 60.0))
    assert here.std() == pytest.approx(4.0, rel=0.15)
    assert np.corrcoef(here, near)[0, 1] > 0.85
    assert abs(np.corrcoef(here, far)[0, 1]) < 0.2


def test_signals_fade_with_distance_and_are_weaker_through_a_floor(world: World) -> None:
    points, (ground, upper) = world.access_points, world.building.floors
    own = points.level == 0
    near = np.where(own[:, None], points.place_m[:, :2] + 2.0, 0.0)
    radios, level = points.mean_dbm(ground, near)
    over, level_over = points.mean_dbm(upper, near)
    at = dict(zip(radios.tolist(), level.tolist(), strict=True))
    above = dict(zip(over.tolist(), level_over.tolist(), strict=True))
    both = [r for r in np.flatnonzero(own).tolist() if r in at and r in above]
    assert np.mean([at[r] - above[r] for r in both]) > 10.0


def test_every_network_has_an_address_of_its_own(world: World) -> None:
    points = world.access_points
    assert len(set(points.bssid.tolist())) == len(points.bssid) == len(points.ssid) == len(points.radio)
    assert len(points.bssid) > 200
    assert set(points.radio.tolist()) == set(range(len(points.level)))


def test_scans_come_every_two_seconds_or_later_and_repeat_what_is_stale(scans: list[SimulatedScan]) -> None:
    times = np.array([scan.time_ms for scan in scans]) / 1000
    age_s = np.concatenate([(scan.time_ms - scan.seen_ms) / 1000 for scan in scans])
    rssi = np.concatenate([scan.rssi_dbm for scan in scans])
    assert np.diff(times).min() > 1.4
    assert 1.9 < np.median(np.diff(times)) < 2.6
    assert age_s.min() > 0.0
    assert age_s.max() <= KEPT_S + 0.01
    assert 0.15 < np.mean(age_s > 10.0) < 0.35
    assert rssi.min() >= np.floor(DEAF_BELOW_DBM)
    assert any(len(set(scan.network.tolist())) < len(scan.network) for scan in scans)


def test_the_same_seed_gives_the_same_scans(world: World) -> None:
    one, other = (list(recorded(world, seed=9).scans) for _ in range(2))
    assert [scan.time_ms for scan in one] == [scan.time_ms for scan in other]
    assert all((a.rssi_dbm == b.rssi_dbm).all() for a, b in zip(one, other, strict=True))
