"""Whether a method leaves out the access points that are faulty, and no others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from app.evaluation.faulty_walk import FaultyWalk
from app.evaluation.recordings import RecordedWalk
from app.evaluation.replay import Answer, WalkKey
from app.observations import WifiScan

LOUD_DBM = -75.0
"""From here on an access point weighs in a match; one that is swapped for another at the edge of hearing does not."""
FAULTY_SCANS = 5
"""Loud scans, of the walk as it was or with the fault, from which a faulty access point is to be found."""
SOUND_SCANS = 3
"""Scans from which a sound access point could have been left out by mistake."""


@dataclass(frozen=True, slots=True)
class InPlay:
    """Access points of one walk: the faulty ones that are to be found, and the sound ones that are to stay."""

    faulty: frozenset[int]
    sound: frozenset[int]


@dataclass(frozen=True, slots=True)
class ExclusionCount:
    """faulty, sound : access points, once a walk.  found, wrong : of these that were left out at any time.
    walks_with_wrong : walks with a sound one left out."""

    faulty: int
    found: int
    sound: int
    wrong: int
    walks_with_wrong: int


def in_play(faulty: FaultyWalk, walk: RecordedWalk) -> InPlay:
    """What a walk with a fault offers to find. walk : without the fault."""
    was, now = walk.trace.scans, faulty.walk.trace.scans
    loud = _heard(was, FAULTY_SCANS, LOUD_DBM) | _heard(now, FAULTY_SCANS, LOUD_DBM)
    return InPlay(loud & faulty.access_points, _heard(now, SOUND_SCANS) - faulty.access_points)


def exclusions(answers: Iterable[Answer], playing: Mapping[WalkKey, InPlay]) -> ExclusionCount:
    """Count what was left out in the walks, by fold, floor and name; walks without an entry do not count."""
    out: dict[WalkKey, set[int]] = {key: set() for key in playing}
    for answer in answers:
        key = answer.walk_key
        if key in out:
            out[key] |= answer.excluded
    wrong = [len(out[key] & one.sound) for key, one in playing.items()]
    return ExclusionCount(
        faulty=sum(len(one.faulty) for one in playing.values()),
        found=sum(len(out[key] & one.faulty) for key, one in playing.items()),
        sound=sum(len(one.sound) for one in playing.values()),
        wrong=sum(wrong),
        walks_with_wrong=sum(count > 0 for count in wrong),
    )


def _heard(scans: Sequence[WifiScan], least: int, from_dbm: float = float("-inf")) -> frozenset[int]:
    """Access points that so many scans hold at this level or louder."""
    count = Counter(one for scan in scans for one in scan.bssid[scan.rssi_dbm >= from_dbm].tolist())
    return frozenset(one for one, times in count.items() if times >= least)
