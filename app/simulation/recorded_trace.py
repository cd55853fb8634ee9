"""A recording as the trace that its file would be read as, without writing and reading one."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from app.observations import AxisSamples, WifiScan
from app.simulation.access_points import AccessPoints
from app.simulation.recording import Recording
from app.simulation.wifi_scanner import SimulatedScan
from app.survey.trace import Device, Trace


def trace_of(recording: Recording, access_points: AccessPoints, name: str) -> Trace:
    """The trace of a recording. Takes its scans. A phone without rotation vector has an empty one.

    Differs from the file: values are not rounded to six digits.
    """
    walk, phone, inertial = recording.walk, recording.phone, recording.inertial
    return Trace(
        trace=name,
        device=Device(phone.brand, phone.model),
        waypoint_time_s=np.rint(1000.0 * walk.waypoint_time_s) / 1000.0,
        waypoint_xy_m=walk.waypoint_xy_m,
        accelerometer=inertial.accelerometer,
        gyroscope=inertial.gyroscope,
        magnetometer=inertial.magnetometer,
        rotation_vector=inertial.rotation_vector if phone.has_rotation_vector else AxisSamples(),
        scans=_scans(recording.scans, access_points),
    )


def _scans(scans: Iterable[SimulatedScan], access_points: AccessPoints) -> tuple[WifiScan, ...]:
    return tuple(_scan(scan, access_points) for scan in scans)


def _scan(scan: SimulatedScan, access_points: AccessPoints) -> WifiScan:
    """Of an access point that occurs twice the last `seen` counts, of equal ones the stronger."""
    bssid = access_points.bssid[scan.network]
    order = np.lexsort((scan.rssi_dbm, scan.seen_ms, bssid))
    last = order[np.append(np.diff(bssid[order]) != 0, True)]
    return WifiScan(
        time_s=scan.time_ms / 1000.0,
        bssid=bssid[last],
        rssi_dbm=scan.rssi_dbm[last].astype(np.float64),
        seen_s=np.minimum(scan.seen_ms[last], scan.time_ms) / 1000.0,
    )
