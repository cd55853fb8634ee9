"""Where one scan was taken, with nothing else to go by."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.observations import Position, WifiScan
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap
from app.wifi.readings import fresh_readings
from app.wifi.wknn import wknn

_BASE_M, _PER_SPREAD, _PER_SIGNAL_DISTANCE_M = 3.0, 0.5, 22.0
"""Of accuracy_of: fitted to the 68 % quantile on recorded walks, docs/decisions/0003-matching.md."""


@dataclass(frozen=True, slots=True)
class ScanPosition:
    """accuracy_m : 68 % radius."""

    position: Position
    accuracy_m: float


def locate_scan(radio_map: RadioMap, scan: WifiScan) -> ScanPosition | None:
    """Floor by vote, place by nearest neighbours; readings that are stale do not count.

    Returns
    -------
    None where the map knows none of the scan's fresh access points.
    """
    fresh = fresh_readings(scan)
    match = wknn(radio_map, fresh.bssid, fresh.rssi_dbm)
    if match is None:
        return None
    x_m, y_m = match.xy_m.tolist()
    return ScanPosition(Position(x_m, y_m, radio_map.floors[match.floor]), accuracy_of(match))


def accuracy_of(match: Match) -> float:
    """68 % radius in metres of a match by wknn with its default settings, from scatter and signal distance."""
    spread_m = math.sqrt(float(match.covariance_m2.trace()))
    return _BASE_M + _PER_SPREAD * spread_m + _PER_SIGNAL_DISTANCE_M * match.signal_distance
