"""Compile the Numba functions of this package before the first request needs them."""

from __future__ import annotations

import numpy as np

from app.wifi.ap_match import ap_match_candidates
from app.wifi.fingerprint import Fingerprint
from app.wifi.kernel_matching import kernel_match
from app.wifi.moving_partition import partition_around
from app.wifi.radio_map import build_radio_map
from app.wifi.soft_match import soft_match
from app.wifi.strongest_wknn import strongest_wknn
from app.wifi.weibull_bayes import weibull_bayes
from app.wifi.wknn import wknn


def warm_up() -> None:
    """Match one scan with every matcher, among all points and among some; under a second from the cache."""
    bssid, rssi_dbm = np.array([1, 2]), np.array([-50.0, -60.0])
    radio_map = build_radio_map([Fingerprint("", 0.0, 0.0, 0.0, "", bssid, rssi_dbm)])
    partition = partition_around(radio_map, 0, 0.0, 0.0, 1.0)
    for points in (None, partition.points, ap_match_candidates(radio_map, bssid, rssi_dbm)):
        wknn(radio_map, bssid, rssi_dbm, points=points)
        soft_match(radio_map, bssid, rssi_dbm, points=points)
        strongest_wknn(radio_map, bssid, rssi_dbm, points=points)
        weibull_bayes(radio_map, bssid, rssi_dbm, points=points)
        kernel_match(radio_map, bssid, rssi_dbm, points=points)
