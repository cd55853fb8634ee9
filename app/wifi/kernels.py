"""Compile the Numba functions of this package before the first request needs them."""

from __future__ import annotations

import numpy as np

from app.wifi.ap_match import ap_match_candidates
from app.wifi.fingerprint import Fingerprint
from app.wifi.foreign import explained
from app.wifi.kernel_matching import kernel_match
from app.wifi.moving_partition import partition_around
from app.wifi.radio_map import build_radio_map
from app.wifi.signal_distance import NOTHING
from app.wifi.soft_match import SoftSettings, soft_match
from app.wifi.strongest_wknn import strongest_wknn
from app.wifi.weibull_bayes import weibull_bayes
from app.wifi.wknn import wknn


def warm_up() -> None:
    """Match one scan with every matcher, among all points and among some; under a second from the cache.

    Two floors hear the same, and the scan mixes two places, so that what is foreign to either is looked for.
    """
    bssid, rssi_dbm = np.arange(1, 9), np.linspace(-50.0, -57.0, 8)
    here, there = slice(0, 4), slice(4, 8)
    surveyed = [
        Fingerprint(floor, x_m, 0.0, 0.0, "", bssid[heard], rssi_dbm[heard])
        for floor in ("F1", "F2")
        for x_m, heard in ((0.0, here), (100.0, there))
    ]
    radio_map = build_radio_map(surveyed)
    partition = partition_around(radio_map, 0, 0.0, 0.0, 1.0)
    match = soft_match(radio_map, bssid[here], rssi_dbm[here], unheeded=bssid[there])
    if match is not None:
        explained(radio_map, bssid, rssi_dbm, match, SoftSettings(), None, NOTHING)
    for points in (None, partition.points, ap_match_candidates(radio_map, bssid, rssi_dbm)):
        wknn(radio_map, bssid, rssi_dbm, points=points)
        soft_match(radio_map, bssid, rssi_dbm, points=points)
        strongest_wknn(radio_map, bssid, rssi_dbm, points=points)
        weibull_bayes(radio_map, bssid, rssi_dbm, points=points)
        kernel_match(radio_map, bssid, rssi_dbm, points=points)
