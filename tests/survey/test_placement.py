from __future__ import annotations

import math

import numpy as np
import pytest

from app.survey.placement import fingerprints_of, walked_places
from app.survey.trace import Trace, read_trace
from app.wifi.beacons import beacon_key
from app.wifi.readings import FRESH_S
from tests.open_data import open_data
from tests.survey.traces import START_MS, UUID, acceleration, beacon, trace, walk, waypoint, wifi

CADENCE_HZ = 1.8


def strides(*stretches: tuple[int, bool]) -> list[str]:
    """Samples of stretches (seconds, whether they are walked), at 50 Hz."""
    records, tick, phase = [], 0, 0.0
    for seconds, walked in stretches:
        for _ in range(50 * seconds):
            phase += 2.0 * math.pi * CADENCE_HZ / 50 if walked else 0.0
            records.append(acceleration(START_MS + 20 * tick, 9.81 + (3.0 * math.sin(phase) if walked else 0.0)))
            tick += 1
    return records


def read(*lines: str) -> Trace:
    return read_trace(trace(*sorted(lines)), "walk.txt")


def times(*seconds: float) -> np.ndarray:
    return START_MS / 1000 + np.array(seconds)


def test_without_an_accelerometer_the_way_is_linear_in_time() -> None:
    walked = read(waypoint(START_MS, 0, 0), waypoint(START_MS + 10_000, 20, 10))
    assert walked_places(walked, times(0, 2.5, 10)) == pytest.approx(np.array([[0, 0], [5, 2.5], [20, 10]]))


def test_outside_the_walk_the_nearest_end_counts() -> None:
    walked = read(waypoint(START_MS, 1, 2), waypoint(START_MS + 1000, 3, 4))
    assert walked_places(walked, times(-5, 99)).tolist() == [[1, 2], [3, 4]]


def test_a_pause_on_the_way_does_not_shift_the_places() -> None:
    # 10 s of walking, 10 s of standing still, 10 s of walking along 30 m
    lines = strides((10, True), (10, False), (10, True))
    walked = read(*lines, waypoint(START_MS, 0, 0), waypoint(START_MS + 30_000, 30, 0))
    x_m = walked_places(walked, times(5, 12, 18, 25))[:, 0]
    assert x_m == pytest.approx([7.5, 15.0, 15.0, 22.5], abs=1.2)  # in time: 5, 12, 18, 25


def test_waypoints_are_met_exactly_and_progress_never_runs_back() -> None:
    walked = read_trace(walk(seconds=40), "a")
    assert walked_places(walked, walked.waypoint_time_s) == pytest.approx(walked.waypoint_xy_m)
    x_m = walked_places(walked, np.linspace(walked.waypoint_time_s[0], walked.waypoint_time_s[-1], 500))[:, 0]
    assert (np.diff(x_m) >= -1e-9).all()


def test_a_reading_that_was_heard_long_before_its_scan_is_left_out() -> None:
    scan_ms = START_MS + 20_000
    ages_ms = {1: 0, 2: int(1000 * FRESH_S), 3: int(1000 * FRESH_S) + 1}
    lines = [wifi(scan_ms, number, -50, scan_ms - age) for number, age in ages_ms.items()]
    found, rejected = fingerprints_of(read(waypoint(START_MS, 0, 0), waypoint(scan_ms, 9, 0), *lines), "F1")
    assert rejected == []
    assert [(one.bssid & 0xFF).tolist() for one in found] == [[1, 2]]


def test_a_reading_from_before_the_first_waypoint_has_no_place() -> None:
    lines = [wifi(START_MS + 1000, 1, -50, START_MS - 1), wifi(START_MS + 1000, 2, -50, START_MS + 1)]
    found, _ = fingerprints_of(read(waypoint(START_MS, 0, 0), waypoint(START_MS + 2000, 9, 0), *lines), "F1")
    assert [(one.bssid & 0xFF).tolist() for one in found] == [[2]]


