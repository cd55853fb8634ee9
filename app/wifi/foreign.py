"""Access points of a scan that nobody heard where the rest of it was taken.

Matching by levels follows what is loud: a few access points that were moved, or an imitator's, carry a scan off to
where they were surveyed. But most of what the phone hears there is then foreign: heard now, and by no survey scan
around. Which access points are heard, loud or faint, names the place that explains most of them; what is foreign there
is left out, and the rest is matched by its levels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from app.estimation.arrays import BoolArray, FloatArray, IntArray, position_of
from app.wifi.match import Match
from app.wifi.match_index import MatchIndex, index_of
from app.wifi.radio_map import Int32Array, RadioMap
from app.wifi.soft_match import SoftSettings, soft_match


@dataclass(frozen=True, slots=True)
class ForeignSettings:
    """Measured on fold 1 of the mall walks and in simulated buildings, with and without faults.

    around_m : how far from a place its surroundings reach.
    share, least : foreign access points, as a share of those that the map knows and in number, above which a place is
    doubted. Of clean mall scans 1 in 50 is, and of those placed 25 m off by faulty access points 19 in 20.
    softness : of the match of sets, by which the weight of a point falls to 1/e.
    most : share of the scan's known access points that must be left.  many : from which the others may be right.
    """

    around_m: float = 8.0
    share: float = 0.2
    least: int = 4
    softness: float = 0.02
    most: float = 0.6
    many: float = 0.2


FOREIGN = ForeignSettings()


@dataclass(frozen=True, slots=True, eq=False)
class Explained:
    """A scan without what is foreign to its place.

    match : by what is left.  kept : (n,) readings of the scan that count.  foreign : (f,) addresses left out.
    otherwise_m : (2,) where those were heard together, if they are many: then the scan may be of there.
    """

    match: Match
    kept: BoolArray
    foreign: IntArray
    otherwise_m: FloatArray | None = None


def explained(
    radio_map: RadioMap,
    bssid: IntArray,
    rssi_dbm: FloatArray,
    match: Match,
    matching: SoftSettings,
    floor: int | None,
    unheeded: IntArray,
    settings: ForeignSettings = FOREIGN,
) -> Explained | None:
    """The match of a scan, or that of its greater part where it mixes places.

    Parameters
    ----------
    bssid, rssi_dbm : (n,) the scan, each access point once.  match : of all of it.
    matching, floor, unheeded : it was matched so, and a part of it will be.

    Returns
    -------
    None where much is foreign to any place: the scan says nothing.
    """
    index = index_of(radio_map, matching.representation, matching.smooth_m)
    alien = foreign(index, bssid, match.floor, match.xy_m, settings.around_m)
    nothing = Explained(match, np.ones(len(bssid), np.bool_), np.empty(0, np.int64))
    if not _doubted(alien, match.known, settings):
        return nothing
    at = _by_presence(index, bssid, -1 if floor is None else floor, settings.softness)
    if at is None:
        return None
    kept = ~foreign(index, bssid, *at, settings.around_m)
    left_out = bssid[~kept]
    part = soft_match(radio_map, bssid[kept], rssi_dbm[kept], matching, floor, unheeded=np.union1d(unheeded, left_out))
    if part is None or part.known < settings.most * match.known:
        return None
    alien = foreign(index, bssid[kept], part.floor, part.xy_m, settings.around_m)
    if _doubted(alien, part.known, settings):
        return None
    rest = None
    if len(left_out) > settings.many * match.known:
        without = np.union1d(unheeded, bssid[kept])
        rest = soft_match(radio_map, left_out, rssi_dbm[~kept], matching, part.floor, unheeded=without)
    if rest is not None and _doubted(
        foreign(index, left_out, rest.floor, rest.xy_m, settings.around_m), rest.known, settings
    ):
        rest = None
    return Explained(part, kept, left_out, None if rest is None else rest.xy_m)


def foreign(index: MatchIndex, bssid: IntArray, floor: int, xy_m: FloatArray, around_m: float) -> BoolArray:
    """(n,) which access points of a scan the map knows, but not from around a place (2,)."""
    return _foreign(
        index.bssid,
        index.row_start,
        index.column,
        index.floor,
        index.xy_m,
        bssid,
        floor,
        float(xy_m[0]),
        float(xy_m[1]),
        around_m,
    )


def _doubted(alien: BoolArray, known: int, settings: ForeignSettings) -> bool:
    count = int(np.count_nonzero(alien))
    return count >= settings.least and count > settings.share * known


def _by_presence(index: MatchIndex, bssid: IntArray, floor: int, softness: float) -> tuple[int, FloatArray] | None:
    """Floor and place (2,) where most of the same access points were heard, by Sorensen's distance of the two sets."""
    distance = _set_distances(index.bssid, index.start, index.point, index.row_start, bssid)
    if floor >= 0:
        distance = np.where(index.floor == floor, distance, 1.0)
    best = int(distance.argmin())
    if distance[best] >= 1.0:
        return None
    weight = np.where(index.floor == index.floor[best], np.exp((distance[best] - distance) / softness), 0.0)
    return int(index.floor[best]), np.asarray(weight @ index.xy_m / weight.sum(), np.float64)


@numba.njit(cache=True, nogil=True)
def _foreign(
    known: IntArray,
    row_start: IntArray,
    column: Int32Array,
    floors: Int32Array,
    places_m: FloatArray,
    bssid: IntArray,
    floor: int,
    x_m: float,
    y_m: float,
    around_m: float,
) -> BoolArray:
    heard = np.zeros(len(known), np.bool_)
    for p in range(len(floors)):
        if floors[p] == floor and (places_m[p, 0] - x_m) ** 2 + (places_m[p, 1] - y_m) ** 2 <= around_m**2:
            for j in range(row_start[p], row_start[p + 1]):
                heard[column[j]] = True
    alien = np.zeros(len(bssid), np.bool_)
    for k in range(len(bssid)):
        i = position_of(bssid[k], known)
        alien[k] = i >= 0 and not heard[i]
    return alien


@numba.njit(cache=True, nogil=True)
def _set_distances(
    known: IntArray, start: IntArray, point: Int32Array, row_start: IntArray, bssid: IntArray
) -> FloatArray:
    """(p,) 1 - 2 |both| / (|point| + |scan|), of the scan's access points that the map knows."""
    both = np.zeros(len(row_start) - 1)
    of_scan = 0
    for k in range(len(bssid)):
        i = position_of(bssid[k], known)
        if i < 0:
            continue
        of_scan += 1
        for j in range(start[i], start[i + 1]):
            both[point[j]] += 1.0
    for p in range(len(both)):
        both[p] = 1.0 - 2.0 * both[p] / max(row_start[p + 1] - row_start[p] + of_scan, 1)
    return both
