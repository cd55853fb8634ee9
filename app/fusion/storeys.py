"""The floor of a phone with a barometer: held while it stays on its height, moved along when it has risen or sunk.

Scans say on which floor the phone was when it last rested, the *base*; the height since then says how many storeys
that is from the floor now. Without a change of height a scan of another floor is therefore most likely wrong, and with
one the floor changes before any scan is heard there. Without a barometer floors are decided as by every other method.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion.floor_choice import chosen_floor
from app.fusion.interface import Site
from app.fusion.state_codec import storable
from app.observations import PressureSamples
from app.pdr.pressure import SMOOTH_S, HeightRecord, measured
from app.wifi.floor_decision import FloorBelief, FloorSettings
from app.wifi.floor_doubt import floor_settings
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap

storable(HeightRecord)


@dataclass(frozen=True, slots=True)
class StoreySettings:
    """storey_m, storey_sigma_m : of a building that nobody measured: 3 m in flats, 6 m in halls.
    least_sigma_m : how storeys of one building differ.
    door_m : standard deviation of what doors, wind and drift add to a height.
    changes : probability that the floor is another one than at the base, before the height is known; a storey further
    is half as likely.  lies, lies_m : probability that a height means nothing, and how far it then may be.
    clear : probability of a number of storeys from which the height alone decides.
    rising_m : from the base; a phone that far off is between floors until it rests.
    follow_s : within which the base follows the weather.
    arrived_s, leave_s : a phone that rests for so long a clear number of storeys off is on another floor; and one that
    rests for so long anywhere else is on a floor all the same, be it that a door was opened.
    held_after : scans that must agree with the decided floor before it is held.
    held_change, held_weight : of a held floor, probability that the next scan is on another, and the power to which
    its votes are raised: neighbouring scans err alike.
    silent_s : without a barometer for so long the base is forgotten; weather has 0.3 m an hour for each 2 minutes.
    stale_s : a height this old does not say where a scan was.
    """

    storey_m: float = 4.2
    storey_sigma_m: float = 0.9
    least_sigma_m: float = 0.4
    door_m: float = 0.7
    changes: float = 0.1
    lies: float = 0.005
    lies_m: float = 40.0
    clear: float = 0.9
    rising_m: float = 1.2
    follow_s: float = 60.0
    arrived_s: float = 3.0
    leave_s: float = 20.0
    held_after: int = 4
    held_change: float = 3e-4
    held_weight: float = 0.25
    silent_s: float = 120.0
    stale_s: float = 10.0


SETTINGS, USUAL = StoreySettings(), FloorSettings()


@storable
@dataclass(frozen=True, slots=True, eq=False)
class Storeys:
    """heights : by the barometer.  base : floors at the height base_m, None while heights say nothing.  agreed : scans
    that bore out the floor.  rested_s : how long the phone has been steady.  storey_m, storey_sigma_m : what is known
    of the height of this building's storeys."""

    heights: HeightRecord = field(default_factory=HeightRecord)
    base: FloorBelief | None = None
    base_m: float = 0.0
    agreed: int = 0
    rested_s: float = 0.0
    storey_m: float = SETTINGS.storey_m
    storey_sigma_m: float = SETTINGS.storey_sigma_m

    @property
    def risen_m(self) -> float:
        """Above the base, negative below; 0 where there is none."""
        return 0.0 if self.base is None else self.heights.height_m - self.base_m

    @property
    def changing(self) -> bool:
        """Whether the phone is between floors, or has been until a moment ago."""
        return abs(self.risen_m) >= SETTINGS.rising_m


def climbed(
    storeys: Storeys,
    belief: FloorBelief | None,
    samples: PressureSamples,
    until_s: float | None,
    site: Site,
) -> tuple[Storeys, FloorBelief | None, bool]:
    """Heights and floor after a batch's pressures up to a time; without any, what they were. The third answer is
    whether the phone has come to another floor."""
    records, before = measured(storeys.heights, samples, until_s), storeys.base
    if records == [storeys.heights]:
        return storeys, belief, False
    for record in records[:-1]:
        storeys = _second_later(storeys, record, site)
    storeys = replace(storeys, heights=records[-1])
    if storeys.base is None or belief is None or belief.floors != storeys.base.floors:
        return storeys, belief, False
    weight = _by_height(storeys, _levels(belief.floors, site)) @ storeys.base.probability
    found = _decided(belief, weight)
    arrived = before is not None and before.probability.argmax() != storeys.base.probability.argmax()
    moved = arrived or found.decided != belief.decided
    return storeys, found, moved


