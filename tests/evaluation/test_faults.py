from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.evaluation.campaign import read_walks
from app.evaluation.faults import FAULTS
from app.evaluation.faulty_walk import FAR_M, Elsewhere, FaultyWalk, elsewhere_of
from app.evaluation.recordings import RecordedWalk, floor_folders
from app.evaluation.truth import batches_of, places_at
from app.observations import AxisSamples, WifiScan


@pytest.fixture(scope="module")
def walks(small_site: Path) -> list[RecordedWalk]:
    read = read_walks(floor_folders(small_site, ["F1"]))
    field = AxisSamples(
        read[0].trace.gyroscope.time_s, np.tile((0.0, 20.0, -40.0), (len(read[0].trace.gyroscope.time_s), 1))
    )
    return [replace(walk, trace=replace(walk.trace, magnetometer=field)) for walk in read]


@pytest.fixture(scope="module")
def elsewhere(walks: list[RecordedWalk]) -> Elsewhere:
    """The survey, with access points of its own, so far away that all of it can be relayed."""
    survey = elsewhere_of(walks[1:])
    scans = tuple(replace(scan, bssid=scan.bssid + 1000) for scan in survey.scans)
    return Elsewhere(survey.xy_m + np.array([2.0 * FAR_M, 0.0]), scans)


def _inject(fault: str, walk: RecordedWalk, elsewhere: Elsewhere, seed: int = 1) -> FaultyWalk:
    faulty = FAULTS[fault](walk, elsewhere, np.random.default_rng(seed))
    assert faulty is not None
    return faulty


def _told(walk: RecordedWalk) -> list[tuple[float, list[int], list[float], list[float]]]:
    return [(s.time_s, s.bssid.tolist(), s.rssi_dbm.tolist(), s.seen_s.tolist()) for s in walk.trace.scans]


def _before_and_after(faulty: FaultyWalk) -> tuple[list[WifiScan], list[WifiScan]]:
    scans = faulty.walk.trace.scans
    return [s for s in scans if s.time_s < faulty.begin_s], [s for s in scans if s.time_s >= faulty.begin_s]


