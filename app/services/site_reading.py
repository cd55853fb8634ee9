"""Reads a venue's Site: its floors, its active radio map, and what of that map is not to be relied on."""

from __future__ import annotations

import asyncio
import gc
from collections.abc import Mapping
from typing import Any
from weakref import WeakValueDictionary

import orjson

from app.floorplan.free_space import FreeSpace
from app.fusion.interface import Floor, Site, spaces_of
from app.services.identifiers import no_venue
from app.services.site_cache import SiteRevision
from app.storage.radio_map_rows import ActiveMap, RadioMapRows
from app.storage.venue_rows import FloorRow, VenueRows
from app.storage.watch_list_rows import WatchListRows
from app.wifi.radio_map import RadioMap
from app.wifi.radio_map_codec import decode_radio_map


class SiteReader:
    """Reads from the database; what SiteCache is given."""

    def __init__(self, venues: VenueRows, maps: RadioMapRows, watch_lists: WatchListRows) -> None:
        self._venues = venues
        self._maps = maps
        self._watch_lists = watch_lists
        # a version never changes: as long as any Site has it, others share it, with the indices made of it
        self._decoded: WeakValueDictionary[tuple[str, int], RadioMap] = WeakValueDictionary()

    async def read(self, venue: str) -> SiteRevision:
        """The Site as it is now.

        Raises
        ------
        NotFound : there is no such venue.
        DependencyDown : the database cannot be reached.
        """
        active, found = await self._maps.active(venue), await self._venues.read(venue)
        if active is None or found is None:
            raise no_venue(venue)
        radio_map = await self._radio_map(venue, active)
        watched = frozenset[int]()
        if active.version is not None:
            watched = await self._watch_lists.watched(venue, active.version)
        # the revision is the oldest reading's: if floors or list have changed in between, they are read again
        floors = {row.floor: _floor_of(row) for row in found[1]}
        plans = {row.floor: await self._venues.read_plan(venue, row.floor) for row in found[1] if row.has_plan}
        spaces = await asyncio.to_thread(self._spaces_of, floors, plans, radio_map)
        return SiteRevision(active.revision, Site(floors, radio_map, watched, spaces))

    @staticmethod
    def _spaces_of(
        floors: Mapping[str, Floor], plans: Mapping[str, bytes | None], radio_map: RadioMap | None
    ) -> dict[str, FreeSpace]:
        decoded = {floor: None if plan is None else _decoded(plan) for floor, plan in plans.items()}
        return spaces_of(floors.values(), decoded, radio_map)

    async def _radio_map(self, venue: str, active: ActiveMap) -> RadioMap | None:
        if active.version is None or active.body is None:
            return None
        radio_map = self._decoded.get((venue, active.version))
        if radio_map is None:
            radio_map = await asyncio.to_thread(decode_radio_map, active.body)
            self._decoded[venue, active.version] = radio_map
        return radio_map


def _decoded(plan: bytes) -> Any:
    """A plan, read while the garbage collector rests: it would go through what has been read again and again, in six
    times the time, and all phones of the process wait for the end."""
    gc.disable()
    try:
        return orjson.loads(plan)
    finally:
        gc.enable()


def _floor_of(row: FloorRow) -> Floor:
    """A stored floor as the methods know it."""
    return Floor(row.floor, row.level, row.width_m, row.height_m, row.georeference)
