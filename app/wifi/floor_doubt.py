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
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap

SECTION = "floor_doubt"
"""Of the radio map: FloorSettings.doubt and .unlike. Maps of earlier releases hold the first alone."""
TRIED = (
    *(FloorSettings(doubt=doubt) for doubt in (0.1, 0.3, 0.5)),
    *(FloorSettings(unlike=unlike) for unlike in (0.5, 0.4, 0.3, 0.25, 0.2, 0.16, 0.12)),
    FloorSettings(doubt=0.5, unlike=0.12),
)
"""The usual doubt; one with which no first scan is certain; one with which it takes three, where floors sound alike.
Then, where parts of a floor were not surveyed and sound like the floor above, votes of scans that are ever less unlike
the survey: of surveyed places in the mall nine in ten are less so than 0.2."""
WRONG_AT_MOST = 0.01
"""Share of scans after which the decision may be certain of a wrong floor. Left-out walks leave gaps that visitors do
not meet: in simulation where they are 2 to 7 % of scans they are 0 to 2 % of a visitor's, and where 1 % none."""


def floor_settings(radio_map: RadioMap) -> FloorSettings:
    """What was learnt when the map was published; the usual settings for a map that carries nothing."""
    section = radio_map.sections.get(SECTION)
    learnt = {} if section is None else dict(zip(("doubt", "unlike"), section.tolist(), strict=False))
    return FloorSettings(**learnt)


def section_of(learnt: FloorSettings) -> FloatArray:
    """What floor_settings reads."""
    return np.array([learnt.doubt, learnt.unlike])


def learnt_doubt(fingerprints: Sequence[Fingerprint], left_out: LeftOutScans, floors: Sequence[str]) -> FloorSettings:
    """The first of TRIED with which certainty was earned on the walks of a survey, or else the last.

    Parameters
    ----------
    left_out : its scans on maps without their walk.  floors : of the map.
    """
    if len(floors) == 1 or not len(left_out.scan):
        return TRIED[0]
    taken_s = np.array([fingerprints[at].time_s for at in left_out.scan.tolist()])
    order = np.lexsort((taken_s, left_out.walk))
    matches = [left_out.match[at] for at in order.tolist()]
    true = [fingerprints[at].floor for at in left_out.scan[order].tolist()]
    walk = left_out.walk[order].tolist()
    for tried in TRIED:
        if _wrongly_certain(matches, true, walk, tuple(floors), tried) <= WRONG_AT_MOST:
            return tried
    return TRIED[-1]


def _wrongly_certain(
    matches: Sequence[Match], true: Sequence[str], walk: Sequence[int], floors: tuple[str, ...], tried: FloorSettings
) -> float:
    """Share of scans, walk by walk in order of time, after which a wrong floor is certain."""
    belief: FloorBelief | None = None
    wrong = 0
    for at, match in enumerate(matches):
        belief = None if at == 0 or walk[at] != walk[at - 1] else belief
        belief = advance_floor(belief, floors, match.floor_probability, settings=tried, unlike=match.unlike)
        wrong += belief.floor != true[at] and belief.certainty >= CERTAIN
    return wrong / len(matches)
