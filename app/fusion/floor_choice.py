"""Which floor a session is on: the phone's hint until the first scan, the scans from there on."""

from __future__ import annotations

import numpy as np

from app.fusion.interface import Site
from app.fusion.state_codec import storable
from app.wifi.floor_decision import FloorBelief, advance_floor
from app.wifi.floor_doubt import floor_settings
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap

HINT_WEIGHT = 3.0
"""What a hinted floor counts against any other in the first scan's vote; it does not bind."""
LEAST_VOTE = 0.02
"""Of every floor where a hint weighs them: one that got no vote at all still gets a share of the hint."""
storable(FloorBelief)


def floor_before(belief: FloorBelief | None, hint: str | None) -> str | None:
    """The floor that a session is taken to be on before a scan."""
    return hint if belief is None else belief.floor


def chosen_floor(
    belief: FloorBelief | None,
    hint: str | None,
    radio_map: RadioMap,
    site: Site,
    match: Match,
    unlike: float = 0.0,
) -> FloorBelief:
    """The belief after one more scan.

    Parameters
    ----------
    belief : before, None at the first scan.  hint : what the phone said at first.
    unlike : signal distance of the scan to the best point of any floor, with which its vote fades; 0 of a method whose
    votes do not.
    """
    votes = match.floor_probability
    if belief is None and hint in radio_map.floors:
        votes = (votes + LEAST_VOTE) * np.where([floor == hint for floor in radio_map.floors], HINT_WEIGHT, 1.0)
        votes = votes / votes.sum()
    levels = {name: floor.level for name, floor in site.floors.items()}
    return advance_floor(belief, radio_map.floors, votes, levels, floor_settings(radio_map), unlike)
