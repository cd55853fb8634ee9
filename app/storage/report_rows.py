"""Quality reports in the database, each stored with the radio-map version that it is of."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import insert, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.database import LONG_S, reachable
from app.storage.radio_map_rows import of_version
from app.storage.tables import radio_map_reports, radio_maps


@dataclass(frozen=True, slots=True)
class VersionKey:
    """What a report of a version is made of. map_id : its key.  surveys : those that it was built of.
    created_ms : when it was, server's clock, Unix."""

    map_id: int
    surveys: tuple[int, ...]
    created_ms: int


@dataclass(frozen=True, slots=True)
class ReportRow:
    """A report. report : JSON.  picture : PNG.  created_ms : server's clock, Unix."""

    report: bytes
    picture: bytes
    created_ms: int


class ReportRows:
    """Reads and writes reports; every method is one transaction.

    Each raises DependencyDown where the database cannot be reached, having changed nothing.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def version(self, venue: str, version: int) -> VersionKey | None:
        """A version of a venue; None if there is none."""
        query = of_version(venue, version, radio_maps.c.id, radio_maps.c.surveys, radio_maps.c.created_ms)
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(query)).one_or_none()
        return None if row is None else VersionKey(row[0], tuple(row[1]), row[2])

    async def body(self, map_id: int) -> bytes:
        """The encoded radio map of a version."""
        async with reachable(), self._engine.connect() as connection:
            body: bytes | None = await connection.scalar(select(radio_maps.c.body).where(radio_maps.c.id == map_id))
        assert body is not None  # a version is never removed
        return body

    async def read(self, venue: str, version: int) -> ReportRow | None:
        """The report of a version; None if there is none yet."""
        of = radio_map_reports.c
        query = of_version(venue, version, of.report, of.picture, of.created_ms)
        query = query.join(radio_map_reports, of.radio_map_id == radio_maps.c.id)
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(query)).one_or_none()
        return None if row is None else ReportRow(*row)

    async def add(self, map_id: int, report: ReportRow) -> bool:
        """Store a report; False if another worker was faster, whose report says the same."""
        values = {
            "radio_map_id": map_id,
            "report": report.report,
            "picture": report.picture,
            "created_ms": report.created_ms,
        }
        try:
            async with reachable(LONG_S), self._engine.begin() as connection:
                await connection.execute(insert(radio_map_reports).values(values))
        except IntegrityError:
            return False
        return True
