from __future__ import annotations

import json

import numpy as np
import pytest

from app.simulation.batches import batch_bodies
from app.simulation.recording import World
from app.simulation.trace_writer import trace_bytes
from app.survey.trace import read_trace
from tests.simulation.conftest import START_S, recorded


def test_what_a_trace_says_is_read_back(world: World) -> None:
    recording, scans = recorded(world), list(recorded(world).scans)
    trace = read_trace(trace_bytes(recorded(world), world.access_points, "test"), "abc.txt")
    assert trace.rejected_count == 0
    assert (trace.trace, trace.device.brand, trace.device.model) == ("abc", "Simulated", "Surveyor")
    assert trace.waypoint_xy_m == pytest.approx(recording.walk.waypoint_xy_m, abs=1e-4)
    assert trace.waypoint_time_s == pytest.approx(recording.walk.waypoint_time_s, abs=1e-3)
    for stream in ("accelerometer", "gyroscope", "magnetometer", "rotation_vector"):
        written, read = getattr(recording.inertial, stream), getattr(trace, stream)
        assert read.time_s == pytest.approx(written.time_s, abs=1e-3)
        assert read.values == pytest.approx(written.values, rel=1e-4, abs=1e-4)
    assert [scan.time_s for scan in trace.scans] == pytest.approx([scan.time_ms / 1000 for scan in scans])
    networks = [set(world.access_points.bssid[scan.network].tolist()) for scan in scans]
    assert [set(scan.bssid.tolist()) for scan in trace.scans] == networks


def test_batches_hold_every_sample_up_to_their_end_once_and_in_order(world: World) -> None:
    recording = recorded(world)
    bodies = list(batch_bodies(recorded(world), world.access_points))
    assert [body["sequence"] for body in bodies] == list(range(len(bodies)))
    times: list[int] = []
    for before, body in zip([{"end": 1000 * START_S}, *bodies], bodies, strict=False):
        assert body["end"] == before["end"] + 1000
        columns = body["gyroscope"]
        assert {len(column) for column in columns.values()} == {len(columns["t"])}
        assert before["end"] <= columns["t"][0] <= columns["t"][-1] <= body["end"]
        for scan in body.get("wifi", []):
            assert before["end"] < scan["t"] <= body["end"]
            assert all(reading["seen"] < scan["t"] for reading in scan["readings"])
        times += columns["t"]
    expected = np.rint(1000 * recording.inertial.gyroscope.time_s).astype(int)
    assert times == expected[expected <= bodies[-1]["end"]].tolist()
    json.dumps(bodies)


def test_scans_are_sent_as_they_were_taken(world: World) -> None:
    sent = [scan for body in batch_bodies(recorded(world), world.access_points) for scan in body.get("wifi", [])]
    taken = list(recorded(world).scans)[: len(sent)]
    assert [len(scan["readings"]) for scan in sent] == [len(scan.network) for scan in taken]
