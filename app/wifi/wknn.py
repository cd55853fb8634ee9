"""Weighted nearest neighbours: the mean of the places whose fingerprints are most like the scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.wifi.match import Match, known_access_points, matched_nearest
from app.wifi.match_index import index_of
from app.wifi.radio_map import RadioMap
from app.wifi.representation import POWED, Representation
from app.wifi.signal_distance import Distance, distances

_LEAST_DISTANCE = 1e-6
"""Keeps the weight of a perfect match finite."""


@dataclass(frozen=True, slots=True)
class WknnSettings:
    """Defaults as measured in docs/decisions/0003-matching.md. neighbours : for place and floor vote alike."""

    representation: Representation = POWED
    distance: Distance = Distance.COSINE
    neighbours: int = 5


def wknn(
    radio_map: RadioMap,
    bssid: IntArray,
    rssi_dbm: FloatArray,
    settings: WknnSettings = WknnSettings(),
    floor: int | None = None,
    points: IntArray | None = None,
) -> Match | None:
    """Match one scan: neighbours weigh 1 / distance.

    Missing access points: see app/wifi/signal_distance.py.

    Parameters
    ----------
    bssid, rssi_dbm : (n,) the scan, each access point once.
    floor : index of the floor to place it on; by default the one that the neighbours on all floors vote for.
    points : (m,) the only reference points to look at.

    Returns
    -------
    None where the map knows no access point of the scan, or no candidate shares one.
    """
    index = index_of(radio_map, settings.representation)
    known = known_access_points(index, bssid)
    if known == 0:
        return None
    distance = distances(index, bssid, rssi_dbm, settings.distance, points)
    if settings.distance is not Distance.EUCLIDEAN:
        distance[distance >= 1.0] = np.inf  # shares nothing
    return matched_nearest(index, distance, points, floor, settings.neighbours, _weight, known)


def _weight(distance: FloatArray) -> FloatArray:
    return 1.0 / np.maximum(distance, _LEAST_DISTANCE)
