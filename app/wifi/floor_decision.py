"""Which floor the walker is on: scans vote, and a decision stands until others speak against it for a while."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray

CERTAIN = 0.9
"""Probability from which a floor may be relied upon."""
_STEEPNESS = 7
"""Of the fall of votes with the signal distance: from nine tenths to one tenth within a factor of two."""


@dataclass(frozen=True, slots=True)
class FloorSettings:
    """change : probability that the walker changed floors since the last scan; a storey further is half as likely.
    doubt : share of a vote that any floor gets, so that no scan is certain.  unlike : signal distance to the best point
    of any floor at which a vote says half as much, and from which on soon nothing: a scan unlike all that was surveyed
    was taken where nobody surveyed, be it on either floor.  switch : probability that another floor must reach before
    the decision follows it."""

    change: float = 0.01
    doubt: float = 0.1
    unlike: float = math.inf
    switch: float = 0.8

    def doubted(self, votes: FloatArray, unlike: float) -> FloatArray:
        """(f,) likelihood of each floor. votes : (f,) sums to 1.  unlike : signal distance of the scan that votes."""
        heeded = 1.0 / (1.0 + (unlike / self.unlike) ** _STEEPNESS)
        doubt = 1.0 - (1.0 - self.doubt) * heeded
        return doubt / len(votes) + (1.0 - doubt) * votes


@dataclass(frozen=True, slots=True, eq=False)
class FloorBelief:
    """floors : names.  probability : (f,) of each, sums to 1.  decided : index of the floor that holds."""

    floors: tuple[str, ...]
    probability: FloatArray
    decided: int

    @property
    def floor(self) -> str:
        """Name of the decided floor."""
        return self.floors[self.decided]

    @property
    def certainty(self) -> float:
        """Probability of the decided floor."""
        return float(self.probability[self.decided])


def advance_floor(
    belief: FloorBelief | None,
    floors: tuple[str, ...],
    votes: FloatArray,
    levels: Mapping[str, int] | None = None,
    settings: FloorSettings = FloorSettings(),
    unlike: float = 0.0,
) -> FloorBelief:
    """The belief after one more scan; of several equal floors the first is decided at the start.

    Parameters
    ----------
    belief : before, None at the first scan. Its floors may be those of an earlier map.
    floors : of the map.  votes : (f,) the scan's floor_probability, sums to 1.
    levels : storeys above ground by floor, negative below; without them every change is as likely.
    unlike : the scan's signal distance to the best point of any floor.
    """
    prior = np.full(len(floors), 1.0 / len(floors)) if belief is None else _carried(belief, floors)
    prior = _transition(floors, levels, settings.change) @ prior
    probability = prior * settings.doubted(votes, unlike)
    probability /= probability.sum()
    best = int(probability.argmax())
    if belief is None or belief.floor not in floors:
        return FloorBelief(floors, probability, best)
    held = floors.index(belief.floor)
    return FloorBelief(floors, probability, best if probability[best] >= settings.switch else held)


def _carried(belief: FloorBelief, floors: tuple[str, ...]) -> FloatArray:
    """The belief over the floors of a map; those that are new start with none, all equal if none is left."""
    before = dict(zip(belief.floors, belief.probability.tolist(), strict=True))
    probability = np.array([before.get(name, 0.0) for name in floors])
    whole = float(probability.sum())
    return probability / whole if whole > 0.0 else np.full(len(floors), 1.0 / len(floors))


def _transition(floors: tuple[str, ...], levels: Mapping[str, int] | None, change: float) -> FloatArray:
    """(f, f) probability of the row's floor after the column's."""
    if len(floors) == 1:
        return np.ones((1, 1))
    level = np.array([0 if levels is None else levels.get(name, 0) for name in floors], dtype=np.float64)
    apart = np.maximum(np.abs(level[:, np.newaxis] - level), 1.0)
    weight = np.where(np.eye(len(floors), dtype=np.bool_), 0.0, 0.5**apart)
    matrix: FloatArray = change * weight / weight.sum(axis=0) + (1.0 - change) * np.eye(len(floors))
    return matrix
