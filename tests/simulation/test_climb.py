"""People change floors at the pace of people and lifts, and a barometer tells of it."""

from __future__ import annotations

import numpy as np
import pytest

from app.simulation.barometer import HPA_PER_M
from app.simulation.batches import batch_bodies
from app.simulation.climb import Climbing, ride_s
from app.simulation.recording import SURVEY_PHONE, VISITOR_PHONES, Phone, Recording, World, record_climb
from tests.simulation.conftest import RATE_HZ, START_S, recorded


def climbed(world: World, how: Climbing, levels: tuple[int, ...] = (0, 1), phone: Phone = SURVEY_PHONE) -> Recording:
    return record_climb(world, levels, how, phone, START_S, 40.0, RATE_HZ, np.random.default_rng(4))


@pytest.mark.parametrize("how", list(Climbing))
@pytest.mark.parametrize("levels", [(0, 1), (1, 0), (0, 1, 0)])
def test_a_walk_over_floors_is_one_walk_without_a_leap(world: World, how: Climbing, levels: tuple[int, ...]) -> None:
    walk = climbed(world, how, levels).walk
    storey_m = world.building.floors[0].storey_height_m
    assert np.diff(walk.time_s) == pytest.approx(1.0 / RATE_HZ, abs=1e-3)
    assert np.linalg.norm(np.diff(walk.xy_m, axis=0), axis=1).max() < 2.2 / RATE_HZ
    assert np.abs(np.diff(walk.height_m)).max() < 2.0 / RATE_HZ
    assert np.abs(np.diff(walk.heading_rad)).max() < 0.35
    assert walk.height_m[[0, -1]] == pytest.approx([levels[0] * storey_m, levels[-1] * storey_m], abs=0.1)
    assert walk.floor_at(walk.time_s[-1]).level == levels[-1]


def test_stairs_are_walked_and_lifts_are_stood_in(world: World) -> None:
    for how, least, most in ((Climbing.STAIRS, 15.0, 60.0), (Climbing.LIFT, 0.0, 0.0)):
        walk = climbed(world, how).walk
        between = np.gradient(walk.height_m) != 0.0
        steps = np.diff(walk.step_phase[between][[0, -1]])[0]
        assert least <= steps <= most
        assert 3.0 < between.sum() / RATE_HZ < 25.0


def test_a_lift_is_not_quicker_than_its_motor() -> None:
    assert ride_s(3.6) == pytest.approx(4.3, abs=0.3)
    assert ride_s(36.0) > 36.0 / 1.5


def test_the_barometer_falls_by_the_storey_and_is_sent(world: World) -> None:
    recording = climbed(world, Climbing.LIFT)
    pressure_hpa = recording.barometer.pressure_hpa
    storey_m = world.building.floors[0].storey_height_m
    fallen = float(pressure_hpa[:50].mean() - pressure_hpa[-50:].mean())
    assert fallen == pytest.approx(HPA_PER_M * storey_m, abs=0.12)
    bodies = list(batch_bodies(recording, world.access_points))
    assert {len(body["barometer"]["t"]) for body in bodies[1:]} <= {4, 5, 6}
    assert bodies[5]["end"] - 1000 < bodies[5]["barometer"]["t"][0] <= bodies[5]["end"]


def test_a_phone_without_barometer_sends_none(world: World) -> None:
    phone = next(phone for phone in VISITOR_PHONES if not phone.has_barometer)
    recording = climbed(world, Climbing.STAIRS, phone=phone)
    assert all("barometer" not in body for body in batch_bodies(recording, world.access_points))


def test_the_radio_of_the_other_floor_is_heard_after_the_climb(world: World) -> None:
    recording = climbed(world, Climbing.STAIRS)
    points = world.access_points
    scans = list(recording.scans)
    first, last = (
        np.average(points.level[points.radio[scan.network]], weights=10.0 ** (scan.rssi_dbm / 10.0))
        for scan in (scans[0], scans[-1])
    )
    assert first < 0.5 < last


def test_a_walk_on_one_floor_stays_at_its_height(world: World) -> None:
    walk = recorded(world).walk
    assert np.ptp(walk.height_m) == 0.0
    assert walk.floor_at(walk.time_s[-1]) is walk.floor
