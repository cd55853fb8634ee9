"""Bluetooth beacons beside access points: one key space, two maps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.beacons import BEACON_MATCH, MARK, beacon_key, heard_beacons, parted
from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import BEACON_DEFAULT, FEW_WALKS_WEIGHT, calibrated_map, calibration_of
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.radio_map_codec import encode_radio_map
from app.wifi.soft_match import soft_match
from tests.wifi.surveys import corridor, fingerprint, fingerprints, heard_at

UUID = "9195B3AD-A9D0-4500-85FF-9FB0F65A5201"


def marked(survey: list[Fingerprint]) -> list[Fingerprint]:
    """The same survey of beacons."""
    return [replace(one, bssid=one.bssid + MARK) for one in survey]


@given(st.text(max_size=128))
def test_the_key_of_a_beacon_is_no_address_and_fits_in_64_bits(beacon: str) -> None:
    assert MARK <= beacon_key(beacon) < 1 << 63


def test_beacons_differ_by_each_part_of_their_identifier_but_not_by_case() -> None:
    keys = {beacon_key(f"{UUID}:{major}:{minor}") for major in range(30) for minor in range(30)}
    assert len(keys) == 900
    assert beacon_key(f"{UUID}:1:2") == beacon_key(f"{UUID.lower()}:1:2")


def test_half_a_character_in_an_identifier_makes_a_key_as_well() -> None:
    assert beacon_key("\ud800") >= MARK


@given(st.lists(st.tuples(st.integers(MARK, MARK + 5), st.floats(-100.0, -20.0)), max_size=30))
def test_a_beacon_that_is_heard_several_times_counts_once_with_its_mean(readings: list[tuple[int, float]]) -> None:
    key = np.array([one for one, _ in readings], np.int64)
    keys, levels = heard_beacons(key, np.array([level for _, level in readings], np.float64))
    assert keys.tolist() == sorted(set(key.tolist()))
    for one, level in zip(keys.tolist(), levels.tolist(), strict=True):
        heard = [level for other, level in readings if other == one]
        assert min(heard) - 1e-9 <= level <= max(heard) + 1e-9


@given(fingerprints(), fingerprints())
def test_parting_a_survey_loses_nothing_and_mixes_nothing(one: list[Fingerprint], other: list[Fingerprint]) -> None:
    together = [
        replace(a, bssid=np.append(a.bssid, b.bssid + MARK), rssi_dbm=np.append(a.rssi_dbm, b.rssi_dbm))
        for a, b in zip(one, other, strict=False)
    ]
    of_access_points, of_beacons = parted(one + marked(other) + together)
    assert all((part.bssid < MARK).all() for part in of_access_points)
    assert all((part.bssid >= MARK).all() for part in of_beacons)
    heard = sum(len(part.bssid) for part in one + other + together)
    assert sum(len(part.bssid) for part in of_access_points + of_beacons) == heard


def test_beacons_of_a_survey_leave_the_map_of_access_points_as_it_is() -> None:
    plain, both = calibrated_map(corridor()), calibrated_map(corridor() + marked(corridor(seed=1)))
    assert encode_radio_map(replace(both, beacons=None)) == encode_radio_map(plain)
    assert both.beacons is not None and both.beacons.floors == both.floors
    assert (both.beacons.bssid >= MARK).all()


def test_a_survey_of_beacons_alone_makes_a_map_that_knows_its_floors_and_no_access_point() -> None:
    radio_map = calibrated_map(marked(corridor()))
    assert radio_map.floors == ("B1", "F1") and len(radio_map.bssid) == 0
    assert radio_map.beacons is not None
    # one walk teaches nothing
    cautious = replace(BEACON_DEFAULT, distance_m2=FEW_WALKS_WEIGHT * BEACON_DEFAULT.distance_m2)
    assert calibration_of(radio_map.beacons, BEACON_DEFAULT) == cautious


def test_the_level_of_a_single_beacon_says_how_far_it_is() -> None:
    line = [fingerprint("F1", float(x), 0.0, {MARK + 1: -50 - 2 * x}) for x in range(20)]
    radio_map: RadioMap = build_radio_map(line)
    found = [soft_match(radio_map, np.array([MARK + 1]), np.array([-50.0 - 2 * x]), BEACON_MATCH) for x in (2, 9, 16)]
    places = [match.xy_m[0] for match in found if match is not None]
    assert len(places) == 3
    assert np.all(np.diff(places) > 2.0)


def test_matching_beacons_places_a_phone_on_its_floor() -> None:
    radio_map, rng = build_radio_map(marked(corridor())), np.random.default_rng(2)
    for x_m in (6.0, 20.0, 33.0):
        scan = heard_at(x_m, 1, rng)
        match = soft_match(radio_map, scan.bssid + MARK, scan.rssi_dbm, BEACON_MATCH)
        assert match is not None and radio_map.floors[match.floor] == "F1"
        assert abs(match.xy_m[0] - x_m) < 5.0
