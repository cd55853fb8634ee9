"""The Site of each venue, decoded once per revision and shared by all its sessions."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from app.errors import InvalidInput, NotFound
from app.fusion.interface import Site
from app.observations import Position
from app.survey.admission import FloorExtent, off_floor

LARGEST = 64
"""Venues held; a radio map of a mall's floor takes some megabytes."""


@dataclass(frozen=True, slots=True, eq=False)
class SiteRevision:
    """A Site, and the venue's revision that it was read at."""

    revision: int
    site: Site


class SiteCache:
    """The newest Site per venue; least recently used venues are forgotten.

    Parameters
    ----------
    load : reads and decodes a venue's Site.
    """

    def __init__(self, load: Callable[[str], Awaitable[SiteRevision]], largest: int = LARGEST) -> None:
        self._load = load
        self._largest = largest
        self._held: OrderedDict[str, SiteRevision] = OrderedDict()
        self._loading: dict[tuple[str, int], asyncio.Task[SiteRevision]] = {}

    async def site(self, venue: str, revision: int) -> Site:
        """The venue's Site as of that revision or a later one. Many sessions that ask at once cause one reading.

        Raises
        ------
        NotFound : there is no such venue.
        DependencyDown : the database cannot be reached.
        """
        held = self._held.get(venue)
        if held is not None and held.revision >= revision:
            self._held.move_to_end(venue)
            return held.site
        key = (venue, revision)
        task = self._loading.get(key)
        if task is None:
            task = self._loading[key] = asyncio.create_task(self._read(venue))
            task.add_done_callback(lambda _: self._loading.pop(key, None))
        return (await asyncio.shield(task)).site  # a phone that hangs up must not stop the others' reading

    async def _read(self, venue: str) -> SiteRevision:
        read = await self._load(venue)
        held = self._held.get(venue)
        if held is None or held.revision <= read.revision:
            self._held[venue] = read
            self._held.move_to_end(venue)
            if len(self._held) > self._largest:
                self._held.popitem(last=False)
        return read


def refuse_off_floor(site: Site, start: Position | None) -> None:
    """Nothing, if a start lies on its floor, or near it, as surveyed places do.

    Raises
    ------
    InvalidInput : it does not.
    NotFound : the venue has no such floor.
    """
    if start is None:
        return
    refuse_unknown_floor(site, start.floor, "start.floor")
    floor = site.floors[start.floor]
    name, why = off_floor(start.x_m, start.y_m, FloorExtent(floor.floor, floor.width_m, floor.height_m))
    if name:
        raise InvalidInput(why, f"start.{name}")


def refuse_unknown_floor(site: Site, floor: str | None, field: str) -> None:
    """Nothing, if the venue has that floor or none is named.

    Raises
    ------
    NotFound : it has not; names the field.
    """
    if floor is not None and floor not in site.floors:
        raise NotFound(
            f"the venue has no floor {floor[:64]!r}; it has {', '.join(sorted(site.floors)) or 'none'}", field
        )
