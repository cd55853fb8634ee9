from __future__ import annotations

import gzip
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.errors import InvalidInput
from app.observations import AxisSamples
from app.survey.trace import LARGEST_VALUE, LONGEST_LINE, MOST_STRAY_LINES, Trace, read_trace
from app.wifi.bssid import format_bssid
from tests.survey.traces import BRAND, START_MS, UUID, acceleration, beacon, mac, trace, walk, waypoint, wifi


def heard(read: Trace) -> list[dict[str, tuple[float, float]]]:
    """Per scan the RSSI and the age in seconds of every access point."""
    return [
        {
            format_bssid(int(bssid)): (float(rssi), round(scan.time_s - float(seen), 3))
            for bssid, rssi, seen in zip(scan.bssid, scan.rssi_dbm, scan.seen_s, strict=True)
        }
        for scan in read.scans
    ]


def test_a_trace_is_named_by_its_file_and_says_what_phone_recorded_it() -> None:
    read = read_trace(walk(), "folder/5dd9e7aa.txt.xz")
    assert (read.trace, read.device.brand, read.device.model) == ("5dd9e7aa", BRAND, "PBCM10")
    assert read.rejected_count == 0


def test_waypoints_come_in_the_order_of_time() -> None:
    read = read_trace(trace(waypoint(START_MS + 500, 3, 4), waypoint(START_MS, 1, 2)), "a")
    assert read.waypoint_time_s.tolist() == [START_MS / 1000, (START_MS + 500) / 1000]
    assert read.waypoint_xy_m.tolist() == [[1, 2], [3, 4]]


def test_lines_of_one_time_are_one_scan() -> None:
    lines = (wifi(START_MS, 1, -40, START_MS - 700), wifi(START_MS, 2, -50), wifi(START_MS + 1, 1, -60))
    assert heard(read_trace(trace(*lines), "a")) == [
        {mac(1): (-40, 0.7), mac(2): (-50, 0.0)},
        {mac(1): (-60, 0.0)},
    ]


@pytest.mark.parametrize(
    ("first", "second", "counts"),
    [((-40, 900), (-70, 100), (-70, 0.1)), ((-40, 300), (-70, 300), (-40, 0.3)), ((-70, 300), (-40, 300), (-40, 0.3))],
)
def test_of_an_access_point_that_occurs_twice_the_last_seen_counts_and_of_ties_the_stronger(
    first: tuple[float, int], second: tuple[float, int], counts: tuple[float, float]
) -> None:
    lines = [wifi(START_MS, 1, rssi, START_MS - age) for rssi, age in (first, second)]
    assert heard(read_trace(trace(*lines), "a")) == [{mac(1): counts}]


def test_beacons_heard_within_two_seconds_are_one_scan_delivered_with_the_last() -> None:
    lines = [beacon(START_MS + at, minor, -60 - minor) for at, minor in ((0, 1), (1999, 2), (700, 1), (2001, 3))]
    first, second = read_trace(trace(*lines), "a").bluetooth
    assert (first.time_s, second.time_s) == ((START_MS + 1999) / 1000, (START_MS + 2001) / 1000)
    assert first.beacon == (f"{UUID}:7:1".lower(), f"{UUID}:7:1".lower(), f"{UUID}:7:2".lower())
    assert first.rssi_dbm.tolist() == [-61, -61, -62]
    assert second.rssi_dbm.tolist() == [-63]


def test_beacons_that_nobody_numbered_are_told_apart_by_their_address() -> None:
    lines = [beacon(START_MS, 0, -60, 0, address) for address in ("E0:78:A3:3D:B5:D6", "E0:78:A3:3D:B6:55")]
    (scan,) = read_trace(trace(*lines), "a").bluetooth
    assert scan.beacon == tuple(f"{UUID}:0:0:{end}".lower() for end in ("e0:78:a3:3d:b5:d6", "e0:78:a3:3d:b6:55"))


