"""What phones send in a load test: batches of one second, recorded or made up, ready as JSON but for the sequence."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import orjson

from app.errors import InvalidInput
from app.observations import AxisSamples, WifiScan
from app.survey.trace import Trace, read_traces
from app.wifi.bssid import format_bssid

START_MS = 1_700_000_000_000
RATE_HZ = 100
SCAN_READINGS = 40
SCAN_EVERY_S = 2
STREAMS = ("accelerometer", "gyroscope", "magnetometer", "rotation_vector")


def recorded_walks(folder: Path, most: int) -> list[list[bytes]]:
    """The batches of up to `most` traces under a folder, in the order of their names.

    Raises
    ------
    InvalidInput : there is no trace.
    """
    walks: list[list[bytes]] = []
    for path in sorted(folder.rglob("*.txt*")):
        with path.open("rb") as stream:
            walks += [batches for trace in read_traces(stream, path.name) if (batches := trace_batches(trace))]
        if len(walks) >= most:
            return walks[:most]
    if not walks:
        raise InvalidInput(f"no trace (*.txt, *.txt.xz, ...) under {folder}", "trace_dir")
    return walks


def trace_batches(trace: Trace) -> list[bytes]:
    """A trace second by second, every sample in the batch of its second."""
    streams: dict[str, AxisSamples] = {name: getattr(trace, name) for name in STREAMS}
    starts = [stream.time_s[0] for stream in streams.values() if stream.time_s.size]
    ends = [stream.time_s[-1] for stream in streams.values() if stream.time_s.size]
    if not starts:
        return []
    return _batches(streams, trace.scans, float(min(starts)), float(max(ends)))


def made_up_walk(seed: int, seconds: int) -> list[bytes]:
    """A walk of noise at 100 Hz on three sensors, with a scan of 40 access points every other second.

    It costs a server what a real one costs to read and store; its access points are on no map, so it has no position.
    """
    rng = np.random.default_rng(seed)
    time_s = START_MS / 1000 + np.arange(seconds * RATE_HZ) / RATE_HZ
    middles = {"accelerometer": (0.0, 0.0, 9.81), "gyroscope": (0.0, 0.0, 0.0), "magnetometer": (20.0, 0.0, -40.0)}
    streams = {
        name: AxisSamples(time_s, np.round(rng.normal(middle, 1.0, (len(time_s), 3)), 4))
        for name, middle in middles.items()
    }
    scans = []
    for second in range(0, seconds, SCAN_EVERY_S):
        at_s = START_MS / 1000 + second + 0.5
        bssid = 0x020000000000 + rng.choice(400, SCAN_READINGS, replace=False)
        rssi = np.round(rng.uniform(-95.0, -40.0, SCAN_READINGS))
        scans.append(WifiScan(at_s, bssid.astype(np.int64), rssi, at_s - rng.uniform(0.0, 2.0, SCAN_READINGS)))
    return _batches(streams, scans, START_MS / 1000, START_MS / 1000 + seconds)


def _batches(streams: dict[str, AxisSamples], scans: Sequence[WifiScan], start_s: float, end_s: float) -> list[bytes]:
    edges = np.arange(start_s, end_s + 1.0, 1.0)
    cuts = {name: np.searchsorted(stream.time_s, edges) for name, stream in streams.items()}
    batches = []
    for k in range(len(edges) - 1):
        body: dict[str, Any] = {}
        for name, stream in streams.items():
            part = slice(cuts[name][k], cuts[name][k + 1])
            if part.stop > part.start:
                x, y, z = stream.values[part].T.tolist()
                body[name] = {"t": _ms(stream.time_s[part]), "x": x, "y": y, "z": z}
        heard = [_scan(scan) for scan in scans if edges[k] <= scan.time_s < edges[k + 1]]
        if heard:
            body["wifi"] = heard
        batches.append(b"," + orjson.dumps(body)[1:] if body else b"}")
    return batches


def _scan(scan: WifiScan) -> dict[str, Any]:
    readings = [
        {"bssid": format_bssid(bssid), "rssi": rssi, "seen": seen}
        for bssid, rssi, seen in zip(scan.bssid.tolist(), scan.rssi_dbm.tolist(), _ms(scan.seen_s), strict=True)
    ]
    return {"t": round(1000 * scan.time_s), "readings": readings}


def _ms(time_s: Iterable[float]) -> list[int]:
    return [round(1000 * one) for one in time_s]


def with_sequence(sequence: int, rest: bytes) -> bytes:
    """A batch's body."""
    return b'{"sequence":%d%b' % (sequence, rest)
