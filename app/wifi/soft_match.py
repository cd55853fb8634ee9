"""Soft nearest neighbours over a smoothed radio map: every reference point counts, the more the liker the scan is.

A reference point was made of one or two scans and shares their luck. Smoothing takes the mean of what is surveyed
within a few metres, weighted by nearness, so that a point stands for its surroundings; and the softmax of the
distances, unlike a fixed number of neighbours, lets a scan that many places resemble spread over all of them: the
scatter is then what the scan leaves open. docs/decisions/0005-soft-matching.md has the measurements.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.wifi.match import Match, floor_votes, known_access_points, matched, nearest
from app.wifi.match_index import GROUPS, MatchIndex, index_of
from app.wifi.radio_map import RadioMap
from app.wifi.representation import SQUARED, Representation
from app.wifi.separation import cosine_distances, grouped_products, separated
from app.wifi.signal_distance import NOTHING, Distance, distances

_FLOOR_SHARPNESS = 8.0
_SURROUNDINGS_M = 8.0
"""Standard deviation of the weight that surveyed places have in the middle of those around: 5 and 10 m predict errors
worse."""


@dataclass(frozen=True, slots=True)
class SoftSettings:
    """Measured on folds 1-4 of the mall walks.

    representation, distance : how levels are compared.
    smooth_m : standard deviation of the weight that surveyed places around a point have in it.
    softness : signal distance by which a point's weight falls to 1/e.
    voters : points that vote for the floor.
    neighbours : points that count, the best first; the others' weight is next to nothing.
    separated : place the scan without each group of access points as well (app/wifi/separation.py; by cosines only),
    and see whether the place is at the edge of the survey.
    few_known : as of the Match. 25 and 50 predict errors worse, 200 as well.
    """

    representation: Representation = SQUARED
    smooth_m: float = 3.0
    softness: float = 0.006
    voters: int = 5
    neighbours: int = 200
    distance: Distance = Distance.COSINE
    separated: bool = True
    few_known: float = 100.0


def soft_match(
    radio_map: RadioMap,
    bssid: IntArray,
    rssi_dbm: FloatArray,
    settings: SoftSettings = SoftSettings(),
    floor: int | None = None,
    points: IntArray | None = None,
    unheeded: IntArray = NOTHING,
) -> Match | None:
    """Match one scan.

    Missing access points: see app/wifi/signal_distance.py.

    Parameters
    ----------
    bssid, rssi_dbm : (n,) the scan, each access point once.
    floor : index of the floor to place it on; by default the likeliest.
    points : (m,) the only reference points to look at.
    unheeded : (u,) access points that the map is read without; the scan holds none of them.

    Returns
    -------
    None where the map knows no access point of the scan, or no candidate shares one.
    """
    index = index_of(radio_map, settings.representation, settings.smooth_m)
    known = known_access_points(index, bssid)
    if known == 0:
        return None
    products = grouped_products(index, bssid, rssi_dbm, unheeded) if settings.separated and points is None else None
    if products is None:
        distance = distances(index, bssid, rssi_dbm, settings.distance, points, unheeded)
    else:
        distance = cosine_distances(products)
    distance[distance >= 1.0] = np.inf  # shares nothing
    floors = index.floor if points is None else index.floor[points]
    if not np.isfinite(distance).any():
        return None
    if products is None or len(index.floors) == 1:
        around = nearest(distance, floors, -1, settings.voters)
        votes = floor_votes(
            index, around if points is None else points[around], 1.0 / np.maximum(distance[around], 1e-6)
        )
    else:
        by_level = distances(index, bssid, rssi_dbm, Distance.SORENSEN, unheeded=unheeded)
        votes = _floor_likelihood(index, distance, by_level)
    wanted = int(votes.argmax()) if floor is None else floor
    chosen = np.flatnonzero((floors == wanted) & np.isfinite(distance))
    if len(chosen) == 0:
        return None
    if len(chosen) > settings.neighbours:
        chosen = chosen[np.argpartition(distance[chosen], settings.neighbours)[: settings.neighbours]]
    chosen = chosen[np.argsort(distance[chosen], kind="stable")]
    weight = np.exp((distance[chosen[0]] - distance[chosen]) / settings.softness)
    neighbours = chosen if points is None else points[chosen]
    match = matched(index, neighbours, distance[chosen], weight, votes, known)
    match = replace(match, few_known=settings.few_known, unlike=float(distance.min()))
    if products is None:
        return match
    places_m = separated(products, index, match.floor, settings.softness, match.xy_m)
    return replace(
        match,
        parted_m=places_m.mean(axis=0) - match.xy_m,
        separation_m2=float(((places_m - match.xy_m) ** 2).sum()) / 2.0 * (GROUPS - 1) / GROUPS,
        outward_m=match.xy_m - _surveyed_around(index, match.floor, match.xy_m),
    )


def _floor_likelihood(index: MatchIndex, by_shape: FloatArray, by_level: FloatArray) -> FloatArray:
    """(f,) how likely the scan is of each floor, from the cosine and the Sorensen distance to its best point: a ceiling
    weakens all access points alike, which the cosine does not see."""
    best = np.ones((2, len(index.floors)))
    for distance, nearest_by_floor in zip((by_shape, by_level), best, strict=True):
        np.minimum.at(nearest_by_floor, index.floor, np.clip(distance, 1e-6, 1.0))
    likely = best.min(axis=1).prod() / best.prod(axis=0)
    return np.asarray(likely**_FLOOR_SHARPNESS / (likely**_FLOOR_SHARPNESS).sum(), np.float64)


def _surveyed_around(index: MatchIndex, floor: int, xy_m: FloatArray) -> FloatArray:
    """(2,) the middle of what was surveyed around a place (2,)."""
    places_m = index.xy_m[index.floor == floor]
    east_m, north_m = (places_m - xy_m).T
    apart_m2 = east_m * east_m + north_m * north_m
    weight = np.exp(-0.5 * (apart_m2 - apart_m2.min()) / _SURROUNDINGS_M**2)
    return np.asarray(weight @ places_m / weight.sum(), np.float64)
