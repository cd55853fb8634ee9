"""How far votes for a floor can be trusted in this very building, learnt from its survey with whole walks left out.

Votes of successive scans err together: what sounds like the floor above goes on doing so for as long as the walker
stays there, and a decision that takes each for a new witness is soon certain of the wrong floor. So the decision is
tried on the survey's own walks, each on a map without it, votes are doubted as much as certainty needs to be earned.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.estimation.arrays import FloatArray
from app.wifi.fingerprint import Fingerprint
from app.wifi.floor_decision import CERTAIN, FloorBelief, FloorSettings, advance_floor
from app.wifi.left_out import LeftOutScans
from app.wifi.radio_map import RadioMap

SECTION = "floor_doubt"
"""Of the radio map: FloorSettings.doubt."""
DOUBTS = (0.1, 0.3, 0.5)
"""The usual one; one with which no first scan is certain; and one with which it takes three."""
WRONG_AT_MOST = 0.01
"""Share of scans after which the decision may be certain of a wrong floor. Left-out walks leave gaps that visitors do
not meet: in simulation where they are 2 to 7 % of scans they are 0 to 2 % of a visitor's, and where 1 % none."""


def floor_settings(radio_map: RadioMap) -> FloorSettings:
    """What was learnt when the map was published; the usual settings for a map that carries nothing."""
    section = radio_map.sections.get(SECTION)
    return FloorSettings() if section is None else FloorSettings(doubt=float(section[0]))


def learnt_doubt(fingerprints: Sequence[Fingerprint], left_out: LeftOutScans, floors: Sequence[str]) -> float:
    """The least doubt of DOUBTS with which certainty was earned on the walks of a survey, or else the greatest.

    Parameters
    ----------
    left_out : its scans on maps without their walk.  floors : of the map.
    """
    if len(floors) == 1 or not len(left_out.scan):
        return DOUBTS[0]
    taken_s = np.array([fingerprints[at].time_s for at in left_out.scan.tolist()])
    order = np.lexsort((taken_s, left_out.walk))
    votes = [left_out.match[at].floor_probability for at in order.tolist()]
    true = [fingerprints[at].floor for at in left_out.scan[order].tolist()]
    walk = left_out.walk[order].tolist()
    for doubt in DOUBTS:
        if _wrongly_certain(votes, true, walk, tuple(floors), FloorSettings(doubt=doubt)) <= WRONG_AT_MOST:
            return doubt
    return DOUBTS[-1]


def _wrongly_certain(
    votes: Sequence[FloatArray], true: Sequence[str], walk: Sequence[int], floors: tuple[str, ...], tried: FloorSettings
) -> float:
    """Share of scans, walk by walk in order of time, after which a wrong floor is certain."""
    belief: FloorBelief | None = None
    wrong = 0
    for at, of_scan in enumerate(votes):
        belief = None if at == 0 or walk[at] != walk[at - 1] else belief
        belief = advance_floor(belief, floors, of_scan, settings=tried)
        wrong += belief.floor != true[at] and belief.certainty >= CERTAIN
    return wrong / len(votes)
