"""From a surveyor's walk to fingerprints: every scan at the place where the surveyor was when it came.

Scans of Bluetooth beacons make fingerprints of their own, at the place of the middle of what was heard together.

Between two waypoints the walker is placed on the straight line by steps walked, scaled so that they meet both ends; so
pauses and hurry do not shift the map. Readings that the phone repeats from further back than FRESH_S belong to earlier
places and are left out. docs/decisions/0002-placing-survey-readings.md has the measurements behind each choice.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from app.estimation.arrays import FloatArray
from app.observations import Batch
from app.pdr.tracker import advance_pdr, initial_pdr_state
from app.survey.rejection import Rejection
from app.survey.trace import Trace
from app.wifi.beacons import LISTENING_S, beacon_key, heard_beacons
from app.wifi.fingerprint import Fingerprint
from app.wifi.readings import FRESH_S

FEWEST_STEPS = 3
"""With fewer between two waypoints their rhythm is unknown; the walk is then taken as linear in time."""


def fingerprints_of(trace: Trace, floor: str) -> tuple[list[Fingerprint], list[Rejection]]:
    """One fingerprint a scan between the first and the last waypoint of a walk, or the reason why there is none."""
    if len(trace.waypoint_time_s) < 2:
        return [], [Rejection(trace.trace, "fewer than two waypoints: its scans have no place")]
    first_s, last_s = trace.waypoint_time_s[0], trace.waypoint_time_s[-1]
    scans = [scan for scan in trace.scans if first_s <= scan.time_s <= last_s]
    of_beacons = [scan for scan in trace.bluetooth if first_s <= scan.time_s <= last_s]
    scanned_s = [scan.time_s for scan in scans]
    listened_s = [max(scan.time_s - LISTENING_S / 2.0, first_s) for scan in of_beacons]
    places = walked_places(trace, np.array(scanned_s + listened_s))
    fingerprints = []
    for scan, (x_m, y_m) in zip(scans, places[: len(scans)], strict=True):
        fresh = scan.seen_s >= max(scan.time_s - FRESH_S, first_s)
        if fresh.any():
            fingerprints.append(
                Fingerprint(
                    floor=floor,
                    x_m=float(x_m),
                    y_m=float(y_m),
                    time_s=scan.time_s,
                    walk=trace.trace,
                    bssid=scan.bssid[fresh],
                    rssi_dbm=scan.rssi_dbm[fresh],
                )
            )
    for heard, (x_m, y_m) in zip(of_beacons, places[len(scans) :], strict=True):
        key, rssi_dbm = heard_beacons(np.array([beacon_key(one) for one in heard.beacon], np.int64), heard.rssi_dbm)
        fingerprints.append(Fingerprint(floor, float(x_m), float(y_m), heard.time_s, trace.trace, key, rssi_dbm))
    if not fingerprints:
        return [], [Rejection(trace.trace, "no scan between the first and the last waypoint")]
    return fingerprints, []


def walked_places(trace: Trace, time_s: FloatArray) -> FloatArray:
    """Where the walker was.

    Parameters
    ----------
    trace : of at least one waypoint.
    time_s : (n,); outside the walk the nearest end counts.

    Returns
    -------
    (n, 2) metres in the floor's frame.
    """
    knot_s, knot_waypoint = _progress(trace.waypoint_time_s, _step_times(trace))
    along = np.interp(time_s, knot_s, knot_waypoint)
    waypoint = np.arange(len(trace.waypoint_time_s))
    return np.column_stack([np.interp(along, waypoint, axis) for axis in trace.waypoint_xy_m.T])


def _step_times(trace: Trace) -> FloatArray:
    whole_walk = Batch(
        sequence=0,
        end_s=None,
        accelerometer=trace.accelerometer,
        gyroscope=trace.gyroscope,
        magnetometer=trace.magnetometer,
        rotation_vector=trace.rotation_vector,
    )
    _, movement = advance_pdr(initial_pdr_state(), whole_walk)
    return np.array([step.time_s for step in movement.steps])


def _progress(waypoint_s: FloatArray, step_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Knots of the walk's progress: times, and how many waypoints lie behind, with fractions."""
    times, waypoints = [waypoint_s[:1]], [np.zeros(1)]
    for k, (begin_s, end_s) in enumerate(pairwise(waypoint_s)):
        inside_s = step_s[(step_s > begin_s) & (step_s < end_s)]
        if len(inside_s) >= FEWEST_STEPS:
            period_s = float(np.median(np.diff(inside_s)))
            off_s = max(begin_s, inside_s[0] - period_s)
            halt_s = min(end_s, inside_s[-1] + period_s)
            steps = np.arange(len(inside_s) + 2, dtype=np.float64)
            steps[0] = 1.0 - (inside_s[0] - off_s) / period_s  # the leg may begin and end within a step
            steps[-1] = len(inside_s) + (halt_s - inside_s[-1]) / period_s
            times.append(np.concatenate([[off_s], inside_s, [halt_s]]))
            waypoints.append(k + (steps - steps[0]) / (steps[-1] - steps[0]))
        times.append(np.array([end_s]))
        waypoints.append(np.array([k + 1.0]))
    return np.concatenate(times), np.concatenate(waypoints)