@given(st.lists(st.tuples(st.integers(0, 20_000), st.integers(1, 9), st.integers(-100, -40)), max_size=40))
def test_every_reading_of_a_beacon_is_in_one_scan_and_scans_do_not_overlap(heard: list[tuple[int, int, int]]) -> None:
    lines = [beacon(START_MS + at, minor, rssi) for at, minor, rssi in heard]
    scans = read_trace(trace(waypoint(START_MS, 0, 0), *lines), "a").bluetooth
    told = [(one, rssi) for scan in scans for one, rssi in zip(scan.beacon, scan.rssi_dbm.tolist(), strict=True)]
    assert sorted(told) == sorted((f"{UUID}:7:{minor}".lower(), rssi) for _, minor, rssi in heard)
    assert all(scan.time_s < later.time_s for scan, later in pairwise(scans))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ((6, "-300"), "rssi"),
        ((6, "loud"), "float"),
        ((5, "nan"), "transmit power"),
        ((3, "x"), "uuid, major and minor"),
        ((2, ""), "uuid, major and minor"),
        ((0, "-157455949500"), "Unix milliseconds"),
    ],
)
def test_a_record_that_is_no_reading_of_a_beacon_is_rejected_with_its_reason(
    change: tuple[int, str], reason: str
) -> None:
    cells = beacon(START_MS, 1, -60).split("\t")
    cells[change[0]] = change[1]
    read = read_trace(trace(beacon(START_MS, 2, -60), "\t".join(cells)), "a")
    assert [len(scan.beacon) for scan in read.bluetooth] == [1]
    assert read.rejected_count == 1 and reason in read.rejected[0].reason


def test_a_beacon_record_that_is_cut_short_is_rejected() -> None:
    read = read_trace(trace(beacon(START_MS, 2, -60).rsplit("\t", 4)[0], waypoint(START_MS, 0, 0)), "a")
    assert read.bluetooth == () and read.rejected[0].reason == "TYPE_BEACON: too few cells"


def test_a_phone_that_does_not_say_when_or_runs_ahead_heard_it_with_the_scan() -> None:
    read = read_trace(trace(wifi(START_MS, 1, -40, 0), wifi(START_MS, 2, -40, START_MS + 99)), "a")
    assert heard(read) == [{mac(1): (-40, 0.0), mac(2): (-40, 0.0)}]


@pytest.mark.parametrize("ssid", ["", "tab\tin it", "\t\t\t", "TYPE_WIFI", "日本", "#hash", "x" * 300])
def test_an_ssid_may_hold_anything(ssid: str) -> None:
    assert heard(read_trace(trace(wifi(START_MS, 1, -40, ssid=ssid)), "a")) == [{mac(1): (-40, 0.0)}]


def test_networks_that_opted_out_leave_no_trace() -> None:
    lines = [wifi(START_MS, 1, -40, ssid=name) for name in ("home_nomap", "tab\thome_nomap")]
    read = read_trace(trace(*lines, wifi(START_MS, 2, -41, ssid="_nomap not at its end")), "a")
    assert heard(read) == [{mac(2): (-41, 0.0)}]
    assert read.rejected_count == 0


RECORDS = [
    acceleration(START_MS, 9.8),
    wifi(START_MS + 5, 1, -40),
    waypoint(START_MS + 9, 1, 2),
    f"{START_MS + 10}\tTYPE_GYROSCOPE_UNCALIBRATED\t1\t2\t3\t4\t5\t6\t3",
    wifi(START_MS + 5, 2, -50, ssid="a\tb"),
    acceleration(START_MS + 20, 9.9),
]


@given(st.permutations(RECORDS), st.lists(st.booleans(), min_size=len(RECORDS), max_size=len(RECORDS)))
def test_records_that_lost_their_newline_are_split(records: list[str], lost: list[bool]) -> None:
    text = "".join(record + ("" if gone else "\n") for record, gone in zip(records, lost, strict=True))
    read, whole = read_trace(text.encode(), "a"), read_trace("\n".join(records).encode(), "a")
    assert read.rejected_count == 0
    assert heard(read) == heard(whole) == [{mac(1): (-40, 0.0), mac(2): (-50, 0.0)}]
    assert read.accelerometer.values.tolist() == whole.accelerometer.values.tolist()
    assert len(read.accelerometer.time_s) == 2
    assert read.waypoint_xy_m.tolist() == [[1, 2]]


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("garbage", "not a record"),
        (f"{START_MS}\tTYPE_WAYPOINT\t1", "too few cells"),
        (f"{START_MS}\tTYPE_WAYPOINT\tnan\t2", "finite"),
        (f"{START_MS}\tTYPE_WAYPOINT\tx\t2", "could not convert"),
        (f"{START_MS}\tTYPE_ACCELEROMETER\t1\t2", "too few cells"),
        (f"{START_MS}\tTYPE_ACCELEROMETER\t1\t2\tinf\t3", "finite"),
        (f"{START_MS}\tTYPE_ACCELEROMETER\t1\t2\ta\t3", "could not convert"),
        ("-5\tTYPE_ACCELEROMETER\t1\t2\t3\t3", "Unix milliseconds"),
        ("x\tTYPE_ACCELEROMETER\t1\t2\t3\t3", "invalid literal"),
        (wifi(START_MS, 1, -200), "outside [-127, 20]"),
        (wifi(START_MS, 1, float("nan")), "outside [-127, 20]"),
        (wifi(START_MS, 1, -50).replace("02:00", "zz:00"), "not a MAC address"),
        (f"{START_MS}\tTYPE_WIFI\tshop", "too few cells"),
    ],
)
def test_a_record_that_cannot_be_read_is_rejected_by_its_line_and_the_rest_stands(line: str, reason: str) -> None:
    read = read_trace(trace(waypoint(START_MS, 1, 2), line, acceleration(START_MS, 9.8)), "a.txt")
    assert [one.item for one in read.rejected] == ["a.txt:4"]
    assert reason in read.rejected[0].reason
    assert len(read.waypoint_time_s) == len(read.accelerometer.time_s) == 1


