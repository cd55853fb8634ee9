"""Which reference points a fix looks at: moving partition and AP match against the full search, by size of the map.

Two-stage WiFi/MEMS integration, Micromachines 2019, 10, 198, table 3: 0.28 s against 0.62 s for 155 fixes among
158 points, 2.2 times as fast.
The same WKNN is given all points, those of the partition, or those of the two strongest access points. The paper's full
search goes through every fingerprint; ours touches the lists of the scan's twenty access points only, which is most of
what a partition saves, so it has a row of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import cycle

import numpy as np

from app.estimation.arrays import FloatArray
from app.observations import WifiScan
from app.wifi.fingerprint import Fingerprint
from app.wifi.match import nearest
from app.wifi.match_index import index_of
from app.wifi.moving_signals import SignalSettings, candidates_of, match_among
from app.wifi.partition_search import PartitionSettings, SearchState, place_scan
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.representation import Representation, Shape
from app.wifi.signal_distance import Distance, distances
from app.wifi.strongest_wknn import StrongestSettings
from benchmarks.timing import Row, median_us

SIZES: dict[int, tuple[float | None, float | None]] = {
    158: (None, None),
    1000: (None, None),
    10_000: (1.5, None),
    100_000: (2.5, 1.5),
}
"""Reference points, and how many times faster than the full search the partition and AP match must be."""
GRID_M, RADIUS_M = 1.2, 2.5
"""The paper's."""
APART_M, REACH_M = 10.0, 36.0
"""Between access points, and how far one is heard: about forty a point."""
SCANS = 60


def candidates(seed: int = 4) -> Iterator[Row]:
    """A row for either way of choosing and each size of map, per fix."""
    for points, bounds in SIZES.items():
        rng = np.random.default_rng(seed)
        side = int(np.ceil(np.sqrt(points)))
        at_m = GRID_M * np.stack(np.unravel_index(np.arange(points), (side, side)), axis=1)
        reach_m = GRID_M * side + REACH_M
        radios = np.arange(-REACH_M, reach_m, APART_M)
        radio_m = np.stack(np.meshgrid(radios, radios), axis=-1).reshape(-1, 2)
        radio_m += rng.uniform(-3.0, 3.0, radio_m.shape)
        survey = [_heard(number, place, radio_m, rng) for number, place in enumerate(at_m.tolist())]
        radio_map = build_radio_map(survey, cell_m=0.0)
        yield from _compared(radio_map, _walk(radio_m, GRID_M * side, rng), points, bounds)


def _compared(
    radio_map: RadioMap, scans: list[WifiScan], points: int, bounds: tuple[float | None, float | None]
) -> Iterator[Row]:
    strongest = StrongestSettings()
    moving, full = (
        PartitionSettings(radius_m=RADIUS_M, per_scatter=0.0, strongest=strongest),
        PartitionSettings(moving=False),
    )
    matched = SignalSettings(wknn=strongest)
    index, everything = index_of(radio_map, Representation(Shape.POSITIVE, strongest.missing_dbm)), np.arange(points)

    def by_ap_match(scan: WifiScan) -> None:
        match_among(radio_map, scan, candidates_of(radio_map, scan, matched), matched)

    def by_fingerprint(scan: WifiScan) -> None:
        distance = distances(index, scan.bssid, scan.rssi_dbm, Distance.EUCLIDEAN, everything)
        nearest(distance, index.floor, -1, strongest.neighbours)

    # apart from the others, whose caches it would empty
    (every,) = median_us(_in_turn(scans, by_fingerprint))
    partition, whole, ap_match = median_us(
        _walking(radio_map, scans, moving), _walking(radio_map, scans, full), _in_turn(scans, by_ap_match)
    )
    yield Row(f"fix by full search, {points} points", whole, "every fingerprint, distances only", every)
    yield Row(f"fix by moving partition, {points} points", partition, "full search", whole, bounds[0])
    yield Row(f"fix by AP match, {points} points", ap_match, "full search", whole, bounds[1])


def _walking(radio_map: RadioMap, scans: list[WifiScan], settings: PartitionSettings) -> Callable[[], None]:
    """One fix a call, along the walk and back to its start, where a partition is begun anew."""
    state, turn = SearchState(), cycle(scans)

    def fix() -> None:
        nonlocal state
        scan = next(turn)
        state, match, _ = place_scan(SearchState() if scan is scans[0] else state, radio_map, scan, 0, settings)
        if match is None:
            raise RuntimeError("a scan of the walk has no place")

    return fix


def _in_turn(scans: list[WifiScan], work: Callable[[WifiScan], None]) -> Callable[[], None]:
    turn = cycle(scans)
    return lambda: work(next(turn))


def _walk(radio_m: FloatArray, side_m: float, rng: np.random.Generator) -> list[WifiScan]:
    """A scan a second at 1.2 m/s, to and fro along the middle."""
    scans = []
    for second in range(SCANS):
        x_m = abs((1.2 * second) % (2.0 * side_m) - side_m)
        heard = _heard(second, [x_m, 0.5 * side_m], radio_m, rng)
        scans.append(WifiScan(float(second), heard.bssid, heard.rssi_dbm, np.full(len(heard.bssid), float(second))))
    return scans


def _heard(number: int, at_m: list[float], radio_m: FloatArray, rng: np.random.Generator) -> Fingerprint:
    apart_m = np.hypot(radio_m[:, 0] - at_m[0], radio_m[:, 1] - at_m[1])
    near = np.flatnonzero(apart_m < REACH_M)
    rssi_dbm = -38.0 - 30.0 * np.log10(np.maximum(apart_m[near], 1.0)) + 2.0 * rng.standard_normal(len(near))
    return Fingerprint("F1", at_m[0], at_m[1], float(number), "survey", near.astype(np.int64), rssi_dbm)
