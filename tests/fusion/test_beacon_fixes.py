"""Bluetooth beacons beside WiFi, and in its place."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.fusion.beacon_listening import KEPT_S, MOST_KEPT, PACE_S, BeaconEar, listened
from app.fusion.interface import SessionStart, Site
from app.fusion.state_codec import decode_state, encode_state
from app.fusion.surefix import SUREFIX
from app.observations import Batch, BluetoothScan, Fix, Flag, Position, WifiScan
from app.wifi.beacons import beacon_key
from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import RadioMap, build_radio_map
from tests.fusion.walks import deaf, errors_m, places_m, run, site, walked

HOME = walked(5)


def of_bssid(bssid: int) -> str:
    """The beacon that stands where an access point is."""
    return f"9195b3ad-a9d0-4500-85ff-9fb0f65a5201:{bssid >> 16 & 0xFFFF}:{bssid & 0xFFFF}:{bssid >> 32}"


def beaconed(batch: Batch) -> Batch:
    """The batch of a phone that hears a beacon where each access point is."""
    return replace(batch, bluetooth=tuple(as_beacons(scan) for scan in batch.wifi))


def as_beacons(scan: WifiScan) -> BluetoothScan:
    fresh = np.flatnonzero(scan.seen_s >= scan.time_s - 3.0)
    heard = tuple(of_bssid(bssid) for bssid in scan.bssid[fresh].tolist())
    return BluetoothScan(scan.time_s, heard, scan.rssi_dbm[fresh])


@lru_cache
def beacon_site(wifi: bool = True) -> Site:
    """The office with a beacon at each of its access points. wifi : access points are on the map, too."""
    radio_map = site().radio_map
    assert radio_map is not None
    points = range(len(radio_map.scans))
    heard = [np.flatnonzero(radio_map.point == point) for point in points]
    beacons = build_radio_map(
        [
            Fingerprint(
                radio_map.floors[radio_map.floor[point]],
                float(radio_map.xy_m[point, 0]),
                float(radio_map.xy_m[point, 1]),
                0.0,
                "survey",
                np.array([beacon_key(of_bssid(b)) for b in radio_map.bssid[radio_map.access_point[pairs]].tolist()]),
                radio_map.mean_dbm[pairs].astype(np.float64),
            )
            for point, pairs in zip(points, heard, strict=True)
        ],
        cell_m=0.0,
    )
    empty: RadioMap = build_radio_map([], floors=radio_map.floors)
    return replace(site(), radio_map=replace(radio_map if wifi else empty, beacons=beacons))


def answers(fixes: list[Fix]) -> list[object]:
    return [(fix.position, fix.accuracy_m, fix.integrity) for fix in fixes]


def test_beacons_alone_locate_a_phone() -> None:
    fixes = run(SUREFIX, [deaf(beaconed(batch)) for batch in HOME.batches], beacon_site(wifi=False))
    found = errors_m(HOME, fixes)
    assert len(found) > 0.9 * len(fixes)
    assert np.mean(found) < 6.0
    flags = [fix.integrity.flag for fix in fixes]
    assert Flag.FAULT not in flags and flags.count(Flag.COASTING) < 0.1 * len(flags)
    assert {fix.position.floor for fix in fixes if fix.position} == {"F1"}


def test_a_start_on_another_floor_is_given_up_with_the_first_beacons_that_say_so() -> None:
    here = HOME.truth(HOME.batches[0].end_s or 0.0)
    start = SessionStart(start=Position(float(here[0]) + 30.0, float(here[1]), "F2"))
    fixes = run(SUREFIX, [deaf(beaconed(batch)) for batch in HOME.batches], beacon_site(wifi=False), start)
    assert np.mean(errors_m(HOME, fixes)) < 6.0
    assert Flag.FAULT not in [fix.integrity.flag for fix in fixes]


def test_beacons_that_no_map_knows_change_nothing() -> None:
    heard = [beaconed(batch) for batch in HOME.batches]
    assert answers(run(SUREFIX, heard)) == answers(run(SUREFIX, list(HOME.batches)))
    elsewhere = [
        replace(batch, bluetooth=tuple(replace(s, beacon=tuple("x" + b for b in s.beacon)) for s in batch.bluetooth))
        for batch in heard
    ]
    assert answers(run(SUREFIX, elsewhere, beacon_site())) == answers(run(SUREFIX, list(HOME.batches)))


def test_a_map_with_beacons_changes_nothing_for_a_phone_that_hears_none() -> None:
    assert answers(run(SUREFIX, list(HOME.batches), beacon_site())) == answers(run(SUREFIX, list(HOME.batches)))


def test_beside_wifi_beacons_do_no_harm_and_leave_their_record() -> None:
    fixes = run(SUREFIX, [beaconed(batch) for batch in HOME.batches], beacon_site())
    assert np.mean(errors_m(HOME, fixes)) < np.mean(errors_m(HOME, run(SUREFIX, list(HOME.batches)))) + 0.5
    checks = [check for fix in fixes for check in fix.checks if check.source == "bluetooth"]
    assert len(checks) > 10
    assert all(check.fused != check.rejected for check in checks)


def test_false_beacons_beside_wifi_move_no_answer_far() -> None:
    strange = walked(7)
    scans = [as_beacons(scan) for batch in strange.batches for scan in batch.wifi]
    false, at = [], 0
    for batch in HOME.batches:
        heard = [replace(scans[(at + k) % len(scans)], time_s=scan.time_s) for k, scan in enumerate(batch.wifi)]
        at += len(heard)
        false.append(replace(batch, bluetooth=tuple(heard)))
    fixes, clean = run(SUREFIX, false, beacon_site()), run(SUREFIX, list(HOME.batches))
    apart_m = np.hypot(*(places_m(fixes) - places_m(clean)).T)
    assert np.median(apart_m) < 4.0


def test_without_wifi_relayed_beacons_raise_an_alarm_and_win_in_the_end() -> None:
    middle = len(HOME.batches) // 2
    here = HOME.truth(HOME.batches[middle].end_s or 0.0)
    strange = walked(7)
    far = [
        as_beacons(scan)
        for batch in strange.batches
        for scan in batch.wifi
        if np.hypot(*(strange.truth(scan.time_s) - here)) > 30.0
    ]
    batches, at = [], 0
    for number, batch in enumerate(HOME.batches):
        heard = deaf(beaconed(batch))
        if number >= middle:
            relayed = [replace(far[(at + k) % len(far)], time_s=s.time_s) for k, s in enumerate(heard.bluetooth)]
            at, heard = at + len(relayed), replace(heard, bluetooth=tuple(relayed))
        batches.append(heard)
    fixes = run(SUREFIX, batches, beacon_site(wifi=False))
    alarmed = [fix for fix in fixes[middle:] if fix.integrity.flag is Flag.FAULT]
    assert alarmed and not any(fix.integrity.usable for fix in alarmed)
    assert alarmed[0].integrity.excluded[0].observation == "bluetooth"
    assert np.hypot(*(places_m(fixes)[-1] - HOME.truth(HOME.batches[-1].end_s or 0.0))) > 10.0


def test_any_worker_continues_a_session_that_hears_beacons() -> None:
    batches = [beaconed(batch) for batch in HOME.batches[:40]]
    state, told = SUREFIX.start(SessionStart()), []
    for batch in batches:
        state, fix = SUREFIX.advance(decode_state(encode_state(state)), batch, beacon_site())
        told.append(fix)
    assert answers(told) == answers(run(SUREFIX, batches, beacon_site()))


@given(st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(0, 5)), max_size=60))
def test_readings_that_come_one_by_one_are_told_together_and_none_twice(heard: list[tuple[float, int]]) -> None:
    ear, now_s, told_s = BeaconEar(), 100.0, []
    waiting: list[tuple[float, int]] = []
    for pause_s, minor in heard:
        now_s += pause_s
        waiting = [one for one in waiting if one[0] >= now_s - KEPT_S] + [(now_s, beacon_key(f"a:1:{minor}"))]
        scan = BluetoothScan(now_s, (f"a:1:{minor}",), np.array([-60.0]))
        ear, told = listened(ear, scan, now_s)
        if told is not None:
            assert told[0].tolist() == sorted({key for _, key in waiting})
            waiting = []
            told_s.append(now_s)
        assert ear.key.tolist() == [key for _, key in waiting]
    assert np.all(np.diff(told_s) >= PACE_S - 1e-9)


@pytest.mark.parametrize("scans", [1, 5])
def test_a_phone_that_floods_its_session_with_beacons_is_kept_to_a_bound(scans: int) -> None:
    many = tuple(f"a:{number}" for number in range(2000))
    ear = replace(BeaconEar(), fixed_s=100.0)
    for number in range(scans):
        scan = BluetoothScan(100.1 + 0.1 * number, many, np.full(2000, -60.0))
        ear, told = listened(ear, scan, scan.time_s)
        assert told is None
    assert len(ear.key) == len(ear.time_s) == len(ear.rssi_dbm) == MOST_KEPT


def test_a_scan_without_a_reading_is_no_fix() -> None:
    ear, told = listened(BeaconEar(), BluetoothScan(5.0, (), np.empty(0)), 5.0)
    assert told is None and ear.fixed_s is None
