"""Radio map of a venue: what each access point sounded like at each reference point, and how often it was heard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.estimation.arrays import Float32Array, FloatArray, IntArray
from app.wifi.fingerprint import Fingerprint

CELL_M = 1.5
"""Scans of a floor within one square of this side become one reference point. Measured equal to single scans (decision
0002) at a third of the size."""
_SAME_PLACE_M = 0.01
Int32Array = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class RadioMap:
    """Statistics of p reference points and a access points, n pairs of which were heard.

    Pairs are grouped by access point: those of access point i are `start[i]:start[i + 1]`, in the order of points, so
    that a scan touches the access points that it holds and no others.

    Parameters
    ----------
    version : number of the published version, 0 for one never published.
    floors : names in order.
    bssid : (a,) ascending 48-bit addresses, or keys of beacons in a map of those.
    floor : (p,) index into floors.  xy_m : (p, 2) mean place of the point's scans, in its floor's frame.
    scans : (p,) how many scans the point was made of, at least 1.
    start : (a + 1,).  point : (n,).
    count : (n,) scans of the point that heard the access point, at least 1.
    mean_dbm : (n,) over those scans.  variance_db2 : (n,) unbiased, 0 of one scan.
    sections : further arrays that belong to this version, by name (calibration, floor doubt, likeness).
    beacons : the same of the Bluetooth beacons of the venue, with the same floors; None where none were surveyed.
    """

    version: int
    floors: tuple[str, ...]
    bssid: IntArray
    floor: Int32Array
    xy_m: FloatArray
    scans: Int32Array
    start: IntArray
    point: Int32Array
    count: Int32Array
    mean_dbm: Float32Array
    variance_db2: Float32Array
    sections: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    beacons: RadioMap | None = None

    @property
    def share_heard(self) -> Float32Array:
        """(n,) share of the point's scans that heard the access point, in (0, 1]."""
        return (self.count / self.scans[self.point]).astype(np.float32)

    @property
    def access_point(self) -> Int32Array:
        """(n,) index into bssid of each pair."""
        return np.repeat(np.arange(len(self.bssid), dtype=np.int32), np.diff(self.start))


def build_radio_map(
    fingerprints: Sequence[Fingerprint], version: int = 0, cell_m: float = CELL_M, floors: Sequence[str] = ()
) -> RadioMap:
    """Gather fingerprints into reference points and describe each access point there.

    Fingerprints of one place (to a centimetre) are one reference point; the others are gathered in squares of cell_m.
    The order of the fingerprints does not matter.

    Parameters
    ----------
    fingerprints : none make an empty map.
    cell_m : side of a square; 0 leaves every fingerprint a point of its own, also those of one place.
    floors : that the map has even if none of the fingerprints is of them.
    """
    ordered = sorted(fingerprints, key=lambda one: (one.floor, one.x_m, one.y_m, one.time_s, one.walk))
    names = tuple(sorted({*floors, *(one.floor for one in ordered)}))
    number = {name: index for index, name in enumerate(names)}
    floor = np.array([number[one.floor] for one in ordered], dtype=np.int64)
    xy_m = np.array([(one.x_m, one.y_m) for one in ordered], dtype=np.float64).reshape(-1, 2)
    first, point_of = _gather(floor, xy_m, cell_m)
    scans = np.bincount(point_of, minlength=len(first)).astype(np.int32)
    mean_xy_m = np.column_stack([np.bincount(point_of, axis, minlength=len(first)) / scans for axis in xy_m.T])

    heard = [len(one.bssid) for one in ordered]
    bssid, access_point = np.unique(_joined([one.bssid for one in ordered], np.int64), return_inverse=True)
    rssi_dbm = _joined([one.rssi_dbm for one in ordered], np.float64)
    pair, of_pair = np.unique(access_point * len(first) + np.repeat(point_of, heard), return_inverse=True)
    count = np.bincount(of_pair, minlength=len(pair))
    mean_dbm = np.bincount(of_pair, rssi_dbm, minlength=len(pair)) / count
    square_db2 = np.bincount(of_pair, (rssi_dbm - mean_dbm[of_pair]) ** 2, minlength=len(pair))
    variance_db2 = (square_db2 / np.maximum(count - 1, 1)).astype(np.float32)
    return RadioMap(
        version=version,
        floors=names,
        bssid=bssid,
        floor=floor[first].astype(np.int32),
        xy_m=mean_xy_m,
        scans=scans,
        start=np.searchsorted(pair, np.arange(len(bssid) + 1) * max(len(first), 1)),
        point=(pair % max(len(first), 1)).astype(np.int32),
        count=count.astype(np.int32),
        mean_dbm=mean_dbm.astype(np.float32),
        variance_db2=variance_db2,
    )


def _gather(floor: IntArray, xy_m: FloatArray, cell_m: float) -> tuple[IntArray, IntArray]:
    """First fingerprint of each reference point, and the reference point of each fingerprint."""
    if cell_m <= 0.0:
        every = np.arange(len(floor))
        return every, every
    place = np.column_stack([floor, np.rint(xy_m / _SAME_PLACE_M).astype(np.int64)])
    _, which, times = np.unique(place, axis=0, return_inverse=True, return_counts=True)
    single = times[which.reshape(-1)] == 1
    cell = np.column_stack([floor, np.floor(xy_m / cell_m).astype(np.int64)])
    key = np.column_stack([single, np.where(single[:, np.newaxis], cell, place)])
    _, first, point_of = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return first, point_of.reshape(-1)


def _joined(parts: list[NDArray[Any]], kind: type[np.generic]) -> NDArray[Any]:
    return np.concatenate(parts).astype(kind) if parts else np.empty(0, kind)
