"""WiFi and Bluetooth scans of a batch body. Real phones list useless readings: those are dropped and counted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from app.api.batch_columns import times_s
from app.observations import BluetoothScan, WifiScan
from app.survey.admission import LONGEST_BEACON_ID, RSSI_RANGE_DBM
from app.wifi.bssid import parse_bssid

LONGEST_BSSID = 17


def wifi_scans(
    times_ms: Sequence[float], scans: Sequence[Sequence[Mapping[str, Any]]]
) -> tuple[tuple[WifiScan, ...], int]:
    """Scans in order of time, and how many readings were dropped.

    A reading is dropped if its RSSI is outside [-127, 20] dBm or its BSSID cannot be parsed. Of an access point that
    occurs twice the greatest `seen` counts, ties the stronger. A `seen` that is missing, no time or after the scan is
    the scan's time.

    Raises
    ------
    InvalidInput : the scans' times run backwards or are out of bounds; names the scan.
    """
    if not times_ms:
        return (), 0
    made, dropped = [], 0
    for time_ms, time_s, readings in zip(times_ms, times_s("wifi", times_ms, "[{}].t").tolist(), scans, strict=True):
        scan, lost = wifi_scan(time_ms, time_s, readings)
        made.append(scan)
        dropped += lost
    return tuple(made), dropped


def wifi_scan(time_ms: float, time_s: float, readings: Sequence[Mapping[str, Any]]) -> tuple[WifiScan, int]:
    """One scan from its readings, and how many of them were dropped; wifi_scans says which."""
    low, high = RSSI_RANGE_DBM
    best: dict[int, tuple[float, float]] = {}
    dropped = 0
    for reading in readings:
        bssid, rssi = _bssid_of(reading.get("bssid")), reading["rssi"]
        if bssid is None or not low <= rssi <= high:
            dropped += 1
            continue
        seen = reading.get("seen")
        heard = (seen if seen is not None and seen > 0.0 else time_ms, rssi)
        known = best.get(bssid)
        if known is None or heard > known:
            best[bssid] = heard
    table = np.array(list(best.values()), dtype=np.float64).reshape(-1, 2)
    return (
        WifiScan(
            time_s=time_s,
            bssid=np.fromiter(best, dtype=np.int64, count=len(best)),
            rssi_dbm=table[:, 1].copy(),
            seen_s=np.minimum(table[:, 0], time_ms) / 1000.0,
        ),
        dropped,
    )


def _bssid_of(sent: object) -> int | None:
    if not isinstance(sent, str) or len(sent) > LONGEST_BSSID:
        return None
    try:
        return parse_bssid(sent)
    except ValueError:
        return None


def bluetooth_scans(
    times_ms: Sequence[float], scans: Sequence[Sequence[Mapping[str, Any]]]
) -> tuple[tuple[BluetoothScan, ...], int]:
    """Scans in order of time, and how many readings were dropped: RSSI outside [-127, 20] dBm, or no usable identifier.

    Raises as wifi_scans does.
    """
    if not times_ms:
        return (), 0
    low, high = RSSI_RANGE_DBM
    made, dropped = [], 0
    for time_s, readings in zip(times_s("bluetooth", times_ms, "[{}].t").tolist(), scans, strict=True):
        usable = [r for r in readings if low <= r["rssi"] <= high and _is_beacon_id(r.get("id"))]
        dropped += len(readings) - len(usable)
        made.append(
            BluetoothScan(
                time_s=time_s,
                beacon=tuple(r["id"] for r in usable),
                rssi_dbm=np.array([r["rssi"] for r in usable], dtype=np.float64),
            )
        )
    return tuple(made), dropped


def _is_beacon_id(sent: object) -> bool:
    return isinstance(sent, str) and 0 < len(sent) <= LONGEST_BEACON_ID
