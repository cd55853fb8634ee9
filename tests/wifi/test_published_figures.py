"""The matching code on public sets gives the figures of reference_results.csv."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from app.estimation.arrays import FloatArray
from app.wifi.fingerprint import Fingerprint
from app.wifi.match import nearest
from app.wifi.match_index import index_of
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.representation import POWED, Representation, Shape
from app.wifi.signal_distance import Distance, distances
from tests.wifi.uji import NOT_HEARD, FingerprintSet, uji_library, ujiindoorloc

FILL_104 = Representation(Shape.RAW, zero_dbm=-104.0)
POSITIVE = Representation(Shape.POSITIVE, zero_dbm=-105.0)


@cache
def indoorloc() -> tuple[RadioMap, FingerprintSet, FingerprintSet]:
    train = ujiindoorloc("trainingData")
    return one_point_a_scan(train), train, ujiindoorloc("validationData")


def one_point_a_scan(train: FingerprintSet) -> RadioMap:
    """Point i is scan i, as in the published figures: they do not gather scans of a place. The places here only keep
    that order, since many scans are equally near and the first of them counts."""
    heard = [np.flatnonzero(scan != NOT_HEARD) for scan in train.rssi_dbm]
    return build_radio_map(
        [
            Fingerprint("all", float(number), 0.0, 0.0, "", bssid, train.rssi_dbm[number, bssid])
            for number, bssid in enumerate(heard)
        ],
        cell_m=0.0,
    )


def errors(
    radio_map: RadioMap,
    train: FingerprintSet,
    test: FingerprintSet,
    representation: Representation,
    distance: Distance,
    neighbours: int,
) -> tuple[FloatArray, FloatArray]:
    """Horizontal errors in the set's metres, and whether building and floor are right."""
    index = index_of(radio_map, representation)
    storey, truth = train.building * 10 + train.floor, test.building * 10 + test.floor
    found_m, voted = np.empty_like(test.xy_m), np.empty_like(truth)
    for number, scan in enumerate(test.rssi_dbm):
        bssid = np.flatnonzero(scan != NOT_HEARD)
        apart = distances(index, bssid, scan[bssid], distance)
        best = nearest(apart, index.floor, -1, neighbours)
        weight = 1.0 / np.maximum(apart[best], 1e-6)
        found_m[number] = weight @ train.xy_m[best] / weight.sum()
        voted[number] = np.bincount(storey[best], weight).argmax()
    return np.hypot(*(found_m - test.xy_m).T), (voted == truth).astype(np.float64)


@pytest.mark.parametrize(
    ("representation", "distance", "neighbours", "mean_m", "floor_percent", "tolerance_m"),
    [
        (POSITIVE, Distance.EUCLIDEAN, 1, 9.850, 89.74, 0.005),
        (FILL_104, Distance.EUCLIDEAN, 1, 9.750, 90.01, 0.005),
        (FILL_104, Distance.EUCLIDEAN, 5, 8.794, 90.46, 0.005),
        # in which order ties among duplicate scans are broken is worth 0.04 m here
        (POWED, Distance.SORENSEN, 5, 6.55, 95.14, 0.06),
    ],
    ids=["1-NN positive", "1-NN fill -104", "WKNN 5 fill -104", "5-NN Bray-Curtis powed"],
)
def test_ujiindoorloc(
    representation: Representation,
    distance: Distance,
    neighbours: int,
    mean_m: float,
    floor_percent: float,
    tolerance_m: float,
) -> None:
    error_m, floor_right = errors(*indoorloc(), representation, distance, neighbours)
    assert error_m.mean() == pytest.approx(mean_m, abs=tolerance_m)
    assert 100.0 * floor_right.mean() == pytest.approx(floor_percent, abs=0.01)


@pytest.mark.parametrize(("name", "mean_m"), [("tst01", 2.553), ("tst02", 2.539)])
def test_uji_library_within_its_first_month(name: str, mean_m: float) -> None:
    train = uji_library("trn01")
    error_m, _ = errors(one_point_a_scan(train), train, uji_library(name), FILL_104, Distance.EUCLIDEAN, 5)
    assert error_m.mean() == pytest.approx(mean_m, abs=0.01)
