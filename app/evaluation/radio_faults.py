"""Faults of what the phone hears: access points relayed, imitated, moved, gone or silent, another phone, an old map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.evaluation.faulty_walk import FAR_M, Dice, Elsewhere, FaultyWalk, middle_s, with_trace
from app.evaluation.recordings import RecordedWalk
from app.evaluation.truth import places_at
from app.observations import WifiScan
from app.wifi.readings import only

HEARING_DBM = -100.0
"""Weaker than this, nothing is reported."""
_RELAY_NOISE_DB = 1.5
_RELAY_AGE_S = 0.2
_IMITATED_DBM = (-60.0, -45.0)
_UNKNOWN = 0x0A << 40  # locally administered: no recorded access point has such an address


def replay(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice) -> FaultyWalk | None:
    """Scans recorded FAR_M away or more are relayed in their order instead of the phone's own."""

    def live(own: WifiScan, foreign: WifiScan) -> WifiScan:
        return replace(foreign, seen_s=np.full(len(foreign.bssid), own.time_s - _RELAY_AGE_S))

    return _relayed(walk, elsewhere, dice, live, middle_s(walk))


def rogue(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, count: int = 10) -> FaultyWalk | None:
    """The so many strongest access points of a far place are also here, imitated at close range."""

    def imitated(own: WifiScan, foreign: WifiScan) -> WifiScan:
        chosen = np.argsort(-foreign.rssi_dbm, kind="stable")[:count]
        fresh_s = np.full(len(chosen), own.time_s - _RELAY_AGE_S)
        loud = replace(only(foreign, chosen), rssi_dbm=np.full(len(chosen), -40.0), seen_s=fresh_s)
        return _joined(only(own, ~np.isin(own.bssid, loud.bssid)), loud)

    return _relayed(walk, elsewhere, dice, imitated, middle_s(walk))


def moved(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, share: float = 0.3) -> FaultyWalk | None:
    """Some access points stand elsewhere since the survey: they are heard as they are at a place FAR_M away or more."""
    carried = _some(_names((*walk.trace.scans, *elsewhere.scans)), dice, share)

    def there(own: WifiScan, foreign: WifiScan) -> WifiScan:
        stays = only(own, ~np.isin(own.bssid, carried))
        return _joined(stays, only(foreign, np.isin(foreign.bssid, carried)))

    return _with(carried, _relayed(walk, elsewhere, dice, there, float(walk.trace.waypoint_time_s[0])))


def duplicated(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, share: float = 0.2) -> FaultyWalk | None:
    """Some addresses are on the air twice: here, and as at a place FAR_M away or more; the louder one is reported."""
    twice = _some(_names((*walk.trace.scans, *elsewhere.scans)), dice, share)

    def louder(own: WifiScan, foreign: WifiScan) -> WifiScan:
        other = only(foreign, np.isin(foreign.bssid, twice))
        _, in_own, in_other = np.intersect1d(own.bssid, other.bssid, return_indices=True)
        own_wins = own.rssi_dbm[in_own] >= other.rssi_dbm[in_other]
        return _joined(
            only(own, ~np.isin(own.bssid, own.bssid[in_own[~own_wins]])),
            only(other, ~np.isin(other.bssid, other.bssid[in_other[own_wins]])),
        )

    return _with(twice, _relayed(walk, elsewhere, dice, louder, float(walk.trace.waypoint_time_s[0])))