@pytest.mark.parametrize("fault", FAULTS)
def test_the_same_seed_gives_the_same_fault_and_the_walk_itself_stays_as_it_was(
    fault: str, walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    before = _told(walks[0])
    one, other = _inject(fault, walks[0], elsewhere), _inject(fault, walks[0], elsewhere)
    assert _told(one.walk) == _told(other.walk)
    assert one.walk.start == other.walk.start
    assert np.array_equal(one.walk.trace.magnetometer.values, other.walk.trace.magnetometer.values)
    assert _told(walks[0]) == before


@pytest.mark.parametrize("fault", FAULTS)
def test_every_fault_falls_into_the_walk_and_leaves_scans_that_are_valid(
    fault: str, walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    faulty = _inject(fault, walks[0], elsewhere)
    first_s, last_s = faulty.walk.trace.waypoint_time_s[[0, -1]]
    assert first_s <= faulty.begin_s < faulty.end_s <= last_s
    for scan in faulty.walk.trace.scans:
        assert len(scan.bssid) == len(set(scan.bssid.tolist())) == len(scan.rssi_dbm) == len(scan.seen_s)
        assert scan.bssid.dtype == np.int64
        assert np.all(scan.seen_s <= scan.time_s)


@pytest.mark.parametrize("fault", [fault for fault in FAULTS if fault != "clock_jump"])
def test_the_truth_is_not_changed_by_a_fault(fault: str, walks: list[RecordedWalk], elsewhere: Elsewhere) -> None:
    trace = _inject(fault, walks[0], elsewhere).walk.trace
    assert np.array_equal(trace.waypoint_time_s, walks[0].trace.waypoint_time_s)
    assert np.array_equal(trace.waypoint_xy_m, walks[0].trace.waypoint_xy_m)


def test_relayed_scans_come_from_afar_in_their_order_at_the_times_of_the_phones_own(
    walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    faulty = _inject("replay", walks[0], elsewhere)
    before, after = _before_and_after(faulty)
    own = walks[0].trace.scans
    assert [s.time_s for s in (*before, *after)] == [s.time_s for s in own]
    assert all(np.array_equal(one.bssid, other.bssid) for one, other in zip(before, own, strict=False))
    assert after[0].time_s == faulty.begin_s
    assert all(min(scan.bssid) >= min(elsewhere.scans[0].bssid) for scan in after)
    levels = np.array([scan.rssi_dbm for scan in elsewhere.scans])
    first = [int(np.argmin(np.abs(levels - scan.rssi_dbm).sum(axis=1))) for scan in after]
    assert np.all(
        np.abs(np.array([scan.rssi_dbm for scan in after]) - levels[first]) < 8.0
    )  # but for the relay's noise


def test_nothing_can_be_relayed_where_no_place_is_far_enough(walks: list[RecordedWalk]) -> None:
    near = elsewhere_of(walks[1:])  # at most 27 m away
    for fault in ("replay", "rogue", "moved", "duplicated"):
        assert FAULTS[fault](walks[0], near, np.random.default_rng(1)) is None
    assert elsewhere_of([]).xy_m.shape == (0, 2)


def test_imitated_access_points_are_loud_and_the_phones_own_stay(
    walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    _, after = _before_and_after(_inject("rogue", walks[0], elsewhere))
    for scan, own in zip(after, walks[0].trace.scans[-len(after) :], strict=True):
        assert set(own.bssid.tolist()) < set(scan.bssid.tolist())
        assert np.all(scan.rssi_dbm[~np.isin(scan.bssid, own.bssid)] == -40.0)


def test_moved_access_points_are_heard_as_at_the_other_place_and_the_others_as_ever(walks: list[RecordedWalk]) -> None:
    survey = elsewhere_of(walks[1:])
    quiet = tuple(replace(scan, rssi_dbm=scan.rssi_dbm - 100.0) for scan in survey.scans)
    faulty = _inject("moved", walks[0], Elsewhere(survey.xy_m + 2.0 * FAR_M, quiet))
    assert faulty.begin_s == walks[0].trace.scans[0].time_s
    there = {int(b) for s in faulty.walk.trace.scans for b in s.bssid[s.rssi_dbm < -100.0]}
    here = {int(b) for s in faulty.walk.trace.scans for b in s.bssid[s.rssi_dbm >= -100.0]}
    assert len(there) == 1 and len(here) == 3  # 30 % of four
    assert not there & here


def test_faulty_access_points_are_named_and_the_others_are_heard_as_ever(
    walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    for fault in ("moved", "spoofed", "duplicated", "vanished"):
        faulty = _inject(fault, walks[0], elsewhere)
        named = np.array(sorted(faulty.access_points))
        assert len(named)
        for scan, own in zip(faulty.walk.trace.scans, walks[0].trace.scans, strict=True):
            stays, was = ~np.isin(scan.bssid, named), ~np.isin(own.bssid, named)
            levels = dict(zip(scan.bssid[stays].tolist(), scan.rssi_dbm[stays].tolist(), strict=True))
            assert levels == dict(zip(own.bssid[was].tolist(), own.rssi_dbm[was].tolist(), strict=True))


def test_swapped_access_points_sound_as_each_other_and_twice_swapped_is_as_before(walks: list[RecordedWalk]) -> None:
    many = replace(
        walks[0],
        trace=replace(
            walks[0].trace,
            scans=tuple(
                WifiScan(s.time_s, np.arange(20), np.arange(-80.0, -60.0), np.full(20, s.time_s))
                for s in walks[0].trace.scans
            ),
        ),
    )
    faulty = _inject("swapped", many, elsewhere_of([]))
    assert len(faulty.access_points) == 4
    scan = faulty.walk.trace.scans[0]
    sounds_as = dict(zip(scan.bssid.tolist(), scan.rssi_dbm.tolist(), strict=True))
    for one in faulty.access_points:
        other = int(sounds_as[one] + 80.0)
        assert other != one and other in faulty.access_points and sounds_as[other] == one - 80.0


def test_spoofed_access_points_are_loud_and_steady_in_every_scan(
    walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    faulty = _inject("spoofed", walks[0], elsewhere)
    for one in faulty.access_points:
        levels = np.concatenate([s.rssi_dbm[s.bssid == one] for s in faulty.walk.trace.scans])
        assert len(levels) == len(walks[0].trace.scans)
        assert levels.std() < 3.0 and levels.min() > -67.0


def test_of_an_address_on_the_air_twice_the_louder_one_is_reported(walks: list[RecordedWalk]) -> None:
    survey = elsewhere_of(walks[1:])
    for shift_db, heard_there in ((-100.0, False), (100.0, True)):
        scans = tuple(replace(scan, rssi_dbm=scan.rssi_dbm + shift_db) for scan in survey.scans)
        faulty = FAULTS["duplicated"](walks[0], Elsewhere(survey.xy_m + 2.0 * FAR_M, scans), np.random.default_rng(1))
        assert faulty is not None
        for scan, own in zip(faulty.walk.trace.scans, walks[0].trace.scans, strict=True):
            here = np.isin(scan.bssid, np.intersect1d(own.bssid, sorted(faulty.access_points)))
            if not heard_there:
                assert np.isin(scan.rssi_dbm[here], own.rssi_dbm).all()
        louder = max(float(scan.rssi_dbm.max()) for scan in faulty.walk.trace.scans)
        assert (louder > 0.0) is heard_there


def test_vanished_access_points_are_in_no_scan(walks: list[RecordedWalk], elsewhere: Elsewhere) -> None:
    faulty = _inject("vanished", walks[0], elsewhere)
    assert not faulty.access_points & {int(b) for s in faulty.walk.trace.scans for b in s.bssid}


def test_another_phone_hears_fifteen_decibels_less_and_loses_the_faintest(
    walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    own = replace(walks[0].trace.scans[0], rssi_dbm=np.array([-40.0, -84.0, -85.0, -86.0]))
    walk = replace(walks[0], trace=replace(walks[0].trace, scans=(own,)))
    (scan,) = _inject("offset", walk, elsewhere).walk.trace.scans
    assert scan.rssi_dbm.tolist() == [-55.0, -99.0, -100.0]
    assert scan.bssid.tolist() == own.bssid.tolist()[:3]


def test_half_of_the_access_points_are_gone_from_every_scan(walks: list[RecordedWalk], elsewhere: Elsewhere) -> None:
    left = {int(b) for scan in _inject("half_gone", walks[0], elsewhere).walk.trace.scans for b in scan.bssid}
    assert len(left) == 2


def test_on_a_stale_map_an_access_point_is_off_by_the_same_everywhere_and_some_are_new(
    walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    scans = _inject("stale_map", walks[0], elsewhere).walk.trace.scans
    own = walks[0].trace.scans
    names = {int(b) for scan in own for b in scan.bssid}
    offsets = [scan.rssi_dbm - before.rssi_dbm for scan, before in zip(scans, own, strict=True)]
    assert all(np.array_equal(offset, offsets[0]) for offset in offsets)
    assert len(set(offsets[0].tolist())) > 1
    assert len({int(b) for scan in scans for b in scan.bssid} - names) == 1


@pytest.mark.parametrize(("fault", "seconds"), [("silence_20", 10.0), ("silence_60", 10.0)])
def test_no_scan_arrives_during_a_silence_which_ends_with_the_walk(
    fault: str, seconds: float, walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    faulty = _inject(fault, walks[0], elsewhere)  # a walk of 20 s
    assert faulty.end_s - faulty.begin_s == pytest.approx(seconds)
    assert not [s for s in faulty.walk.trace.scans if faulty.begin_s <= s.time_s < faulty.end_s]
    assert [s for s in faulty.walk.trace.scans if s.time_s < faulty.begin_s]


def test_every_scan_arrives_twice_and_some_out_of_order(walks: list[RecordedWalk], elsewhere: Elsewhere) -> None:
    walk = _inject("duplicates", walks[0], elsewhere).walk
    times = [scan.time_s for batch in batches_of(walk.trace, 60.0) for scan in batch.wifi]
    assert len(walk.trace.scans) == 2 * len(walks[0].trace.scans)
    assert times != sorted(times)
    assert walk.trace.scans[0].time_s == walks[0].trace.scans[0].time_s


def test_after_a_clock_jump_the_walk_goes_on_where_it_was(walks: list[RecordedWalk], elsewhere: Elsewhere) -> None:
    trace, own = _inject("clock_jump", walks[0], elsewhere).walk.trace, walks[0].trace
    jump_s = trace.waypoint_time_s[-1] - own.waypoint_time_s[-1]
    assert jump_s == pytest.approx(30.0)
    moved = [scan for scan in trace.scans if scan.time_s > trace.waypoint_time_s[1]]
    places = places_at(trace, np.array([scan.time_s for scan in moved]))
    same = places_at(own, np.array([scan.time_s for scan in own.scans[-len(moved) :]]))
    assert len(moved) > 0
    assert places == pytest.approx(same)
    for stream in (trace.accelerometer, trace.gyroscope, trace.rotation_vector):
        assert np.all(np.diff(stream.time_s) >= 0.0)
        assert np.diff(stream.time_s).max() >= jump_s


def test_a_wrong_start_is_forty_metres_off(walks: list[RecordedWalk], elsewhere: Elsewhere) -> None:
    starts = [_inject("wrong_start", walks[0], elsewhere, seed).walk.start for seed in (1, 2)]
    x_m, y_m = walks[0].trace.waypoint_xy_m[0]
    assert all(s is not None and math.hypot(s.x_m - x_m, s.y_m - y_m) == pytest.approx(FAR_M) for s in starts)
    assert starts[0] != starts[1]


def test_a_phone_that_is_held_across_points_elsewhere_and_feels_the_same(
    walks: list[RecordedWalk], elsewhere: Elsewhere
) -> None:
    angles = set()
    for seed in range(12):
        turned = _inject("held_across", walks[0], elsewhere, seed)
        before, after = walks[0].trace, turned.walk.trace
        for name in ("accelerometer", "gyroscope", "magnetometer"):
            vectors, same = getattr(after, name).values, getattr(before, name).values
            assert np.linalg.norm(vectors, axis=1) == pytest.approx(np.linalg.norm(same, axis=1))
            assert vectors[:, 2] == pytest.approx(same[:, 2])
        held, was = (_attitudes(trace.rotation_vector.values) for trace in (after, before))
        # what is felt and how it is held agree: the force in the frame of the building is as before
        count = min(len(held), len(before.accelerometer.time_s))
        force = held[:count].apply(after.accelerometer.values[:count])
        assert force == pytest.approx(was[:count].apply(before.accelerometer.values[:count]), abs=1e-6)
        angles.add(round(float(np.degrees((was[:1].inv() * held[:1]).as_rotvec()[0, 2]))))
        assert turned.begin_s == before.waypoint_time_s[0]
    assert {abs(angle) for angle in angles} == {90, 180}


def _attitudes(vector: FloatArray) -> Rotation:
    w = np.sqrt(np.clip(1.0 - np.square(vector).sum(axis=1, keepdims=True), 0.0, 1.0))
    return Rotation.from_quat(np.hstack([vector, w]))


def test_faults_of_a_sensor_begin_in_the_middle_and_not_before(walks: list[RecordedWalk], elsewhere: Elsewhere) -> None:
    turning = np.linspace(0.0, 1.0, len(walks[0].trace.gyroscope.time_s))[:, None] * np.ones(3)
    gyroscope = replace(walks[0].trace.gyroscope, values=turning)
    walk = replace(walks[0], trace=replace(walks[0].trace, gyroscope=gyroscope))
    early = gyroscope.time_s < _inject("magnet", walk, elsewhere).begin_s
    biased, stuck = (_inject(f"gyro_{kind}", walk, elsewhere).walk.trace for kind in ("biased", "stuck"))
    assert np.array_equal(biased.gyroscope.values[early], turning[early])
    assert np.allclose(biased.gyroscope.values[~early] - turning[~early], (0.0, 0.0, 0.2))
    assert np.array_equal(stuck.gyroscope.values[early], turning[early])
    assert np.all(stuck.gyroscope.values[~early] == turning[early][-1])
    assert len(biased.rotation_vector.time_s) == len(stuck.rotation_vector.time_s) == 0
    field = _inject("magnet", walk, elsewhere).walk.trace.magnetometer.values - walk.trace.magnetometer.values
    assert np.all(field[early] == 0.0)
    assert np.linalg.norm(field[~early], axis=1) == pytest.approx(np.full((~early).sum(), 200.0))
