"""What a positioning method is: start() and a pure advance() on a frozen state."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.estimation.arrays import FloatArray
from app.floorplan.free_space import NO_PLAN, FreeSpace, free_space
from app.floorplan.georeference import Georeference
from app.observations import Batch, Fix, Position
from app.wifi.radio_map import RadioMap


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor as the methods need it. level : storeys above ground, negative below."""

    floor: str
    level: int
    width_m: float
    height_m: float
    georeference: Georeference | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """What is known of the venue: its floors and the active radio map (None until one is published).

    watched : access points on the map's watch list, 48-bit addresses: not to be relied on.
    spaces : where walkers can be, by floor, of those whose plan says.
    """

    floors: Mapping[str, Floor] = field(default_factory=dict)
    radio_map: RadioMap | None = None
    watched: frozenset[int] = frozenset()
    spaces: Mapping[str, FreeSpace] = field(default_factory=dict)

    def space(self, floor: str) -> FreeSpace:
        """The free space of a floor; one without a plan is free everywhere."""
        return self.spaces.get(floor, NO_PLAN)


def spaces_of(
    floors: Iterable[Floor], plans: Mapping[str, Mapping[str, Any] | None], radio_map: RadioMap | None
) -> dict[str, FreeSpace]:
    """The free space of every floor that has a plan and was surveyed. plans : GeoJSON, by floor."""
    spaces = dict[str, FreeSpace]()
    for floor in floors:
        plan = plans.get(floor.floor)
        if plan is None or radio_map is None or floor.floor not in radio_map.floors:
            continue
        visited_xy_m = radio_map.xy_m[radio_map.floor == radio_map.floors.index(floor.floor)]
        space = free_space(plan, floor.georeference, (floor.width_m, floor.height_m), visited_xy_m)
        if space is not NO_PLAN:
            spaces[floor.floor] = space
    return spaces


@dataclass(frozen=True, slots=True)
class SessionStart:
    """What a phone asks for when it opens a session. start : a prior of 5 m (68 %); floor : a hint. Neither binds."""

    alert_limit_m: float = 10.0
    risk: float = 0.01
    floor: str | None = None
    start: Position | None = None

    @property
    def floor_hint(self) -> str | None:
        """The floor that the phone says it is on."""
        return self.floor if self.start is None else self.start.floor

    @property
    def prior_m(self) -> FloatArray | None:
        """(2,) where the phone says it starts, None where it does not say."""
        return None if self.start is None else np.array([self.start.x_m, self.start.y_m])


START_SIGMA_M = 5.0 / 1.5096
"""Of a `start`, in each direction: 68 % within 5 m."""


@dataclass(frozen=True, slots=True)
class Method:
    """One positioning method.

    start : SessionStart -> state.  advance : (state, batch, site) -> (state, fix), pure: the same arguments give the
    same result, on any worker.  States are frozen dataclasses of numbers, strings, enums, arrays, tuples, None and
    other such dataclasses, so that app/fusion/state_codec.py can store them all.
    walls : whether its answers keep to where the floor plan lets one walk.
    """

    method: str
    start: Callable[[SessionStart], Any]
    advance: Callable[[Any, Batch, Site], tuple[Any, Fix]]
    walls: bool = False
