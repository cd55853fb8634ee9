"""What every matcher answers: the place of one scan, how sure, and from which reference points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numba
import numpy as np

from app.estimation.arrays import FloatArray, IntArray, within
from app.wifi.match_index import MatchIndex
from app.wifi.radio_map import Int32Array


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Place of one scan.

    floor : index into the map's floors.  floor_probability : (f,) from the neighbours on all floors, sums to 1.
    xy_m : (2,) weighted mean of the neighbours on that floor.  covariance_m2 : (2, 2) their weighted scatter about it;
    0 of one neighbour, so whoever fuses it adds what a lone neighbour leaves open.
    points : (k,) neighbours, best first.  distance : (k,) of each, in the matcher's unit.  weight : (k,) sums to 1.
    known : access points of the scan that the map knows.
    unlike : signal distance to the best point of any floor; 0 of a matcher other than soft_match.
    separation_m2 : mean square, in each direction, of how far the place moves when a group of access points is left
    out, as the jackknife counts it; 0 of a matcher that does not try.
    few_known : access points with which chance is half of the strangeness.
    parted_m : (2,) from the place to the mean of those without a group.
    outward_m : (2,) to the place from the middle of what was surveyed around it: short within the survey, long at its
    edge; 0 of a matcher that does not look.
    """

    floor: int
    floor_probability: FloatArray
    xy_m: FloatArray
    covariance_m2: FloatArray
    points: IntArray
    distance: FloatArray
    weight: FloatArray
    known: int
    unlike: float = 0.0
    separation_m2: float = 0.0
    few_known: float = 0.0
    parted_m: FloatArray = field(default_factory=lambda: np.zeros(2))
    outward_m: FloatArray = field(default_factory=lambda: np.zeros(2))

    @property
    def signal_distance(self) -> float:
        """To the best neighbour: large where the scan is unlike anything surveyed."""
        return float(self.distance[0])

    @property
    def strangeness(self) -> float:
        """Square of the signal distance; less of a scan of few access points, which is unlike everything by chance."""
        return self.signal_distance**2 * self.known / (self.known + self.few_known)

    def alike(self, share: float) -> IntArray:
        """The neighbours of at least this share of the best one's weight."""
        alike: IntArray = self.points[self.weight >= share * self.weight.max()]
        return alike


def matched(
    index: MatchIndex,
    points: IntArray,
    distance: FloatArray,
    weight: FloatArray,
    floor_probability: FloatArray,
    known: int,
) -> Match:
    """A Match of neighbours on one floor. weight : (k,) not all 0, of any sum."""
    weight = weight / weight.sum()
    xy_m = index.xy_m[points]
    centre_m = weight @ xy_m
    apart_m = xy_m - centre_m
    return Match(
        floor=int(index.floor[points[0]]),
        floor_probability=floor_probability,
        xy_m=centre_m,
        covariance_m2=(weight[:, np.newaxis] * apart_m).T @ apart_m,
        points=points,
        distance=distance,
        weight=weight,
        known=known,
    )


def matched_nearest(
    index: MatchIndex,
    distance: FloatArray,
    points: IntArray | None,
    floor: int | None,
    neighbours: int,
    weight_of: Callable[[FloatArray], FloatArray],
    known: int,
) -> Match | None:
    """A Match of the nearest points, on the floor that the nearest on all floors vote for.

    Parameters
    ----------
    distance : (p,) or, of points (m,) alone, (m,); those that are not finite are never taken.
    floor : the floor to match on instead.  neighbours : for place and floor vote alike.
    weight_of : weights of distances, both (k,), the smallest first.  known : as of the Match.

    Returns
    -------
    None where no distance, or none on that floor, is finite.
    """
    floors = index.floor if points is None else index.floor[points]
    around = nearest(distance, floors, -1, neighbours)
    if len(around) == 0:
        return None
    votes = floor_votes(index, around if points is None else points[around], weight_of(distance[around]))
    wanted = int(votes.argmax()) if floor is None else floor
    chosen = around if set(floors[around].tolist()) == {wanted} else nearest(distance, floors, wanted, neighbours)
    if len(chosen) == 0:
        return None
    chosen_points = chosen if points is None else points[chosen]
    return matched(index, chosen_points, distance[chosen], weight_of(distance[chosen]), votes, known)


def floor_votes(index: MatchIndex, points: IntArray, weight: FloatArray) -> FloatArray:
    """(f,) share of the weight of neighbours that each floor has."""
    votes = np.bincount(index.floor[points], weight, minlength=len(index.floors))
    return np.asarray(votes / votes.sum(), np.float64)


def known_access_points(index: MatchIndex, bssid: IntArray) -> int:
    """How many of a scan's access points the map knows."""
    return int(np.count_nonzero(within(bssid, index.bssid)))


@numba.njit(cache=True, nogil=True)
def nearest(distance: FloatArray, floor: Int32Array, wanted: int, count: int) -> IntArray:
    """Where the smallest distances are.

    Parameters
    ----------
    distance, floor : (n,).  wanted : only of this floor, -1 for any.

    Returns
    -------
    (k,) positions, k at most count, smallest first, ties in order. Distances that are not finite are never taken.
    """
    best = np.empty(count, np.int64)
    found = 0
    for p in range(len(distance)):
        if (wanted >= 0 and floor[p] != wanted) or not np.isfinite(distance[p]):
            continue
        if found == count and distance[p] >= distance[best[found - 1]]:
            continue
        at = found if found < count else count - 1
        while at > 0 and distance[p] < distance[best[at - 1]]:
            best[at] = best[at - 1]
            at -= 1
        best[at] = p
        found = min(found + 1, count)
    return best[:found].copy()