def swapped(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, share: float = 0.2) -> FaultyWalk:
    """Of the access points that the walk hears some have changed places, two and two."""
    pairs = dice.permutation(_some(_names(walk.trace.scans), dice, share))
    pairs = pairs[: len(pairs) // 2 * 2].reshape(2, -1)
    sounds_as = dict(zip(pairs.ravel().tolist(), pairs[::-1].ravel().tolist(), strict=True))

    def exchanged(scan: WifiScan) -> WifiScan:
        return replace(scan, bssid=np.array([sounds_as.get(one, one) for one in scan.bssid.tolist()], np.int64))

    return replace(_throughout(walk, exchanged), access_points=frozenset(sounds_as))


def spoofed(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, share: float = 0.2) -> FaultyWalk:
    """Of the access points that the walk hears some are imitated by what goes along: strong, and as strong anywhere."""
    names = _some(_names(walk.trace.scans), dice, share)
    strength_dbm = dice.uniform(*_IMITATED_DBM, len(names))

    def imitated(scan: WifiScan) -> WifiScan:
        rssi_dbm = np.round(strength_dbm + dice.normal(0.0, _RELAY_NOISE_DB, len(names)))
        loud = WifiScan(scan.time_s, names, rssi_dbm, np.full(len(names), scan.time_s - _RELAY_AGE_S))
        return _joined(only(scan, ~np.isin(scan.bssid, names)), loud)

    return replace(_throughout(walk, imitated), access_points=frozenset(names.tolist()))


def vanished(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, share: float = 0.2) -> FaultyWalk:
    """Of the access points that the walk hears some are gone."""
    gone = _some(_names(walk.trace.scans), dice, share)
    without = _throughout(walk, lambda scan: only(scan, ~np.isin(scan.bssid, gone)))
    return replace(without, access_points=frozenset(gone.tolist()))


def attenuated(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, offset_db: float = -15.0) -> FaultyWalk:
    """Another phone, a bag, a body: every level is shifted, and what falls below hearing is not reported."""
    return _throughout(walk, lambda scan: _heard(scan, scan.rssi_dbm + offset_db))


def thinned(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, share: float = 0.5) -> FaultyWalk:
    """A share of the access points that the walk hears is gone."""
    return vanished(walk, elsewhere, dice, share)


def stale(
    walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, sigma_db: float = 6.0, replaced: float = 0.2
) -> FaultyWalk:
    """The map is months old: each access point is louder or fainter than surveyed, some are others now."""
    names = _names(walk.trace.scans)
    offset_db = np.round(dice.normal(0.0, sigma_db, len(names)))
    new = dice.permutation(len(names)) < replaced * len(names)
    now = np.where(new, _UNKNOWN + np.arange(len(names)), names)

    def aged(scan: WifiScan) -> WifiScan:
        index = np.searchsorted(names, scan.bssid)
        return _heard(replace(scan, bssid=now[index]), scan.rssi_dbm + offset_db[index])

    return _throughout(walk, aged)


def silent(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, seconds: float) -> FaultyWalk:
    """No scan arrives for so long, or to the end of the walk."""
    begin_s, last_s = middle_s(walk), float(walk.trace.waypoint_time_s[-1])
    end_s = min(begin_s + seconds, last_s)
    scans = tuple(scan for scan in walk.trace.scans if not begin_s <= scan.time_s < end_s)
    return FaultyWalk(with_trace(walk, scans=scans), begin_s, end_s)


def repeated(walk: RecordedWalk, elsewhere: Elsewhere, dice: Dice, within_s: float = 3.0) -> FaultyWalk:
    """Every scan arrives a second time, up to within_s later, and those of a batch arrive in any order."""
    first_s, last_s = walk.trace.waypoint_time_s[[0, -1]]
    late = [replace(scan, time_s=scan.time_s + dice.uniform(0.0, within_s)) for scan in walk.trace.scans]
    others = [*walk.trace.scans[1:], *late]
    # the first one stays first: it says from when on the phone has sent a scan
    scans = (*walk.trace.scans[:1], *(others[index] for index in dice.permutation(len(others))))
    return FaultyWalk(with_trace(walk, scans=scans), float(first_s), float(last_s))


def _throughout(walk: RecordedWalk, change: Callable[[WifiScan], WifiScan]) -> FaultyWalk:
    first_s, last_s = walk.trace.waypoint_time_s[[0, -1]]
    return FaultyWalk(with_trace(walk, scans=tuple(map(change, walk.trace.scans))), float(first_s), float(last_s))


def _relayed(
    walk: RecordedWalk,
    elsewhere: Elsewhere,
    dice: Dice,
    mixed: Callable[[WifiScan, WifiScan], WifiScan],
    begin_s: float,
) -> FaultyWalk | None:
    """From begin_s on each scan is mixed with the next of those recorded far away; the fault begins with the first."""
    trace = walk.trace
    offset_m = elsewhere.xy_m - places_at(trace, np.array([begin_s]))
    far = np.flatnonzero(np.hypot(*offset_m.T) > FAR_M)
    own = [scan for scan in trace.scans if scan.time_s >= begin_s]
    if not len(far) or not own:
        return None
    first = int(dice.choice(far))
    scans = [scan for scan in trace.scans if scan.time_s < begin_s]
    for index, scan in enumerate(own):
        foreign = elsewhere.scans[(first + index) % len(elsewhere.scans)]
        rssi_dbm = foreign.rssi_dbm + np.round(dice.normal(0.0, _RELAY_NOISE_DB, len(foreign.rssi_dbm)))
        seen_s = foreign.seen_s + (scan.time_s - foreign.time_s)
        scans.append(mixed(scan, WifiScan(scan.time_s, foreign.bssid, rssi_dbm, seen_s)))
    return FaultyWalk(with_trace(walk, scans=tuple(scans)), own[0].time_s, float(trace.waypoint_time_s[-1]))


def _with(names: IntArray, faulty: FaultyWalk | None) -> FaultyWalk | None:
    return None if faulty is None else replace(faulty, access_points=frozenset(names.tolist()))


def _some(names: IntArray, dice: Dice, share: float) -> IntArray:
    """A share of them, each once, and one at least where there is any."""
    count = max(int(share * len(names)), min(1, len(names)))
    return np.asarray(dice.choice(names, count, replace=False), np.int64)


def _names(scans: Sequence[WifiScan]) -> IntArray:
    return np.unique(np.concatenate([np.empty(0, np.int64), *(scan.bssid for scan in scans)]))


def _heard(scan: WifiScan, rssi_dbm: FloatArray) -> WifiScan:
    return only(replace(scan, rssi_dbm=rssi_dbm), rssi_dbm >= HEARING_DBM)


def _joined(one: WifiScan, other: WifiScan) -> WifiScan:
    fields = (np.concatenate((getattr(one, name), getattr(other, name))) for name in ("bssid", "rssi_dbm", "seen_s"))
    return WifiScan(one.time_s, *fields)
