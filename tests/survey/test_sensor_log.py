from __future__ import annotations

import io

import pytest

from app.floorplan.georeference import Georeference
from app.survey.rejection import Rejections
from app.survey.sensor_log import UNKNOWN_START_MS, is_sensor_log, stretches_of, write_traces
from app.survey.trace import Trace, read_trace
from app.wifi.bssid import format_bssid

FRAME = Georeference(40.0, -3.0, 0.0)
HEAD = [
    "% LogFile created by the 'GetSensorData' App for Android.",
    "% Date of creation: Fri Jun 02 10:26:49 CEST 2017",
]
START_MS = 1496399209000


def posi(time_s: float, x_m: float, y_m: float, floor: int = 0, building: int = 1) -> str:
    latitude, longitude = FRAME.to_wgs84(x_m, y_m)
    return f"POSI;{time_s:.3f};1;{latitude:.9f};{longitude:.9f};{floor};{building}"


LOG = [
    *HEAD,
    posi(1.0, 1, 2),
    "ACCE;1.500;1234.5;0.1;0.2;9.8;3",
    "GYRO;1.510;1234.5;0.01;0.02;0.03;3",
    "MAGN;1.520;1234.5;10;20;30;3",
    "AHRS;1.530;1234.5;1.5;2.5;3.5;0.1;0.2;0.3;3",
    "WIFI;2.000;1234.0;shop;a8:0c:ca:03:9d:d7;-49",
    "WIFI;2.000;1234.1;semi;colon;A8:0C:CA:03:9D:D8;2412;-59",
    "WIFI;2.000;1234.1;;a8:0c:ca:03:9d:d9;5180;-60.0;",
    "PRES;2.1;1234;1013.2;3",
    posi(3.0, 5, 2),
    posi(9.0, 5, 9, floor=1),
    "WIFI;10.000;1234.0;shop;a8:0c:ca:03:9d:d7;-70",
    posi(11.0, 5, 19, floor=1),
]


def converted(lines: list[str]) -> tuple[list[Trace], list[str], Rejections]:
    rejections = Rejections()
    content = [f"{line}\n".encode() for line in lines]
    stretches = stretches_of(content, "log.txt", rejections)
    out = [io.BytesIO() for _ in stretches]
    write_traces(content, stretches, {stretch.floor: FRAME for stretch in stretches}, list(out))
    traces = [read_trace(stream.getvalue(), f"log-{index}.txt") for index, stream in enumerate(out)]
    return traces, [stretch.floor for stretch in stretches], rejections


def test_each_stretch_on_one_floor_is_a_trace() -> None:
    (first, second), floors, rejections = converted(LOG)
    assert floors == ["B1F0", "B1F1"]
    assert rejections.count == first.rejected_count == second.rejected_count == 0
    assert first.waypoint_xy_m == pytest.approx(first.waypoint_xy_m.round()) and first.waypoint_xy_m.tolist()[1][
        0
    ] == pytest.approx(5)
    assert first.waypoint_time_s.tolist() == [START_MS / 1000 + 1, START_MS / 1000 + 3]
    assert second.waypoint_xy_m[:, 1] == pytest.approx([9, 19], abs=1e-3)


def test_sensors_and_scans_are_carried_over_with_any_ssid_and_with_or_without_a_frequency() -> None:
    first = converted(LOG)[0][0]
    assert first.accelerometer.values.tolist() == [[0.1, 0.2, 9.8]]
    assert first.gyroscope.values.tolist() == [[0.01, 0.02, 0.03]]
    assert first.magnetometer.values.tolist() == [[10, 20, 30]]
    assert first.rotation_vector.values.tolist() == [[0.1, 0.2, 0.3]]
    (scan,) = first.scans
    assert {format_bssid(b): r for b, r in zip(scan.bssid, scan.rssi_dbm, strict=True)} == {
        "a8:0c:ca:03:9d:d7": -49,
        "a8:0c:ca:03:9d:d8": -59,
        "a8:0c:ca:03:9d:d9": -60,
    }


def test_a_log_without_a_date_begins_at_a_fixed_moment() -> None:
    traces, _, _ = converted(LOG[2:])
    assert traces[0].waypoint_time_s[0] == UNKNOWN_START_MS / 1000 + 1


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("POSI;2.5;1;0.0;0.0;0;0", "not filled in"),
        ("POSI;2.5;1;x;0.0;0;0", "could not convert"),
        ("POSI;2.5;1", "too few cells"),
        ("POSI;2.5;1;40;3;inf;0", "infinity"),
        ("POSI;nan;1;40;3;0;0", "time in seconds"),
        ("POSI;2.5;1;91;3;0;0", "latitude"),
    ],
)
def test_a_waypoint_that_says_nothing_is_rejected_by_its_line(line: str, reason: str) -> None:
    traces, _, rejections = converted([*LOG[:3], line, *LOG[3:]])
    assert [one.item for one in rejections.listed] == ["log.txt:4"]
    assert reason in rejections.listed[0].reason
    assert len(traces) == 2


def test_a_floor_with_a_single_waypoint_has_no_place_for_its_scans() -> None:
    traces, floors, rejections = converted(LOG[:-1])
    assert floors == ["B1F0"] and len(traces) == 1
    assert "a single POSI on B1F1" in rejections.listed[0].reason


def test_damaged_lines_are_passed_over() -> None:
    damaged = ["WIFI;2.0", "WIFI;x;1;a;b;c", "ACCE;2.0;1;a;b;c;3", "ACCE;1.6;1;1;2", "ACCE", "\x00\xff", ""]
    assert len(converted([*LOG[:4], *damaged, *LOG[4:]])[0]) == 2


def test_the_content_tells_a_log() -> None:
    assert is_sensor_log("\n".join(HEAD).encode()) and is_sensor_log(b"ACCE;1;2;3;4;5;3\n")
    assert not is_sensor_log(b"floor,x,y,t,bssid,rssi\n")