def heard(
    storeys: Storeys,
    belief: FloorBelief | None,
    hint: str | None,
    radio_map: RadioMap,
    site: Site,
    match: Match,
    unlike: float,
    time_s: float,
) -> tuple[Storeys, FloorBelief]:
    """The storeys and the belief after one more scan. Other arguments as of chosen_floor."""
    record, level = storeys.heights, _levels(radio_map.floors, site)
    fresh = record.trusted and len(record.seconds) > 0 and time_s - record.newest_s <= SETTINGS.stale_s
    if not fresh or np.ptp(level) == 0.0:
        return replace(storeys, base=None, agreed=0), chosen_floor(belief, hint, radio_map, site, match, unlike)
    if belief is None or storeys.base is None or storeys.base.floors != radio_map.floors:
        belief = chosen_floor(belief, hint, radio_map, site, match, unlike)
        base = belief if len(record.seconds) >= SMOOTH_S else None
        return replace(storeys, base=base, base_m=record.height_m, agreed=0, rested_s=0.0), belief
    likely, base = _by_height(storeys, level), storeys.base
    clear = _clear(likely[:, base.probability.argmax()], level)
    known = storeys.agreed >= SETTINGS.held_after
    held = known and clear
    voting = floor_settings(radio_map)
    votes = voting.doubted(match.floor_probability, unlike)
    same = level[:, np.newaxis] == level
    # between floors of one level heights say nothing, so votes count there as ever
    calmed = votes * (same @ votes) ** (SETTINGS.held_weight - 1.0)
    found = _decided(belief, likely @ base.probability * (calmed if held else votes))
    probability = base.probability * (likely.T @ (calmed if known else votes))
    probability /= probability.sum()
    probability += voting.change * (same / same.sum(axis=0) @ probability - probability)
    probability += (SETTINGS.held_change if known else voting.change) * (1.0 / len(level) - probability)
    agreed = storeys.agreed
    if not held and not storeys.changing:
        bears_out = level[match.floor_probability.argmax()] == level[found.decided]
        agreed = 0 if found.decided != belief.decided else max(agreed + (1 if bears_out else -1), 0)
    return replace(storeys, base=replace(base, probability=probability), agreed=agreed), found


def _second_later(storeys: Storeys, record: HeightRecord, site: Site) -> Storeys:
    """The storeys after a second: a phone at rest takes its base along."""
    before, last_s = storeys.heights.seconds, float(record.seconds[-1, 0])
    passed_s = last_s - float(before[-1, 0]) if len(before) else 0.0
    if passed_s > SETTINGS.silent_s or not record.trusted:
        return replace(storeys, heights=record, base=None, agreed=0, rested_s=0.0)
    rested_s = storeys.rested_s + passed_s if record.steady else 0.0
    storeys = replace(storeys, heights=record, rested_s=rested_s)
    if storeys.base is None or rested_s <= 0.0:
        return storeys
    if not storeys.changing:
        follow = -math.expm1(-passed_s / SETTINGS.follow_s)
        return replace(storeys, base_m=storeys.base_m + follow * storeys.risen_m)
    level, base = _levels(storeys.base.floors, site), storeys.base
    likely, was = _by_height(storeys, level), int(base.probability.argmax())
    clear = _clear(likely[:, was], level)
    found = _decided(base, likely @ base.probability)
    arrived = clear and level[found.probability.argmax()] != level[was]
    if rested_s < (SETTINGS.arrived_s if arrived else SETTINGS.leave_s):
        return storeys
    if clear:
        storeys = _learnt(storeys, float(level[found.probability.argmax()] - level[was]))
    return replace(storeys, base=found, base_m=record.height_m, agreed=storeys.agreed if clear else 0)


def _learnt(storeys: Storeys, levels: float) -> Storeys:
    """The storeys after a change by so many has been seen: how high each is."""
    if levels == 0.0 or storeys.risen_m / levels <= 0.0:
        return storeys
    seen_m, seen_m2 = storeys.risen_m / levels, (SETTINGS.door_m / levels) ** 2
    gain = storeys.storey_sigma_m**2 / (storeys.storey_sigma_m**2 + seen_m2)
    sigma_m = max(storeys.storey_sigma_m * math.sqrt(1.0 - gain), SETTINGS.least_sigma_m)
    return replace(storeys, storey_m=storeys.storey_m + gain * (seen_m - storeys.storey_m), storey_sigma_m=sigma_m)


def _levels(floors: tuple[str, ...], site: Site) -> FloatArray:
    """(f,) storeys above ground; of floors that nobody described, 0."""
    return np.array([site.floors[floor].level if floor in site.floors else 0 for floor in floors], dtype=np.float64)


def _by_height(storeys: Storeys, level: FloatArray) -> FloatArray:
    """(f, f) likelihood of the height since the base if the phone came from the column's floor to the row's."""
    apart = level[:, np.newaxis] - level
    other = np.where(apart == 0.0, 0.0, 0.5 ** np.abs(apart))
    prior = SETTINGS.changes * other / np.maximum(other.sum(axis=0), 1e-9)
    prior += (1.0 - SETTINGS.changes) * np.eye(len(level))
    noise_m2 = SETTINGS.door_m**2 + 2.0 * storeys.heights.noise_m**2 / SMOOTH_S
    variance_m2 = noise_m2 + (apart * storeys.storey_sigma_m) ** 2
    off_m2 = (storeys.risen_m - apart * storeys.storey_m) ** 2
    honest = np.exp(-0.5 * off_m2 / variance_m2) / np.sqrt(2.0 * math.pi * variance_m2)
    likelihood: FloatArray = prior * ((1.0 - SETTINGS.lies) * honest + SETTINGS.lies / SETTINGS.lies_m)
    return likelihood


def _clear(weight: FloatArray, level: FloatArray) -> bool:
    """Whether the weights (f,) of floors leave no doubt about the level."""
    share = (level[:, np.newaxis] == level) @ weight / weight.sum()
    return bool(share.max() >= SETTINGS.clear)


def _decided(belief: FloorBelief, weight: FloatArray) -> FloorBelief:
    """The belief with these weights (f,); the decision stands until another floor is probable enough."""
    probability = weight / weight.sum()
    best = int(probability.argmax())
    held = belief.decided
    return FloorBelief(belief.floors, probability, best if probability[best] >= USUAL.switch else held)
