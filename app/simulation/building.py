"""A building: floors of rooms and corridors, their walls, and where one can walk.

Layouts are drawn axis-parallel in a building frame and turned into the floor frame (x east, y north, origin in the
south-west corner of the outline's bounding box), so that nothing downstream may rely on walls along the axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from app.errors import InvalidInput
from app.estimation.arrays import FloatArray
from app.floorplan.georeference import Georeference
from app.simulation.layouts import LAYOUTS, Layout
from app.simulation.walkways import Walkways
from app.simulation.walls import Walls, walls_of

STOREY_HEIGHT_M = {"office": 3.6, "mall": 5.0, "hospital": 4.0}


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedFloor:
    """One floor. The building frame, turned counter-clockwise by rotation_rad and moved by shift_m, is its frame."""

    floor: str
    level: int
    storey_height_m: float
    layout: Layout
    walls: Walls
    walkways: Walkways
    rotation_rad: float
    shift_m: tuple[float, float]
    width_m: float
    height_m: float

    def to_frame(self, xy_m: FloatArray | Sequence[tuple[float, float]]) -> FloatArray:
        """Points (n, 2) of the building frame in the floor frame."""
        return np.asarray(
            _turned(np.asarray(xy_m, dtype=np.float64), self.rotation_rad) + self.shift_m, dtype=np.float64
        )

    def route(self, rng: np.random.Generator, length_m: float, near_m: tuple[float, float] | None = None) -> FloatArray:
        """A random walk through rooms and corridors as corner points (k, 2) in the floor frame, about that long.

        near_m : where it begins, about; None: anywhere.
        """
        if near_m is None:
            return self.to_frame(self.walkways.route(rng, length_m))
        begin = _turned(np.array([near_m]) - self.shift_m, -self.rotation_rad)[0]
        return self.to_frame(self.walkways.route(rng, length_m, begin))


@dataclass(frozen=True, slots=True, eq=False)
class Building:
    """Floors from the ground up, and where their common frame lies on Earth."""

    name: str
    kind: str
    georeference: Georeference
    floors: tuple[SimulatedFloor, ...] = field(default_factory=tuple)


def make_building(
    name: str,
    kind: str,
    floor_count: int,
    rng: np.random.Generator,
    georeference: Georeference | None = None,
    reshaped: Callable[[Layout], Layout] = lambda layout: layout,
) -> Building:
    """A building of a kind (``office``, ``mall`` or ``hospital``) whose floors differ in rooms and materials.

    reshaped : what becomes of each floor's layout, such as another size.

    Raises
    ------
    InvalidInput : an unknown kind, or not between 1 and 40 floors.
    """
    if kind not in LAYOUTS:
        raise InvalidInput(f"unknown building {kind!r}; known are {', '.join(LAYOUTS)}", "building")
    if not 1 <= floor_count <= 40:
        raise InvalidInput("a building has 1 to 40 floors", "floors")
    rotation_rad = math.radians(float(rng.uniform(-30.0, 30.0)))
    floors = []
    for number in range(floor_count):
        layout = reshaped(LAYOUTS[kind](rng))
        outline = _turned(np.asarray(layout.outline, dtype=np.float64), rotation_rad)
        low, high = outline.min(axis=0), outline.max(axis=0)
        floors.append(
            SimulatedFloor(
                floor=f"F{number + 1}",
                level=number,
                storey_height_m=STOREY_HEIGHT_M[kind],
                layout=layout,
                walls=_placed(walls_of(layout, rng), rotation_rad, -low),
                walkways=Walkways.of(layout),
                rotation_rad=rotation_rad,
                shift_m=(float(-low[0]), float(-low[1])),
                width_m=float(high[0] - low[0]),
                height_m=float(high[1] - low[1]),
            )
        )
    place = georeference or Georeference(float(rng.uniform(-55.0, 60.0)), float(rng.uniform(-170.0, 170.0)), 0.0)
    return Building(name=name, kind=kind, georeference=place, floors=tuple(floors))


def _turned(xy: FloatArray, angle_rad: float) -> FloatArray:
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.asarray(xy @ np.array([[c, s], [-s, c]]), dtype=np.float64)


def _placed(walls: Walls, angle_rad: float, shift: FloatArray) -> Walls:
    return Walls(_turned(walls.start_m, angle_rad) + shift, _turned(walls.end_m, angle_rad) + shift, walls.loss_db)
