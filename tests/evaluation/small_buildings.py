"""A seed whose building is small enough to be surveyed and walked within a test."""

from __future__ import annotations

from functools import lru_cache

from app.evaluation.new_buildings import NewBuilding, new_building
from app.simulation.varied_world import Traits

SMALL = 148
"""An office of one floor."""


@lru_cache
def small_building() -> NewBuilding:
    return new_building(Traits.draw(SMALL))
