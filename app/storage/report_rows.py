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

    async def read(self, venue: str, version: int) -> tuple[VersionKey, ReportRow | None] | None:
        """A version of a venue and its report, None while there is none; None if there is no such version."""
        of, made = radio_maps.c, radio_map_reports.c
        query = of_version(venue, version, of.id, of.surveys, of.created_ms, made.report, made.picture, made.created_ms)
        query = query.outerjoin(radio_map_reports, made.radio_map_id == of.id)
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(query)).one_or_none()
        if row is None:
            return None
        map_id, surveys, created_ms, *report = row
        return VersionKey(map_id, tuple(surveys), created_ms), None if report[0] is None else ReportRow(*report)

    async def body(self, map_id: int) -> bytes:
        """The encoded radio map of a version."""
        async with reachable(), self._engine.connect() as connection:
            body: bytes | None = await connection.scalar(select(radio_maps.c.body).where(radio_maps.c.id == map_id))
        assert body is not None  # a version is never removed
        return body

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
