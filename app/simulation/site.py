"""Survey walks of a simulated building, and the folder of files that holds them."""

from __future__ import annotations

import hashlib
import json
import lzma
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from app.simulation.building import SimulatedFloor
from app.simulation.plan_files import floor_info, plan_geojson, plan_image
from app.simulation.recording import SURVEY_PHONE, Recording, World, record_walk
from app.simulation.trace_writer import trace_bytes

EPOCH_S = 1_700_000_000.0
"""When the first simulated walk begins; only the seed, not the clock, decides what is recorded."""
WALKS_APART_S = 600.0
LENGTH_M = (12.0, 95.0)
"""Walks are mostly short, as the open data's are: log-uniform between these."""


def survey_walks(
    world: World, floor: SimulatedFloor, count: int, seed: int, rate_hz: float, length_m: tuple[float, float] = LENGTH_M
) -> Iterator[tuple[str, Recording]]:
    """Recorded walks of a floor with their ids, which look like the open data's and follow from the arguments."""
    for number in range(count):
        rng = np.random.default_rng([seed, 2, floor.level, number])
        name = hashlib.md5(f"{world.building.name}/{floor.floor}/{seed}/{number}".encode()).hexdigest()[:24]
        way_m = float(np.exp(rng.uniform(*np.log(length_m))))
        start_s = EPOCH_S + WALKS_APART_S * (number + 1000 * floor.level)
        yield name, record_walk(world, floor, SURVEY_PHONE, start_s, way_m, rate_hz, rng)


def write_plans(world: World, folder: Path) -> None:
    """`F1/floor_info.json`, `geojson_map.json` and `floor_image.png` for every floor."""
    for floor in world.building.floors:
        place = folder / floor.floor
        (place / "path_data_files").mkdir(parents=True, exist_ok=True)
        (place / "floor_info.json").write_text(json.dumps(floor_info(floor), indent=2) + "\n")
        (place / "geojson_map.json").write_text(json.dumps(plan_geojson(world.building, floor)) + "\n")
        (place / "floor_image.png").write_bytes(plan_image(floor))


def write_walk(world: World, folder: Path, name: str, recording: Recording) -> Path:
    """One trace file `F1/path_data_files/<name>.txt.xz`."""
    path = folder / recording.walk.floor.floor / "path_data_files" / f"{name}.txt.xz"
    text = trace_bytes(recording, world.access_points, world.building.name)
    path.write_bytes(lzma.compress(text, preset=1))
    return path
