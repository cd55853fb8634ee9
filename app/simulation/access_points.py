"""The access points of a building: radios, the networks each announces, and how strong they arrive at a place.

Mean level = transmit level at 1 m - 10 n log10(distance) - walls - floors + shadowing. Shadowing is fixed in space, as
it is in a building, in two scales: metres (furniture, shelves) and a dozen metres (what the plan does not show).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import BoolArray, FloatArray, IntArray
from app.simulation.building import Building, SimulatedFloor
from app.simulation.random_field import RandomField

PATH_LOSS_EXPONENT = 2.5
"""In the open; walls come on top."""
FLOOR_LOSS_DB = {"office": 16.0, "mall": 18.0, "hospital": 19.0}
TENANTS_PER_ROOM = {"office": 0.3, "mall": 2.2, "hospital": 0.2}
LONG_SHADOWING_DB, LONG_SHADOWING_M = 3.0, 12.0
SHORT_SHADOWING_DB, SHORT_SHADOWING_M = 1.5, 3.0
CEILING_M, DESK_M, PHONE_M = 2.8, 1.0, 1.2
FREQUENCIES_24_MHZ = (2412, 2437, 2462)
FREQUENCIES_5_MHZ = (5180, 5200, 5220, 5240, 5260, 5300, 5745, 5765, 5785, 5805, 5825)
HOUSE_NETWORKS = ("guest", "staff", "", "pos", "office", "iot")
"""What the building's own access points announce; one name is hidden."""
TENANT_NETWORKS = ("TP-LINK", "Xiaomi", "ChinaNet", "FRITZ!Box", "NETGEAR", "dlink", "Vodafone")
FAR_BELOW_HEARING_DBM = -102.0


@dataclass(frozen=True, slots=True, eq=False)
class AccessPoints:
    """Radios (r,) and the networks (b,) they announce.

    place_m : (r, 3) in the floor frame, z from the ground floor.  level : (r,) storey.  level_at_1m_dbm : (r,).
    frequency_mhz : (r,).  bssid : (b,) 48-bit.  ssid : b names.  radio : (b,) which radio announces each.
    """

    building: Building
    place_m: FloatArray
    level: IntArray
    level_at_1m_dbm: FloatArray
    frequency_mhz: IntArray
    bssid: IntArray
    ssid: tuple[str, ...]
    radio: IntArray
    long_shadowing: RandomField
    short_shadowing: RandomField

    def mean_dbm(self, floor: SimulatedFloor, xy_m: FloatArray) -> tuple[IntArray, FloatArray]:
        """Radios that may be heard when radio i is listened to at xy_m[i], (r, 2), and their mean levels."""
        z = np.full(len(xy_m), floor.level * floor.storey_height_m + PHONE_M)
        phone = np.column_stack([xy_m, z])
        distance = np.maximum(np.linalg.norm(self.place_m - phone, axis=1), 1.0)
        slabs = np.abs(self.level - floor.level)
        # the second slab costs less than the first: stairs, shafts and facades
        level = self.level_at_1m_dbm - 10.0 * PATH_LOSS_EXPONENT * np.log10(distance)
        level -= FLOOR_LOSS_DB[self.building.kind] * slabs**0.8
        near = np.flatnonzero(level > FAR_BELOW_HEARING_DBM - 2.5 * LONG_SHADOWING_DB)
        walls = floor.walls.loss_between_db(self.place_m[near, :2], xy_m[near])
        shadow = self.long_shadowing.at(near, phone[near]) + self.short_shadowing.at(near, phone[near])
        level = level[near] - walls + shadow
        audible: BoolArray = level > FAR_BELOW_HEARING_DBM
        return near[audible], level[audible]


