"""Venues and their floors in the database."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import insert, select, update
from sqlalchemy.exc import IntegrityError
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

from app.floorplan.georeference import Georeference
from app.storage.database import reachable
from app.storage.tables import floors, venues


@dataclass(frozen=True, slots=True)
class VenueRow:
    """A venue. active_version : of its radio map; None until one is published.  created_ms : server's clock, Unix."""

    id: int
    venue: str
    name: str
    revision: int
    active_version: int | None
    created_ms: int


@dataclass(frozen=True, slots=True)
class FloorRow:
    """A floor without its plan and image. venue : its own.  The georeference's three are None together."""

    id: int
    venue: str
    floor: str
    name: str
    level: int
    width_m: float
    height_m: float
    latitude_deg: float | None
    longitude_deg: float | None
    rotation_rad: float | None
    has_plan: bool
    has_image: bool

    @property
    def georeference(self) -> Georeference | None:
        """Where its frame lies; None unless all three are known: a frame turned by a guess misplaces what is in it."""
        if self.latitude_deg is None or self.longitude_deg is None or self.rotation_rad is None:
            return None
        return Georeference(self.latitude_deg, self.longitude_deg, self.rotation_rad)


class VenueRows:
    """Reads and writes venues; every method is one transaction.

    Each raises DependencyDown where the database cannot be reached, having changed nothing. Everything that changes
    a venue's Site raises its revision in the same transaction.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def add(self, venue: str, name: str, created_ms: int) -> bool:
        """A new venue; False if there is one of that identifier."""
        values = {"venue": venue, "name": name, "revision": 1, "created_ms": created_ms}
        try:
            async with reachable(), self._engine.begin() as connection:
                await connection.execute(insert(venues).values(values))
        except IntegrityError:
            return False
        return True

    async def key(self, venue: str) -> int | None:
        """A venue's key; None if there is none."""
        async with reachable(), self._engine.connect() as connection:
            key: int | None = await connection.scalar(select(venues.c.id).where(venues.c.venue == venue))
        return key

    async def listed(self) -> list[VenueRow]:
        """Every venue, oldest first."""
        async with reachable(), self._engine.connect() as connection:
            rows = (await connection.execute(_READ_VENUES.order_by(venues.c.id))).all()
        return [VenueRow(**row._mapping) for row in rows]

    async def revisions(self) -> list[tuple[str, int]]:
        """Every venue with its revision."""
        return [(row.venue, row.revision) for row in await self.listed()]

    async def read(self, venue: str) -> tuple[VenueRow, list[FloorRow]] | None:
        """A venue and its floors from the lowest up; None if there is none."""
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(_READ_VENUES.where(venues.c.venue == venue))).one_or_none()
            if row is None:
                return None
            query = _READ_FLOORS.where(venues.c.id == row.id).order_by(floors.c.level, floors.c.floor)
            found = await connection.execute(query)
            return VenueRow(**row._mapping), [FloorRow(**floor._mapping) for floor in found]

    async def floors(self) -> list[FloorRow]:
        """The floors of every venue, in the order in which they were made."""
        async with reachable(), self._engine.connect() as connection:
            rows = (await connection.execute(_READ_FLOORS.order_by(floors.c.id))).all()
        return [FloorRow(**row._mapping) for row in rows]

    async def put_floor(self, venue: str, floor: str, values: Mapping[str, Any]) -> bool | None:
        """Make a floor, or replace everything of it but its image.

        Returns
        -------
        Whether it is new; None if there is no such venue.
        """
        async with reachable(), self._engine.begin() as connection:
            venue_id = await _raise_revision(connection, venue)
            if venue_id is None:
                return None
            here = floors.c.venue_id == venue_id, floors.c.floor == floor
            if (await connection.execute(update(floors).where(*here).values(dict(values)))).rowcount:
                return False
            await connection.execute(insert(floors).values(venue_id=venue_id, floor=floor, **values))
        return True

    async def put_image(self, venue: str, floor: str, image: bytes) -> bool:
        """Set a floor's image; False if there is no such floor. The Site has none, so the revision stays."""
        venue_id = select(venues.c.id).where(venues.c.venue == venue).scalar_subquery()
        query = update(floors).where(floors.c.venue_id == venue_id, floors.c.floor == floor).values(image=image)
        async with reachable(), self._engine.begin() as connection:
            return (await connection.execute(query)).rowcount == 1

    async def read_plan(self, venue: str, floor: str) -> bytes | None:
        """A floor's plan; None if there is no such floor or it has none."""
        return await self._content(venue, floor, "plan")

    async def read_image(self, venue: str, floor: str) -> bytes | None:
        """A floor's image; None if there is no such floor or it has none."""
        return await self._content(venue, floor, "image")

    async def _content(self, venue: str, floor: str, column: str) -> bytes | None:
        query = (
            select(floors.c[column])
            .join(venues, venues.c.id == floors.c.venue_id)
            .where(venues.c.venue == venue, floors.c.floor == floor)
        )
        async with reachable(), self._engine.connect() as connection:
            content: bytes | None = await connection.scalar(query)
        return content


async def _raise_revision(connection: AsyncConnection, venue: str) -> int | None:
    """The venue's key, its row locked until the transaction ends; None if there is none."""
    query = update(venues).where(venues.c.venue == venue).values(revision=venues.c.revision + 1)
    venue_id: int | None = await connection.scalar(query.returning(venues.c.id))
    return venue_id


_READ_VENUES = select(
    venues.c.id, venues.c.venue, venues.c.name, venues.c.revision, venues.c.active_version, venues.c.created_ms
)
_READ_FLOORS = select(
    floors.c.id,
    venues.c.venue,
    floors.c.floor,
    floors.c.name,
    floors.c.level,
    floors.c.width_m,
    floors.c.height_m,
    floors.c.latitude_deg,
    floors.c.longitude_deg,
    floors.c.rotation_rad,
    floors.c.plan.is_not(None).label("has_plan"),
    floors.c.image.is_not(None).label("has_image"),
).join(venues, venues.c.id == floors.c.venue_id)