def test_a_second_place_at_the_time_of_a_waypoint_is_rejected() -> None:
    read = read_trace(trace(waypoint(START_MS, 1, 2), waypoint(START_MS, 1, 2), waypoint(START_MS, 9, 2)), "a")
    assert read.waypoint_xy_m.tolist() == [[1, 2]]
    assert [one.item for one in read.rejected] == ["a:5"]


def test_a_long_log_that_lost_every_newline_is_read_but_for_the_records_at_the_cuts() -> None:
    content = "".join(acceleration(START_MS + 20 * tick, 9.8) for tick in range(60_000)).encode()
    read = read_trace(content, "a")
    cuts = len(content) // LONGEST_LINE
    assert cuts >= 2
    assert 60_000 - len(read.accelerometer.time_s) <= cuts
    assert read.rejected_count <= 2 * cuts


@pytest.mark.parametrize("content", [b"", b"\n\n", b"\x00\xff" * 500, b"floor,x,y\n1,2,3\n", b"#\tonly:headers\n"])
def test_a_file_without_any_record_is_no_trace(content: bytes) -> None:
    with pytest.raises(InvalidInput, match="not a trace"):
        read_trace(content, "a.txt")


TIMES = st.integers(0, 2000)
VALUES = st.floats(-LARGEST_VALUE, LARGEST_VALUE).filter(lambda value: abs(value) < LARGEST_VALUE / 3)


@given(st.lists(st.tuples(TIMES, VALUES, VALUES, VALUES), max_size=30))
def test_samples_come_in_the_order_of_time_whatever_order_they_were_written_in(
    rows: list[tuple[int, float, float, float]],
) -> None:
    lines = [f"{START_MS + t}\tTYPE_GYROSCOPE\t{x!r}\t{y!r}\t{z!r}\t3" for t, x, y, z in rows]
    read: AxisSamples = read_trace(trace(waypoint(START_MS, 0, 0), *lines), "a").gyroscope
    ordered = sorted(rows, key=lambda row: row[0])
    assert read.time_s.tolist() == [(START_MS + row[0]) / 1000 for row in ordered]
    assert read.values.tolist() == [list(row[1:]) for row in ordered]


@settings(deadline=None)
@given(st.binary(max_size=400), st.integers(1, 2000))
def test_no_damage_in_the_middle_of_a_trace_stops_the_reading(damage: bytes, at: int) -> None:
    content = walk(seconds=2)
    read = read_trace(content[:at] + damage + content[at:], "a")
    assert len(read.accelerometer.time_s) > 20
    assert np.isfinite(read.accelerometer.values).all()
    assert all(np.isfinite(scan.rssi_dbm).all() and (scan.seen_s <= scan.time_s).all() for scan in read.scans)


def test_a_file_of_next_to_nothing_but_other_lines_is_refused_before_it_costs_time() -> None:
    few = trace(waypoint(START_MS, 1.0, 1.0)) + b"\n" * (MOST_STRAY_LINES - 2)
    assert len(read_trace(few, "walk.txt").waypoint_time_s) == 1
    with pytest.raises(InvalidInput, match="no record"):
        read_trace(gzip.compress(few + b"\n"), "walk.txt.gz")