def test_beacons_make_fingerprints_of_their_own_where_the_surveyor_was_while_they_were_heard() -> None:
    heard = [beacon(START_MS + at, minor, rssi) for at, minor, rssi in ((4000, 1, -60), (4500, 1, -70), (6000, 2, -80))]
    lines = (waypoint(START_MS, 0, 0), waypoint(START_MS + 10_000, 20, 0), wifi(START_MS + 5000, 1, -50))
    (by_wifi, by_beacons), rejected = fingerprints_of(read(*lines, *heard), "F1")
    assert rejected == [] and len(by_wifi.bssid) == 1
    assert by_beacons.x_m == pytest.approx(10.0)
    assert (by_beacons.y_m, by_beacons.walk) == (0.0, "walk")
    levels = dict(zip(by_beacons.bssid.tolist(), by_beacons.rssi_dbm.tolist(), strict=True))
    assert levels == {beacon_key(f"{UUID}:7:1"): -65.0, beacon_key(f"{UUID}:7:2"): -80.0}


def test_a_walk_that_heard_beacons_alone_is_no_walk_without_scans() -> None:
    lines = (waypoint(START_MS, 0, 0), waypoint(START_MS + 10_000, 20, 0))
    assert fingerprints_of(read(*lines), "F1")[1][0].reason.startswith("no scan")
    found, rejected = fingerprints_of(read(*lines, beacon(START_MS + 5000, 1, -60)), "F1")
    assert len(found) == 1 and rejected == []


def test_scans_before_the_first_and_after_the_last_waypoint_have_no_place() -> None:
    scans = [wifi(START_MS + at, 1, -50) for at in (-1000, 1000, 3000)]
    found, _ = fingerprints_of(read(waypoint(START_MS, 0, 0), waypoint(START_MS + 2000, 9, 0), *scans), "F1")
    assert [one.time_s for one in found] == [(START_MS + 1000) / 1000]
    assert (found[0].floor, found[0].walk) == ("F1", "walk")


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ((waypoint(START_MS, 0, 0), wifi(START_MS, 1, -50)), "fewer than two waypoints"),
        ((wifi(START_MS, 1, -50),), "fewer than two waypoints"),
        ((waypoint(START_MS, 0, 0), waypoint(START_MS + 1, 0, 0)), "no scan"),
    ],
)
def test_a_walk_that_gives_nothing_says_why(lines: tuple[str, ...], reason: str) -> None:
    found, rejected = fingerprints_of(read(*lines), "F1")
    assert found == []
    assert [one.item for one in rejected] == ["walk"] and reason in rejected[0].reason


def test_recorded_walks_are_predicted_better_by_steps_than_by_time() -> None:
    """Every second waypoint hidden: the way between the others tells where the surveyor stood."""
    folder = open_data("mall", "F1", "path_data_files")
    by_steps, by_time = [], []
    for path in sorted(folder.iterdir())[:30]:
        with path.open("rb") as stream:
            recorded = read_trace(stream, path.name)
        if len(recorded.waypoint_time_s) < 5:
            continue
        ends = np.array([0, len(recorded.waypoint_time_s) - 1])
        way_m = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(recorded.waypoint_xy_m, axis=0).T))])
        straight = Trace(
            trace=recorded.trace,
            device=recorded.device,
            waypoint_time_s=recorded.waypoint_time_s[ends],
            waypoint_xy_m=np.column_stack([way_m[ends], [0.0, 0.0]]),
            accelerometer=recorded.accelerometer,
            gyroscope=recorded.gyroscope,
            magnetometer=recorded.magnetometer,
            rotation_vector=recorded.rotation_vector,
            scans=(),
        )
        hidden_s = recorded.waypoint_time_s[1:-1]
        by_steps.append(np.abs(walked_places(straight, hidden_s)[:, 0] - way_m[1:-1]).mean())
        by_time.append(np.abs(np.interp(hidden_s, straight.waypoint_time_s, way_m[ends]) - way_m[1:-1]).mean())
    assert len(by_steps) >= 15
    assert np.mean(by_steps) < 0.95 * np.mean(by_time)


def test_a_sample_of_another_year_does_not_shift_the_walk_nor_take_memory() -> None:
    lines = [*strides((12, True)), waypoint(START_MS, 0.0, 0.0), waypoint(START_MS + 12_000, 12.0, 0.0)]
    stray = "0000000000001\tTYPE_ACCELEROMETER\t0.0\t0.0\t9.8\t3"
    at_s = times(3.0, 6.0, 9.0)
    assert walked_places(read(*lines, stray), at_s) == pytest.approx(walked_places(read(*lines), at_s), abs=0.3)
