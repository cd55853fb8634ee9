"""One small world and one walk for the tests that only look."""

from __future__ import annotations

import numpy as np
import pytest

from app.simulation.recording import SURVEY_PHONE, Recording, World, make_world, record_walk
from app.simulation.wifi_scanner import SimulatedScan

RATE_HZ = 50.0
START_S = 1_700_000_000.0


@pytest.fixture(scope="session")
def world() -> World:
    return make_world("test", "office", 2, seed=3)


def recorded(world: World, seed: int = 5, length_m: float = 80.0) -> Recording:
    """A walk on the ground floor; recordings give their scans once, so tests that take them make their own."""
    rng = np.random.default_rng(seed)
    return record_walk(world, world.building.floors[0], SURVEY_PHONE, START_S, length_m, RATE_HZ, rng)


@pytest.fixture(scope="session")
def recording(world: World) -> Recording:
    return recorded(world)


@pytest.fixture(scope="session")
def scans(world: World) -> list[SimulatedScan]:
    return list(recorded(world, length_m=200.0).scans)
