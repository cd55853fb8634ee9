"""A scan placed without each group of access points in turn, and what that says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.fingerprint import Fingerprint
from app.wifi.match import Match
from app.wifi.match_index import GROUPS, groups_of, index_of
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.representation import SQUARED
from app.wifi.separation import cosine_distances, grouped_products, separated
from app.wifi.signal_distance import NOTHING, Distance, distances
from app.wifi.soft_match import SoftSettings, soft_match

ACCESS_POINTS = np.arange(40, dtype=np.int64) * 16 + 0x0200_0000_0000
PLAIN = SoftSettings(separated=False)


def field(rng: np.random.Generator, count: int = 60) -> tuple[RadioMap, np.ndarray]:
    """A hall of random access points, surveyed at random places, and where the access points are."""
    at_m = rng.uniform(0.0, 40.0, (len(ACCESS_POINTS), 2))
    survey = []
    for walk, place in enumerate(rng.uniform(0.0, 40.0, (count, 2))):
        bssid, rssi_dbm = heard(rng, at_m, place)
        survey.append(Fingerprint("F1", float(place[0]), float(place[1]), 0.0, str(walk), bssid, rssi_dbm))
    return build_radio_map(survey), at_m


def heard(rng: np.random.Generator, at_m: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rssi_dbm = -40.0 - 25.0 * np.log10(1.0 + np.hypot(*(at_m - place).T)) + 3.0 * rng.standard_normal(len(at_m))
    loud = rssi_dbm > -85.0
    return ACCESS_POINTS[loud], rssi_dbm[loud]


def drawn(seed: int) -> tuple[np.random.Generator, RadioMap, np.ndarray, np.ndarray]:
    """A hall, and a scan somewhere in it."""
    rng = np.random.default_rng(seed)
    radio_map, at_m = field(rng)
    return rng, radio_map, *heard(rng, at_m, rng.uniform(0.0, 40.0, 2))


def placed(radio_map: RadioMap, bssid: np.ndarray, rssi_dbm: np.ndarray, settings: SoftSettings) -> Match:
    match = soft_match(radio_map, bssid, rssi_dbm, settings)
    assert match is not None
    return match


@given(st.integers(0, 2**31))
def test_each_solution_is_the_soft_match_of_a_scan_and_a_map_without_the_group(seed: int) -> None:
    _, radio_map, bssid, rssi_dbm = drawn(seed)
    index = index_of(radio_map, SQUARED, PLAIN.smooth_m)
    products = grouped_products(index, bssid, rssi_dbm, NOTHING)
    found_m = separated(products, index, 0, PLAIN.softness, np.zeros(2))
    of_map, of_scan = groups_of(radio_map.bssid), groups_of(bssid)
    for group in range(GROUPS):
        kept = of_scan != group
        without = radio_map.bssid[of_map == group]
        alone = soft_match(radio_map, bssid[kept], rssi_dbm[kept], PLAIN, unheeded=without)
        assert alone is not None
        np.testing.assert_allclose(found_m[group], alone.xy_m, atol=1e-3)


@given(st.integers(0, 2**31))
def test_all_groups_together_are_the_cosine_with_and_without_unheeded_access_points(seed: int) -> None:
    rng, radio_map, bssid, rssi_dbm = drawn(seed)
    index = index_of(radio_map, SQUARED, PLAIN.smooth_m)
    out = rng.random(len(bssid)) < 0.3
    for unheeded, kept in ((NOTHING, np.ones(len(bssid), np.bool_)), (np.unique(bssid[out]), ~out)):
        found = cosine_distances(grouped_products(index, bssid[kept], rssi_dbm[kept], unheeded))
        want = distances(index, bssid[kept], rssi_dbm[kept], Distance.COSINE, unheeded=unheeded)
        np.testing.assert_allclose(found, want, atol=1e-9)


def test_addresses_of_one_radio_are_in_one_group_and_groups_are_about_alike() -> None:
    of_radio = groups_of(np.arange(0x0200_0000_0000, 0x0200_0000_0010))
    assert len(set(of_radio.tolist())) == 1
    counts = np.bincount(groups_of(np.arange(4000, dtype=np.int64) * 16), minlength=GROUPS)
    assert counts.min() > 800


def test_access_points_that_were_moved_part_the_solutions() -> None:
    rng = np.random.default_rng(3)
    radio_map, at_m = field(rng, 200)
    moved_m = np.where((groups_of(ACCESS_POINTS) == 1)[:, np.newaxis], at_m[::-1], at_m)
    places = rng.uniform(5.0, 35.0, (20, 2))
    sound = [placed(radio_map, *heard(rng, at_m, place), SoftSettings()) for place in places]
    misled = [placed(radio_map, *heard(rng, moved_m, place), SoftSettings()) for place in places]
    assert np.median([m.separation_m2 for m in misled]) > 3.0 * np.median([m.separation_m2 for m in sound])


def test_the_place_is_that_of_all_groups_and_a_scan_of_one_group_has_one_too() -> None:
    rng = np.random.default_rng(5)
    radio_map, at_m = field(rng)
    bssid, rssi_dbm = heard(rng, at_m, np.array([20.0, 20.0]))
    match, plain = placed(radio_map, bssid, rssi_dbm, SoftSettings()), placed(radio_map, bssid, rssi_dbm, PLAIN)
    assert match.separation_m2 > 0.0 == plain.separation_m2
    np.testing.assert_allclose(match.xy_m, plain.xy_m, atol=1e-6)
    assert 0.0 < float(np.hypot(*match.parted_m)) < 5.0
    lone = ACCESS_POINTS[groups_of(ACCESS_POINTS) == 0][:3]
    few = placed(radio_map, lone, np.array([-50.0, -60.0, -70.0]), SoftSettings())
    assert np.isfinite(few.xy_m).all() and few.separation_m2 >= 0.0


def test_outward_is_short_within_a_survey_and_points_out_of_it_at_its_edge() -> None:
    rng = np.random.default_rng(7)
    radio_map, at_m = field(rng, 400)
    within = placed(radio_map, *heard(rng, at_m, np.array([20.0, 20.0])), SoftSettings())
    edge = placed(radio_map, *heard(rng, at_m, np.array([39.5, 20.0])), SoftSettings())
    assert float(np.hypot(*within.outward_m)) < 1.5
    assert edge.outward_m[0] > 3.0 and abs(edge.outward_m[1]) < 2.0


def test_a_scan_of_few_access_points_is_less_strange_at_the_same_distance() -> None:
    radio_map, at_m = field(np.random.default_rng(9))
    match = placed(radio_map, *heard(np.random.default_rng(1), at_m, np.array([10.0, 10.0])), SoftSettings())
    assert replace(match, known=10).strangeness < 0.2 * replace(match, known=300).strangeness


@pytest.mark.parametrize("loss_db", [12.0, 18.0])
def test_a_floor_above_is_told_by_the_level_where_all_access_points_are_weakened_alike(loss_db: float) -> None:
    """A ceiling leaves the shape of a scan as it is."""
    rng = np.random.default_rng(11)
    at_m = rng.uniform(0.0, 40.0, (len(ACCESS_POINTS), 2))
    survey = []
    for walk, place in enumerate(rng.uniform(0.0, 40.0, (200, 2))):
        bssid, rssi_dbm = heard(rng, at_m, place)
        floor = "F1" if walk % 2 else "F2"
        level_dbm = rssi_dbm - (loss_db if floor == "F2" else 0.0)
        survey.append(Fingerprint(floor, float(place[0]), float(place[1]), 0.0, str(walk), bssid, level_dbm))
    radio_map = build_radio_map(survey)
    right = []
    for place in rng.uniform(5.0, 35.0, (40, 2)):
        bssid, rssi_dbm = heard(rng, at_m, place)
        for number, floor_db in enumerate((0.0, loss_db)):
            match = placed(radio_map, bssid, rssi_dbm - floor_db, SoftSettings())
            right.append(match.floor == number and match.floor_probability[number] > 0.5)
    assert np.mean(right) > 0.8
