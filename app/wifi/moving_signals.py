"""Matching on the move: weak readings left out, more of them while moving, and candidates by AP match.

Trust Chain Positioning Fusion, Sensors 2015, 15, 29850, section 3.2 (docs/methods/trust_chain.md).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from app.estimation.arrays import IntArray
from app.observations import WifiScan
from app.wifi.ap_match import ap_match_candidates
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap
from app.wifi.readings import at_least, strongest
from app.wifi.strongest_wknn import StrongestSettings, strongest_wknn


@dataclass(frozen=True, slots=True)
class SignalSettings:
    """still_dbm, moving_dbm : weaker readings are left out, the paper's -85 and -75.  least_readings : where fewer are
    left, the strongest so many are taken instead.  ap_match : whether candidates are looked up by their two strongest
    access points.  wknn : of the matching itself; the paper has no limit on the number of access points.
    """

    still_dbm: float = -85.0
    moving_dbm: float = -75.0
    least_readings: int = 5
    ap_match: bool = True
    wknn: StrongestSettings = field(default_factory=lambda: StrongestSettings(count=10_000))


PLAIN = SignalSettings(still_dbm=-200.0, moving_dbm=-200.0, ap_match=False)
"""The classic WKNN that the paper improves on."""


def loud_readings(scan: WifiScan, still: bool, settings: SignalSettings) -> WifiScan:
    """The scan's readings that count. still : whether the phone is."""
    loud = at_least(scan, settings.still_dbm if still else settings.moving_dbm)
    return loud if len(loud.bssid) >= settings.least_readings else strongest(scan, settings.least_readings)


def candidates_of(radio_map: RadioMap, scan: WifiScan, settings: SignalSettings) -> IntArray | None:
    """(m,) ascending reference points to compare a scan with; None: all.

    Differs from the paper: a scan whose strongest access point is strongest nowhere has no candidates, which leaves
    every reference point.
    """
    if not settings.ap_match:
        return None
    points = ap_match_candidates(radio_map, scan.bssid, scan.rssi_dbm)
    return points if len(points) else None


def match_among(
    radio_map: RadioMap, scan: WifiScan, points: IntArray | None, settings: SignalSettings, floor: int | None = None
) -> Match | None:
    """Place of a scan's loud readings among candidates (m,); on a floor where those have none, among all of it."""
    match = strongest_wknn(radio_map, scan.bssid, scan.rssi_dbm, settings.wknn, floor, points)
    if match is not None or points is None:
        return match
    return strongest_wknn(radio_map, scan.bssid, scan.rssi_dbm, settings.wknn, floor)


def on_floor(radio_map: RadioMap, points: IntArray | None, floor: int) -> IntArray:
    """(k,) those of the candidates (m,) that are on a floor; of all points if None."""
    every = np.arange(len(radio_map.floor)) if points is None else points
    kept: IntArray = every[radio_map.floor[every] == floor]
    return kept
