"""Radio-map versions in the database: immutable, numbered per venue, one of them active."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import ColumnElement, Select, and_, bindparam, func, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

from app.storage.database import LONG_S, reachable
from app.storage.tables import radio_maps, surveys, venues, watched_access_points


class OutdatedError(Exception):
    """A version was built from surveys, or under a number, that are no longer those of the venue: build it again."""


@dataclass(frozen=True, slots=True)
class BuiltMap:
    """A version that is built and not yet stored.

    version : the number it was built under.  surveys : those it is made of.  complete : these must be all that the
    venue has.  summary : counts for listings.  body : encoded.  active : publish it, too.
    heard : by access point, which of the surveys, by its place among them, heard it last.
    """

    version: int
    surveys: tuple[int, ...]
    complete: bool
    summary: Mapping[str, Any]
    body: bytes
    active: bool
    heard: Mapping[int, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class VersionRow:
    """A stored version, for listings. created_ms : Unix ms of the server's clock."""

    version: int
    active: bool
    surveys: Sequence[int]
    summary: Mapping[str, Any]
    created_ms: int


@dataclass(frozen=True, slots=True)
class ActiveMap:
    """The active radio map of a venue at one revision; version and body are None where none was ever published."""

    revision: int
    version: int | None
    body: bytes | None


class RadioMapRows:
    """Reads and writes versions; every method is one transaction.

    Each raises DependencyDown where the database cannot be reached, having changed nothing.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def active(self, venue: str) -> ActiveMap | None:
        """The active version and the revision that it belongs to, read at one moment; None if there is no venue."""
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(_READ_ACTIVE, {"named": venue})).one_or_none()
        return None if row is None else ActiveMap(*row)

    async def listed(self, venue_id: int) -> list[VersionRow]:
        """Every version, oldest first."""
        query = (
            select(
                radio_maps.c.version,
                (radio_maps.c.version == func.coalesce(venues.c.active_version, 0)).label("active"),
                radio_maps.c.surveys,
                radio_maps.c.summary,
                radio_maps.c.created_ms,
            )
            .join(venues, venues.c.id == radio_maps.c.venue_id)
            .where(radio_maps.c.venue_id == venue_id)
            .order_by(radio_maps.c.version)
        )
        async with reachable(), self._engine.connect() as connection:
            rows = (await connection.execute(query)).all()
        return [VersionRow(row[0], bool(row[1]), *row[2:]) for row in rows]

    async def newest(self, venue_id: int) -> int:
        """The highest number given so far; 0 before the first."""
        async with reachable(), self._engine.connect() as connection:
            return await _newest(connection, venue_id)

    async def add(self, venue_id: int, built: BuiltMap, now_ms: int) -> None:
        """Store a version. Raises OutdatedError, having changed nothing, if it must be built again."""
        async with reachable(LONG_S), self._engine.begin() as connection:
            await lock_venue(connection, venue_id)
            await insert_version(connection, venue_id, built, now_ms)

    async def activate(self, venue_id: int, version: int) -> bool:
        """Make a version the active one; False if there is none of that number."""
        found = select(radio_maps.c.id).where(radio_maps.c.venue_id == venue_id, radio_maps.c.version == version)
        async with reachable(LONG_S), self._engine.begin() as connection:
            await lock_venue(connection, venue_id)
            if await connection.scalar(found) is None:
                return False
            await _activate(connection, venue_id, version)
        return True


def of_version(venue: str, version: int, *columns: ColumnElement[Any]) -> Select[Any]:
    """Columns of a venue and of one of its versions; no row where there is no such version."""
    return (
        select(*columns)
        .select_from(radio_maps)
        .join(venues, venues.c.id == radio_maps.c.venue_id)
        .where(venues.c.venue == venue, radio_maps.c.version == version)
    )


async def lock_venue(connection: AsyncConnection, venue_id: int) -> None:
    """Make every other writer of the venue wait for this transaction: what is read after this cannot change."""
    await connection.execute(update(venues).where(venues.c.id == venue_id).values(revision=venues.c.revision))


async def insert_version(connection: AsyncConnection, venue_id: int, built: BuiltMap, now_ms: int) -> None:
    """Store a version, inside a transaction that holds lock_venue.

    Raises
    ------
    OutdatedError : surveys came, or the number was given away, since it was built.
    """
    ids = select(surveys.c.id).where(surveys.c.venue_id == venue_id)
    if built.complete and set((await connection.scalars(ids)).all()) != set(built.surveys):
        raise OutdatedError
    if await _newest(connection, venue_id) != built.version - 1:
        raise OutdatedError
    values = {
        "venue_id": venue_id,
        "version": built.version,
        "surveys": list(built.surveys),
        "summary": dict(built.summary),
        "body": built.body,
        "created_ms": now_ms,
    }
    map_id = await connection.scalar(insert(radio_maps).values(values).returning(radio_maps.c.id))
    assert map_id is not None  # an insert returns its row
    await _inherit(connection, venue_id, map_id, built)
    if built.active:
        await _activate(connection, venue_id, built.version)


async def _inherit(connection: AsyncConnection, venue_id: int, map_id: int, built: BuiltMap) -> None:
    """Watch what is watched in the version in use, but for what was surveyed after it came onto the list."""
    watched = (
        select(watched_access_points)
        .join(radio_maps, radio_maps.c.id == watched_access_points.c.radio_map_id)
        .join(venues, and_(venues.c.id == radio_maps.c.venue_id, venues.c.active_version == radio_maps.c.version))
        .where(venues.c.id == venue_id, watched_access_points.c.removed_ms.is_(None))
    )
    rows = (await connection.execute(watched)).mappings().all()
    if not rows:
        return
    times = select(surveys.c.id, surveys.c.created_ms).where(surveys.c.id.in_(built.surveys))
    created_ms = {row[0]: row[1] for row in await connection.execute(times)}
    kept = []
    for row in rows:
        last = built.heard.get(row["bssid"])
        if last is None or created_ms[built.surveys[last]] <= row["first_seen_ms"]:
            kept.append({**row, "radio_map_id": map_id})
    if kept:
        await connection.execute(insert(watched_access_points), kept)


async def _activate(connection: AsyncConnection, venue_id: int, version: int) -> None:
    values = {"active_version": version, "revision": venues.c.revision + 1}
    await connection.execute(update(venues).where(venues.c.id == venue_id).values(values))


async def _newest(connection: AsyncConnection, venue_id: int) -> int:
    newest = await connection.scalar(select(func.max(radio_maps.c.version)).where(radio_maps.c.venue_id == venue_id))
    return newest or 0


_READ_ACTIVE = (
    select(venues.c.revision, venues.c.active_version, radio_maps.c.body)
    .outerjoin(radio_maps, and_(radio_maps.c.venue_id == venues.c.id, radio_maps.c.version == venues.c.active_version))
    .where(venues.c.venue == bindparam("named"))
)
