"""Buildings that differ in more than their rooms: size, access points, shadowing, steel, and who walks through them.

The ranges are wide on purpose and belong to no method: they were written down before any method was run on them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.estimation.arrays import BoolArray
from app.simulation.access_points import AccessPoints, install_access_points
from app.simulation.building import make_building
from app.simulation.imu import magnetic_disturbance
from app.simulation.layouts import LAYOUTS, Layout, Rect, Room
from app.simulation.random_field import RandomField
from app.simulation.recording import World

FLOORS = (1, 3)
STRETCH = (0.6, 1.15)
SPACING = (0.8, 1.6)
KEPT = (0.4, 1.0)
SHADOWING = (0.7, 1.5)
UNREST = (0.7, 1.5)
STEEL = (0.5, 1.8)
OFFSET_SPREAD_DB = (0.0, 6.0)
SURVEY_M_PER_M2 = (0.06, 0.3)
"""Of walked way on a floor; the recorded mall floors have about 0.2."""


@dataclass(frozen=True, slots=True)
class Traits:
    """What makes a building this one and not another.

    stretch_x, stretch_y : of the layout's size.  spacing : of the house's access points, times the layout's.
    kept : share of all access points that is there.  shadowing, unrest, steel : times the simulator's usual shadowing,
    fading and changes between visits, and magnetic disturbance.  offset_spread_db : standard deviation of what the
    visitors' phones read more than the surveyors'.  survey_m_per_m2 : metres of survey walk per square metre of floor.
    """

    seed: int
    kind: str
    floors: int
    stretch_x: float
    stretch_y: float
    spacing: float
    kept: float
    shadowing: float
    unrest: float
    steel: float
    offset_spread_db: float
    survey_m_per_m2: float

    @classmethod
    def draw(cls, seed: int) -> Traits:
        """The building that a seed stands for."""
        rng = np.random.default_rng([seed, 7])

        def between(bounds: tuple[float, float]) -> float:
            return float(np.exp(rng.uniform(*np.log(bounds))))

        return cls(
            seed=seed,
            kind=str(rng.choice(list(LAYOUTS))),
            floors=int(rng.integers(FLOORS[0], FLOORS[1] + 1)),
            stretch_x=between(STRETCH),
            stretch_y=between(STRETCH),
            spacing=between(SPACING),
            kept=between(KEPT),
            shadowing=between(SHADOWING),
            unrest=between(UNREST),
            steel=between(STEEL),
            offset_spread_db=float(rng.uniform(*OFFSET_SPREAD_DB)),
            survey_m_per_m2=between(SURVEY_M_PER_M2),
        )

    @property
    def name(self) -> str:
        """Of the building, unlike any other's."""
        return f"{self.kind}-{self.seed}"


def varied_world(traits: Traits) -> World:
    """The building with these traits; the same traits give the same world."""
    plan_rng, radio_rng, steel_rng, kept_rng = np.random.default_rng([traits.seed, 8]).spawn(4)

    def reshaped(layout: Layout) -> Layout:
        return stretched(layout, traits.stretch_x, traits.stretch_y, traits.spacing)

    building = make_building(traits.name, traits.kind, traits.floors, plan_rng, reshaped=reshaped)
    installed = install_access_points(building, radio_rng)
    _, unit = np.unique(installed.place_m, axis=0, return_inverse=True)
    there = kept_rng.random(int(unit.max()) + 1) < traits.kept
    kept = only(installed, there[unit.reshape(-1)])
    radio = replace(
        kept,
        long_shadowing=_scaled(kept.long_shadowing, traits.shadowing),
        short_shadowing=_scaled(kept.short_shadowing, traits.shadowing),
    )
    return World(building, radio, _scaled(magnetic_disturbance(steel_rng), traits.steel))


def stretched(layout: Layout, along_x: float, along_y: float, spacing: float) -> Layout:
    """The layout at another size, its access points further apart or nearer by a factor."""

    def rect(one: Rect) -> Rect:
        return Rect(one.x0 * along_x, one.y0 * along_y, one.x1 * along_x, one.y1 * along_y)

    return Layout(
        outline=tuple((x * along_x, y * along_y) for x, y in layout.outline),
        corridors=tuple(map(rect, layout.corridors)),
        rooms=tuple(Room(room.name, rect(room.area), rect(room.door)) for room in layout.rooms),
        wall_losses_db=layout.wall_losses_db,
        access_point_spacing_m=layout.access_point_spacing_m * spacing,
    )


def only(access_points: AccessPoints, kept: BoolArray) -> AccessPoints:
    """The access points without the radios (r,) that are not kept, and without their networks."""
    networks = np.flatnonzero(kept[access_points.radio])
    number = np.cumsum(kept) - 1
    return replace(
        access_points,
        place_m=access_points.place_m[kept],
        level=access_points.level[kept],
        level_at_1m_dbm=access_points.level_at_1m_dbm[kept],
        frequency_mhz=access_points.frequency_mhz[kept],
        bssid=access_points.bssid[networks],
        ssid=tuple(access_points.ssid[network] for network in networks.tolist()),
        radio=number[access_points.radio[networks]].astype(np.int64),
        long_shadowing=_chosen(access_points.long_shadowing, kept),
        short_shadowing=_chosen(access_points.short_shadowing, kept),
    )


def _chosen(field: RandomField, kept: BoolArray) -> RandomField:
    return replace(field, wave_radpm=field.wave_radpm[kept], phase_rad=field.phase_rad[kept])


def _scaled(field: RandomField, factor: float) -> RandomField:
    return replace(field, sigma=field.sigma * factor)
