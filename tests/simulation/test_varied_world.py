from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.simulation.layouts import LAYOUTS
from app.simulation.varied_world import (
    FLOORS,
    KEPT,
    SHADOWING,
    SPACING,
    STRETCH,
    SURVEY_M_PER_M2,
    Traits,
    only,
    stretched,
    varied_world,
)

PLAIN = Traits(11, "office", 1, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.1)


def test_traits_keep_to_their_ranges_and_fill_them() -> None:
    drawn = [Traits.draw(seed) for seed in range(300)]
    assert {one.kind for one in drawn} == set(LAYOUTS)
    assert {one.floors for one in drawn} == set(range(FLOORS[0], FLOORS[1] + 1))
    bounds = {"stretch_x": STRETCH, "stretch_y": STRETCH, "spacing": SPACING, "kept": KEPT, "shadowing": SHADOWING}
    for name, (low, high) in (bounds | {"survey_m_per_m2": SURVEY_M_PER_M2}).items():
        values = [getattr(one, name) for one in drawn]
        assert low <= min(values) < low + 0.1 * (high - low)
        assert high - 0.1 * (high - low) < max(values) <= high


def test_the_same_traits_are_the_same_world_and_another_seed_is_another() -> None:
    one, same, other = varied_world(PLAIN), varied_world(PLAIN), varied_world(replace(PLAIN, seed=12))
    assert np.array_equal(one.access_points.bssid, same.access_points.bssid)
    assert np.array_equal(one.access_points.place_m, same.access_points.place_m)
    assert one.building.floors[0].layout == same.building.floors[0].layout
    assert one.building.floors[0].layout != other.building.floors[0].layout


def test_a_stretched_floor_has_the_size_and_can_be_walked_without_crossing_a_wall() -> None:
    layout = LAYOUTS["office"](np.random.default_rng(1))
    wide = stretched(layout, 1.5, 0.5, 1.0)
    assert np.max(wide.outline, axis=0) == pytest.approx(np.max(layout.outline, axis=0) * [1.5, 0.5])
    floor = varied_world(replace(PLAIN, stretch_x=0.6, stretch_y=1.15)).building.floors[0]
    for seed in range(5):
        way_m = floor.route(np.random.default_rng(seed), 80.0)
        assert floor.walls.loss_between_db(way_m[:-1], way_m[1:]).tolist() == [0.0] * (len(way_m) - 1)


def test_fewer_access_points_are_there_when_fewer_are_kept_or_they_are_spaced_wider() -> None:
    def radios(traits: Traits) -> int:
        return len(varied_world(traits).access_points.level)

    assert radios(replace(PLAIN, kept=0.5)) < radios(PLAIN)
    assert radios(replace(PLAIN, spacing=1.6)) < radios(PLAIN)


def test_radios_that_are_left_keep_their_networks_and_their_levels() -> None:
    world = varied_world(PLAIN)
    every, floor = world.access_points, world.building.floors[0]
    kept = np.arange(len(every.level)) % 3 > 0
    some = only(every, kept)
    number = np.flatnonzero(kept)
    assert len(some.level) == len(number) == len(some.long_shadowing.wave_radpm)
    for bssid, radio, ssid in zip(some.bssid, some.radio, some.ssid, strict=True):
        before = int(np.flatnonzero(every.bssid == bssid)[0])
        assert (number[radio], ssid) == (every.radio[before], every.ssid[before])
    here = np.array([10.0, 10.0])
    near, dbm = some.mean_dbm(floor, np.tile(here, (len(some.level), 1)))
    was_near, was_dbm = every.mean_dbm(floor, np.tile(here, (len(every.level), 1)))
    assert dict(zip(number[near].tolist(), dbm.tolist(), strict=True)) == {
        radio: level for radio, level in zip(was_near.tolist(), was_dbm.tolist(), strict=True) if kept[radio]
    }


def test_shadowing_and_steel_are_larger_by_their_factors() -> None:
    plain, rough = varied_world(PLAIN), varied_world(replace(PLAIN, shadowing=1.5, steel=0.5))
    assert rough.access_points.long_shadowing.sigma == 1.5 * plain.access_points.long_shadowing.sigma
    assert rough.disturbance.sigma == 0.5 * plain.disturbance.sigma
