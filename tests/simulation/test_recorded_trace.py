from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.simulation.recorded_trace import trace_of
from app.simulation.recording import World
from app.simulation.trace_writer import trace_bytes
from app.survey.trace import read_trace
from tests.simulation.conftest import recorded

STREAMS = ("accelerometer", "gyroscope", "magnetometer", "rotation_vector")


def test_a_recording_is_the_trace_that_its_file_is_read_as(world: World) -> None:
    straight = trace_of(recorded(world), world.access_points, "walk")
    read = read_trace(trace_bytes(recorded(world), world.access_points, "site"), "walk")
    assert (straight.trace, straight.device) == (read.trace, read.device)
    assert straight.waypoint_time_s.tolist() == read.waypoint_time_s.tolist()
    assert straight.waypoint_xy_m == pytest.approx(read.waypoint_xy_m, abs=1e-5)
    for name in STREAMS:
        one, other = getattr(straight, name), getattr(read, name)
        assert one.time_s == pytest.approx(other.time_s, abs=1e-6)
        assert one.values == pytest.approx(other.values, rel=1e-5, abs=1e-6)
    assert len(straight.scans) == len(read.scans) > 10
    for scan, same in zip(straight.scans, read.scans, strict=True):
        assert scan.time_s == same.time_s
        for field in ("bssid", "rssi_dbm", "seen_s"):
            assert np.array_equal(getattr(scan, field), getattr(same, field))


def test_a_phone_without_a_rotation_vector_records_none(world: World) -> None:
    recording = recorded(world)
    poor = replace(recording, phone=replace(recording.phone, has_rotation_vector=False))
    trace = trace_of(poor, world.access_points, "walk")
    assert len(trace.rotation_vector.time_s) == 0 < len(trace.gyroscope.time_s)
