"""A phone that hears less than the survey's did: no 5 GHz, half of the access points switched off since.

To a distance over all access points silence is a contradiction. So the session remembers what it has heard of late, and
a scan that is unlike everything surveyed is also held against the map without the access points that this phone never
hears. Where that makes it very much liker, the phone is deaf to them, and they say nothing of the place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.fusion.state_codec import storable
from app.observations import WifiScan
from app.wifi.foreign import explained
from app.wifi.left_out import WIFI_MATCH
from app.wifi.match import Match
from app.wifi.match_index import index_of
from app.wifi.radio_map import RadioMap
from app.wifi.readings import fresh_readings, only
from app.wifi.signal_distance import Distance, distances
from app.wifi.soft_match import soft_match


@dataclass(frozen=True, slots=True)
class HearingSettings:
    """Measured on folds 1 and 2 of the mall walks, with and without half of the access points.

    suspect : signal distance below which nothing is wrong. 9 of 10 clean scans are nearer than 0.2, 9 of 10 of a phone
    that hears half are further than 0.28.
    liker : share that the distance must fall to. Of clean scans it falls to 0.8 in 1 of 10, else to more; of those with
    half of the access points to 0.42 or less in 9 of 10.
    known : share of the scan's access points that the map must know for that to be sure. Of a deaf phone it does, in 19
    of 20 scans 98 in 100; where nobody surveyed all that is heard far from there is missing as well, but much is new.
    remembered : access points at most, the longest unheard are forgotten first.
    """

    suspect: float = 0.2
    liker: float = 0.6
    known: float = 0.9
    remembered: int = 512


@storable
@dataclass(frozen=True, slots=True, eq=False)
class Hearing:
    """bssid : (k,) access points that the session has heard, the newest first."""

    bssid: IntArray = field(default_factory=lambda: np.empty(0, np.int64))


def after(hearing: Hearing, scan: WifiScan, settings: HearingSettings) -> Hearing:
    """The hearing after one more scan."""
    known = np.isin(hearing.bssid, scan.bssid)
    return Hearing(np.concatenate([scan.bssid, hearing.bssid[~known]])[: settings.remembered])


@dataclass(frozen=True, slots=True, eq=False)
class HeardMatch:
    """Where a scan was placed.

    strange : the match that says how unlike the survey the scan is: where the phone may be deaf, or elsewhere, the one
    with everything. Its `unlike` counts, not that of `match`.
    fresh : the readings that count.  unheeded : (u,) access points that the map was read without.
    foreign : (f,) access points of the scan that are left out, because nobody heard them there.
    otherwise_m : (2,) where many of these are at home, if they are many.
    """

    match: Match
    strange: Match
    fresh: WifiScan
    unheeded: IntArray
    foreign: IntArray
    otherwise_m: FloatArray | None = None

    def less_like(self, radio_map: RadioMap, xy_m: FloatArray, within_m: float) -> float:
        """By how much the signal distance to the likest point around a place (2,) on that floor exceeds that to the
        likest of all: how much less the scan sounds like there. Infinite where nothing around was surveyed."""
        apart_m = np.hypot(*(radio_map.xy_m - xy_m).T)
        around = np.flatnonzero((radio_map.floor == self.match.floor) & (apart_m <= within_m))
        if len(around) == 0:
            return math.inf
        index = index_of(radio_map, WIFI_MATCH.representation, WIFI_MATCH.smooth_m)
        bssid, rssi_dbm = self.fresh.bssid, self.fresh.rssi_dbm
        distance = distances(index, bssid, rssi_dbm, Distance.COSINE, around, self.unheeded)
        return float(distance.min()) - self.match.signal_distance


def match_heard(
    radio_map: RadioMap,
    scan: WifiScan,
    hearing: Hearing,
    unheeded: IntArray,
    least_known: int,
    settings: HearingSettings,
    floor: str | None = None,
) -> HeardMatch | None:
    """Place a scan by its fresh readings.

    Parameters
    ----------
    hearing : with this scan.  unheeded : (u,) access points that are not to be relied on; those that the scan holds all
    the same are used.
    least_known : access points known to the map with which a scan is usable.
    floor : name of the floor to place it on; None: the one that it sounds most like.

    Returns
    -------
    None where the scan says too little, or mixes places.
    """
    fresh = fresh_readings(scan)
    unheeded = np.setdiff1d(unheeded, fresh.bssid)
    where = radio_map.floors.index(floor) if floor in radio_map.floors else None
    match = soft_match(radio_map, fresh.bssid, fresh.rssi_dbm, WIFI_MATCH, where, unheeded=unheeded)
    if match is None or match.known < least_known:
        return None
    told = explained(radio_map, fresh.bssid, fresh.rssi_dbm, match, WIFI_MATCH, where, unheeded)
    if told is None:
        return None
    match, fresh, unheeded = told.match, only(fresh, told.kept), np.union1d(unheeded, told.foreign)
    plain = HeardMatch(match, match, fresh, unheeded, told.foreign, told.otherwise_m)
    if match.signal_distance < settings.suspect:
        return plain
    # a scan may hold more than is remembered
    never = np.setdiff1d(radio_map.bssid, np.union1d(hearing.bssid, fresh.bssid), assume_unique=True)
    unheeded = np.union1d(never, unheeded)
    deaf = soft_match(radio_map, fresh.bssid, fresh.rssi_dbm, WIFI_MATCH, where, unheeded=unheeded)
    if deaf is None or deaf.signal_distance > settings.liker * match.signal_distance:
        return plain
    strange = deaf if match.known >= settings.known * len(fresh.bssid) else match
    return HeardMatch(deaf, strange, fresh, unheeded, told.foreign, told.otherwise_m)
