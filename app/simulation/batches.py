"""A recording as the phone sends it: one batch body a second, as POST .../batches takes it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from app.observations import AxisSamples, PressureSamples
from app.simulation.access_points import AccessPoints
from app.simulation.recording import Recording
from app.simulation.wifi_scanner import SimulatedScan
from app.wifi.bssid import format_bssid


def batch_bodies(recording: Recording, access_points: AccessPoints, seconds: float = 1.0) -> Iterator[dict[str, Any]]:
    """The batches of a walk in order, from sequence 0. Takes the recording's scans as it goes.

    Each body's `end` is the phone's time up to which it reports, Unix ms.
    """
    inertial, walk = recording.inertial, recording.walk
    streams = {
        "accelerometer": inertial.accelerometer,
        "gyroscope": inertial.gyroscope,
        "magnetometer": inertial.magnetometer,
    }
    if recording.phone.has_rotation_vector:
        streams["rotation_vector"] = inertial.rotation_vector
    scan = next(recording.scans, None)
    ends = np.arange(walk.time_s[0] + seconds, walk.time_s[-1], seconds)
    for sequence, end_s in enumerate(ends.tolist()):
        end_ms = round(1000 * end_s)
        body: dict[str, Any] = {"sequence": sequence, "end": end_ms}
        for name, stream in streams.items():
            body[name] = _columns(stream, end_s - seconds, end_s)
        if len(recording.barometer.time_s):
            body["barometer"] = _pressures(recording.barometer, end_s - seconds, end_s)
        wifi = []
        while scan is not None and scan.time_ms <= end_ms:
            wifi.append({"t": scan.time_ms, "readings": _readings(scan, access_points)})
            scan = next(recording.scans, None)
        if wifi:
            body["wifi"] = wifi
        yield body


def _columns(stream: AxisSamples, after_s: float, until_s: float) -> dict[str, list[float]]:
    first, last = np.searchsorted(stream.time_s, [after_s, until_s], side="right")
    times = np.rint(1000 * stream.time_s[first:last]).astype(np.int64).tolist()
    x, y, z = np.round(stream.values[first:last], 5).T.tolist()
    return {"t": times, "x": x, "y": y, "z": z}


def _pressures(stream: PressureSamples, after_s: float, until_s: float) -> dict[str, list[float]]:
    first, last = np.searchsorted(stream.time_s, [after_s, until_s], side="right")
    times = np.rint(1000 * stream.time_s[first:last]).astype(np.int64).tolist()
    return {"t": times, "pressure": np.round(stream.pressure_hpa[first:last], 4).tolist()}


def _readings(scan: SimulatedScan, access_points: AccessPoints) -> list[dict[str, Any]]:
    addresses = [format_bssid(bssid) for bssid in access_points.bssid[scan.network].tolist()]
    frequencies = access_points.frequency_mhz[access_points.radio[scan.network]].tolist()
    return [
        {"bssid": bssid, "rssi": rssi, "frequency": frequency, "seen": seen}
        for bssid, rssi, frequency, seen in zip(
            addresses, scan.rssi_dbm.tolist(), frequencies, scan.seen_ms.tolist(), strict=True
        )
    ]