@dataclass(slots=True)
class _Planned:
    """What is being put together, radio by radio."""

    places: list[tuple[float, float, float]]
    levels: list[int]
    powers: list[float]
    frequencies: list[int]
    bssids: list[int]
    ssids: list[str]
    radios: list[int]

    def add(
        self,
        rng: np.random.Generator,
        place: tuple[float, float, float],
        level: int,
        power_dbm: float,
        names: tuple[str, ...],
    ) -> None:
        """A dual-band access point: two radios, each announcing every name under an address of its own."""
        address = (int(rng.choice((0x00749C, 0xA80CCA, 0xEC5623, 0x54A703))) << 24) | int(rng.integers(0, 1 << 24))
        for band, frequencies in enumerate((FREQUENCIES_24_MHZ, FREQUENCIES_5_MHZ)):
            for number, name in enumerate(names):
                local = (0x02 + 4 * number) << 40 if number else 0  # further networks: locally administered addresses
                self.bssids.append((address ^ local) ^ band)
                self.ssids.append(f"{name}_5G" if band and name and len(names) == 1 else name)
                self.radios.append(len(self.places))
            self.places.append(place)
            self.levels.append(level)
            self.powers.append(power_dbm - 3.0 * band)
            self.frequencies.append(int(rng.choice(frequencies)))


def install_access_points(building: Building, rng: np.random.Generator) -> AccessPoints:
    """Access points for a building: its own on the ceiling at regular distances, tenants' routers in some rooms."""
    planned = _Planned([], [], [], [], [], [], [])
    for floor in building.floors:
        ground = floor.level * floor.storey_height_m
        for x, y in floor.to_frame(_ceiling_spots(floor, rng)).tolist():
            power = float(rng.normal(-30.0, 2.5))
            planned.add(rng, (x, y, ground + CEILING_M), floor.level, power, _house_networks(building, rng))
        share = TENANTS_PER_ROOM[building.kind]
        tenants = [room for room in floor.layout.rooms for _ in range(int(rng.poisson(share)))]
        spots = [_inside(room.area.shrunk(0.5).corners, rng) for room in tenants]
        for (x, y), room in zip(floor.to_frame(np.array(spots).reshape(-1, 2)).tolist(), tenants, strict=True):
            network = f"{rng.choice(TENANT_NETWORKS)}_{floor.floor}{room.name}"
            hidden = rng.random() < 0.1
            power = float(rng.normal(-38.0, 5.0))
            planned.add(rng, (x, y, ground + DESK_M), floor.level, power, ("" if hidden else network,))
    count = len(planned.places)
    return AccessPoints(
        building=building,
        place_m=np.array(planned.places),
        level=np.array(planned.levels, dtype=np.int64),
        level_at_1m_dbm=np.array(planned.powers),
        frequency_mhz=np.array(planned.frequencies, dtype=np.int64),
        bssid=np.array(planned.bssids, dtype=np.int64),
        ssid=tuple(planned.ssids),
        radio=np.array(planned.radios, dtype=np.int64),
        long_shadowing=RandomField.draw(rng, count, LONG_SHADOWING_DB, LONG_SHADOWING_M),
        short_shadowing=RandomField.draw(rng, count, SHORT_SHADOWING_DB, SHORT_SHADOWING_M),
    )


def _house_networks(building: Building, rng: np.random.Generator) -> tuple[str, ...]:
    names = HOUSE_NETWORKS[: int(rng.integers(3, len(HOUSE_NETWORKS) + 1))]
    return tuple(f"{building.name}-{name}" if name else "" for name in names)


def _ceiling_spots(floor: SimulatedFloor, rng: np.random.Generator) -> FloatArray:
    """Spots about the layout's spacing apart along corridors and in rooms, in the building frame."""
    spacing = floor.layout.access_point_spacing_m
    candidates = [_inside(c.corners, rng) for c in floor.layout.corridors for _ in range(12)]
    candidates += [_inside(room.area.corners, rng) for room in floor.layout.rooms for _ in range(2)]
    chosen: list[tuple[float, float]] = []
    for index in rng.permutation(len(candidates)).tolist():
        x, y = candidates[index]
        if all((x - a) ** 2 + (y - b) ** 2 > spacing**2 * 0.6 for a, b in chosen):
            chosen.append((x, y))
    return np.array(chosen)


def _inside(corners: tuple[tuple[float, float], ...], rng: np.random.Generator) -> tuple[float, float]:
    (x0, y0), (x1, y1) = corners[0], corners[2]
    return float(rng.uniform(x0, x1)), float(rng.uniform(y0, y1))
