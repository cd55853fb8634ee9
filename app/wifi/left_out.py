"""Scans of a survey placed on a map without their walk: the nearest that a survey has to a phone in use.

Differs from leaving out one walk at a time: walks are left out in groups, so that some maps serve for all scans. A
survey of few walks makes a group of each.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from app.estimation.arrays import BoolArray, FloatArray, IntArray
from app.wifi.fingerprint import Fingerprint
from app.wifi.match import Match
from app.wifi.radio_map import build_radio_map
from app.wifi.soft_match import SoftSettings, soft_match

GROUPS = 8
FEW_WALKS = 12
"""Fewer are left out one by one."""
LARGEST_SAMPLE = 4000
WIFI_MATCH = SoftSettings()


@dataclass(frozen=True, slots=True, eq=False)
class LeftOutScans:
    """Of n scans that were placed, each on its own floor.

    scan : (n,) index of the fingerprint.  walk : (n,) number of its walk; a name on two floors is two walks.
    missed_m : (n, 2) from where the match puts the phone to where it was.
    floor_right : (n,) whether the scan by itself would have chosen its floor.
    signal_distance : (n,) to the best of the map.
    nearest_m : (n,) from where it was taken to the nearest reference point that was left.
    match : n of them.  tried : scans that were to be placed, with those that found no place.
    """

    scan: IntArray
    walk: IntArray
    missed_m: FloatArray
    floor_right: BoolArray
    signal_distance: FloatArray
    nearest_m: FloatArray
    match: tuple[Match, ...]
    tried: IntArray

    @property
    def error_m(self) -> FloatArray:
        """(n,) horizontal."""
        return np.asarray(np.hypot(*self.missed_m.T), np.float64)


def left_out_scans(
    fingerprints: Sequence[Fingerprint],
    matching: SoftSettings = WIFI_MATCH,
    largest_sample: int = LARGEST_SAMPLE,
    floors: Sequence[str] = (),
) -> LeftOutScans:
    """Place the scans of a survey, each without its walk. Of a large survey every so manyth scan is placed.

    Parameters
    ----------
    fingerprints : of one radio.
    floors : of its map, if it has more than the fingerprints name: the matches' floors are counted among them.
    """
    floors = sorted({*floors, *(one.floor for one in fingerprints)})  # also those whose only walk is left out
    walks, walk = np.unique([f"{one.floor} {one.walk}" for one in fingerprints], return_inverse=True)
    walk, few = walk.reshape(-1), len(walks) < FEW_WALKS
    group = walk if few else np.array([zlib.crc32(str(name).encode()) % GROUPS for name in walks], np.int64)[walk]
    every = max(1, -(-len(fingerprints) // largest_sample))
    scans, matches, nearest_m, tried = list[int](), list[Match](), list[float](), list[int]()
    for left_out in range(len(walks) if few else GROUPS):
        chosen = np.flatnonzero(group == left_out)[::every].tolist()
        if not chosen:
            continue
        tried += chosen
        others = [one for one, of in zip(fingerprints, group, strict=True) if of != left_out]
        radio_map = build_radio_map(others, floors=floors)
        trees = {name: cKDTree(radio_map.xy_m[radio_map.floor == at]) for at, name in enumerate(radio_map.floors)}
        for at in chosen:
            one = fingerprints[at]
            match = soft_match(radio_map, one.bssid, one.rssi_dbm, matching, radio_map.floors.index(one.floor))
            if match is not None:
                scans.append(at)
                matches.append(match)
                nearest_m.append(float(trees[one.floor].query((one.x_m, one.y_m))[0]))
    placed = [fingerprints[at] for at in scans]
    true_m = np.array([(one.x_m, one.y_m) for one in placed], np.float64).reshape(-1, 2)
    found_m = np.array([match.xy_m for match in matches], np.float64).reshape(-1, 2)
    return LeftOutScans(
        scan=np.array(scans, np.int64),
        walk=walk[np.array(scans, np.int64)],
        missed_m=true_m - found_m,
        floor_right=np.array([int(match.floor_probability.argmax()) == match.floor for match in matches], np.bool_),
        signal_distance=np.array([match.signal_distance for match in matches], np.float64),
        nearest_m=np.array(nearest_m, np.float64),
        match=tuple(matches),
        tried=np.array(tried, np.int64),
    )
