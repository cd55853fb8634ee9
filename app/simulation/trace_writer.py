"""Recordings as trace files in the open data's format: tab-separated `unix_ms  TYPE  values...`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from app.observations import AxisSamples
from app.simulation.access_points import AccessPoints
from app.simulation.recording import Recording
from app.simulation.wifi_scanner import SimulatedScan
from app.wifi.bssid import format_bssid


def trace_lines(recording: Recording, access_points: AccessPoints, site: str) -> Iterator[str]:
    """The lines of a trace, without line ends, records in order of time. Takes the recording's scans."""
    walk, phone, inertial = recording.walk, recording.phone, recording.inertial
    yield f"#\tstartTime:{_ms(walk.time_s[0])}"
    yield f"#\tSiteID:{site}\tSiteName:{site}\tFloorId:{site}-{walk.floor.floor}\tFloorName:{walk.floor.floor}"
    yield f"#\tBrand:{phone.brand}\tModel:{phone.model}\tAndroidName:8.1.0\tAPILevel:27\t"
    records: list[tuple[int, str]] = []
    for kind, stream in (
        ("TYPE_ACCELEROMETER", inertial.accelerometer),
        ("TYPE_MAGNETIC_FIELD", inertial.magnetometer),
        ("TYPE_GYROSCOPE", inertial.gyroscope),
        ("TYPE_ROTATION_VECTOR", inertial.rotation_vector),
    ):
        records += _sensor_records(kind, stream)
    for time_s, (x, y) in zip(walk.waypoint_time_s, walk.waypoint_xy_m, strict=True):
        records.append((_ms(time_s), f"{_ms(time_s)}\tTYPE_WAYPOINT\t{x:.5f}\t{y:.5f}"))
    for scan in recording.scans:
        records += _scan_records(scan, access_points)
    records.sort(key=lambda record: record[0])
    for _, line in records:
        yield line
    yield f"#\tendTime:{_ms(walk.time_s[-1])}"


def trace_bytes(recording: Recording, access_points: AccessPoints, site: str) -> bytes:
    """A whole trace, not compressed."""
    return "".join(line + "\n" for line in trace_lines(recording, access_points, site)).encode()


def _sensor_records(kind: str, stream: AxisSamples) -> list[tuple[int, str]]:
    times = np.rint(1000 * stream.time_s).astype(np.int64).tolist()
    return [
        (t, f"{t}\t{kind}\t{x:.6g}\t{y:.6g}\t{z:.6g}\t3")
        for t, (x, y, z) in zip(times, stream.values.tolist(), strict=True)
    ]


def _scan_records(scan: SimulatedScan, access_points: AccessPoints) -> list[tuple[int, str]]:
    frequencies = access_points.frequency_mhz[access_points.radio[scan.network]].tolist()
    return [
        (
            scan.time_ms,
            f"{scan.time_ms}\tTYPE_WIFI\t{access_points.ssid[network]}"
            f"\t{format_bssid(access_points.bssid[network])}\t{rssi}\t{frequency}\t{seen}",
        )
        for network, rssi, frequency, seen in zip(
            scan.network.tolist(), scan.rssi_dbm.tolist(), frequencies, scan.seen_ms.tolist(), strict=True
        )
    ]


def _ms(time_s: float) -> int:
    return round(1000 * time_s)
