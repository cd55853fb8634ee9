"""The simulator against recordings: what a positioning method would notice must be alike."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from app.estimation.arrays import FloatArray
from app.simulation.recording import make_world
from app.simulation.site import survey_walks
from app.simulation.trace_writer import trace_bytes
from app.survey.trace import Trace, read_trace
from tests.open_data import open_data

WALKS = 16


def _figures(traces: list[Trace]) -> dict[str, FloatArray]:
    scans = [scan for trace in traces for scan in trace.scans]
    norms = [np.linalg.norm(trace.accelerometer.values, axis=1) for trace in traces]
    ways = [np.linalg.norm(np.diff(trace.waypoint_xy_m, axis=0), axis=1) for trace in traces]
    return {
        "readings": np.array([len(scan.bssid) for scan in scans], dtype=np.float64),
        "rssi": np.concatenate([scan.rssi_dbm for scan in scans]),
        "strongest": np.array([scan.rssi_dbm.max() for scan in scans]),
        "age": np.concatenate([scan.time_s - scan.seen_s for scan in scans]),
        "interval": np.array([b.time_s - a.time_s for trace in traces for a, b in pairwise(trace.scans)]),
        "swing": np.array([norm.std() for norm in norms]),
        "norm": np.concatenate(norms),
        "field": np.concatenate([np.linalg.norm(trace.magnetometer.values, axis=1) for trace in traces]),
        "segment": np.concatenate(ways),
        "speed": np.array([w.sum() / np.ptp(t.waypoint_time_s) for w, t in zip(ways, traces, strict=True)]),
    }


@pytest.fixture(scope="module")
def real() -> dict[str, FloatArray]:
    folder: Path = open_data("mall", "F1", "path_data_files")
    traces = [read_trace(path.read_bytes(), path.name) for path in sorted(folder.iterdir())[: 3 * WALKS : 3]]
    return _figures([trace for trace in traces if len(trace.waypoint_xy_m) > 1])


@pytest.fixture(scope="module")
def simulated() -> dict[str, FloatArray]:
    world = make_world("mall", "mall", 2, seed=1)
    walks = survey_walks(world, world.building.floors[0], WALKS, seed=1, rate_hz=50.0)
    return _figures([read_trace(trace_bytes(walk, world.access_points, "mall"), name) for name, walk in walks])


@pytest.mark.parametrize(
    ("figure", "quantile", "tolerance"),
    [
        ("readings", 0.5, 150.0),
        ("rssi", 0.05, 3.0),
        ("rssi", 0.5, 4.0),
        ("rssi", 0.95, 8.0),
        ("strongest", 0.5, 7.0),
        ("age", 0.5, 1.5),
        ("age", 0.75, 4.0),
        ("interval", 0.5, 0.3),
        ("swing", 0.5, 1.0),
        ("norm", 0.01, 2.0),
        ("norm", 0.99, 4.0),
        ("field", 0.5, 6.0),
        ("segment", 0.5, 2.5),
        ("speed", 0.5, 0.2),
    ],
)
def test_a_simulated_mall_is_like_the_recorded_one(
    real: dict[str, FloatArray], simulated: dict[str, FloatArray], figure: str, quantile: float, tolerance: float
) -> None:
    expected, found = (float(np.quantile(figures[figure], quantile)) for figures in (real, simulated))
    assert found == pytest.approx(expected, abs=tolerance)
