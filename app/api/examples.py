"""Bodies for the API page to offer: sent one after the other to an empty service they make a venue, survey it and
locate a phone there."""

from __future__ import annotations

from typing import Any

_HEARD_MS = 1_764_000_000_000
_ACCESS_POINTS = ("a8:0c:ca:03:9d:d7", "a8:0c:ca:03:9d:d8", "54:a7:03:b2:2b:e2", "58:69:6c:78:c1:08")


def _readings(*rssi_dbm: int) -> list[dict[str, Any]]:
    return [{"bssid": bssid, "rssi": level} for bssid, level in zip(_ACCESS_POINTS, rssi_dbm, strict=True)]


def _accelerations() -> dict[str, list[float] | list[int]]:
    """A fifth of a second on a table."""
    times = [_HEARD_MS + 800 + 20 * sample for sample in range(10)]
    return {"t": times, "x": [0.0] * 10, "y": [0.0] * 10, "z": [9.81] * 10}


VENUE = {"venue": "museum", "name": "City museum"}
FLOOR = {
    "name": "Ground floor",
    "level": 0,
    "width": 40.0,
    "height": 25.0,
    "georeference": {"latitude": 48.137, "longitude": 11.575, "rotation": 0.0},
    "plan": None,
}
SURVEY = {
    "floor": "F1",
    "device": {"brand": "OPPO", "model": "PBCM10"},
    "fingerprints": [
        {"x": 5.0, "y": 10.0, "t": _HEARD_MS, "readings": _readings(-48, -50, -70, -80)},
        {"x": 15.0, "y": 10.0, "t": _HEARD_MS + 10_000, "readings": _readings(-60, -62, -60, -66)},
        {"x": 25.0, "y": 10.0, "t": _HEARD_MS + 20_000, "readings": _readings(-72, -74, -50, -52)},
    ],
}
BUILD = {"surveys": [1]}
ACTIVATE = {"version": 1}
SESSION = {
    "venue": "museum",
    "method": "surefix",
    "floor": "F1",
    "device": {"brand": "OPPO", "model": "PBCM10"},
    "alert_limit": 10.0,
    "risk": 0.01,
}
BATCH = {
    "sequence": 0,
    "end": _HEARD_MS + 1_000,
    "accelerometer": _accelerations(),
    "wifi": [{"t": _HEARD_MS + 900, "readings": _readings(-61, -62, -59, -67)}],
}
WATCH = {"bssid": _ACCESS_POINTS[3], "reason": "it will be replaced on Monday"}
WEBHOOK = {"url": "https://alerts.example.org/surefix"}
_NETWORKS = [
    {"macAddress": bssid, "signalStrength": level}
    for bssid, level in zip(_ACCESS_POINTS, (-61, -62, -59, -67), strict=True)
]
GEOLOCATE = {"wifiAccessPoints": _NETWORKS}
GEOSUBMIT = {
    "items": [
        {
            "timestamp": _HEARD_MS,
            "position": {"latitude": 48.1371, "longitude": 11.5752, "accuracy": 5.0},
            "wifiAccessPoints": _NETWORKS,
        }
    ]
}
