"""Surveys and their fingerprints in the database."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

from sqlalchemy import insert, select
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.database import LONG_S, reachable
from app.storage.radio_map_rows import BuiltMap, insert_version, lock_venue
from app.storage.tables import fingerprints, floors, surveys
from app.survey.spool import Row

CHUNK = 500
"""Fingerprints in memory at a time; each is a few kilobytes."""


@dataclass(frozen=True, slots=True)
class NewSurvey:
    """A survey about to be stored. created_ms : Unix ms of the server's clock."""

    format: str
    device: Mapping[str, Any]
    accepted: int
    rejected: int
    created_ms: int


class SurveyRows:
    """Reads and writes surveys.

    Each method raises DependencyDown where the database cannot be reached, having changed nothing.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def ids(self, venue_id: int) -> list[int]:
        """Every survey of a venue, oldest first."""
        query = select(surveys.c.id).where(surveys.c.venue_id == venue_id).order_by(surveys.c.id)
        async with reachable(), self._engine.connect() as connection:
            return list((await connection.scalars(query)).all())

    async def add(
        self,
        venue_id: int,
        survey: NewSurvey,
        rows: Iterable[Row],
        floor_ids: Mapping[str, int],
        built: BuiltMap | None = None,
    ) -> int:
        """Store a survey with all its fingerprints, and the radio map built with it, in one transaction; gives its key.

        Parameters
        ----------
        rows : read while they are stored.  floor_ids : key of every floor that they name.
        built : made of the surveys that it names and this one.

        Raises
        ------
        OutdatedError : the radio map must be built again; nothing was stored.
        """
        values = {
            "venue_id": venue_id,
            "format": survey.format,
            "device": dict(survey.device) or None,
            "accepted": survey.accepted,
            "rejected": survey.rejected,
            "created_ms": survey.created_ms,
        }
        remaining = iter(rows)
        async with reachable(LONG_S), self._engine.begin() as connection:
            if built is not None:
                await lock_venue(connection, venue_id)
            key = await connection.scalar(insert(surveys).values(values).returning(surveys.c.id))
            assert key is not None  # an insert returns its row
            if built is not None:  # before the many rows: if it is outdated they would be for nothing
                made_of = replace(built, surveys=(*built.surveys, key))
                await insert_version(connection, venue_id, made_of, survey.created_ms)
            while chunk := list(islice(remaining, CHUNK)):
                await connection.execute(_INSERT, [_values(key, floor_ids, row) for row in chunk])
        return int(key)

    async def fingerprints(self, survey_ids: Sequence[int]) -> AsyncIterator[list[Row]]:
        """The fingerprints of surveys, in chunks; they never change, so no transaction spans them."""
        for survey in survey_ids:
            after = 0
            while True:
                query = _READ.where(fingerprints.c.survey_id == survey, fingerprints.c.id > after)
                async with reachable(), self._engine.connect() as connection:
                    rows = (await connection.execute(query)).all()
                if not rows:
                    break
                after = rows[-1][0]
                yield [(row[1], row[2], row[3], row[4], row[5], row[6]) for row in rows]


def _values(survey: int, floor_ids: Mapping[str, int], row: Row) -> dict[str, Any]:
    floor, walk, time_s, x_m, y_m, readings = row
    return {
        "survey_id": survey,
        "floor_id": floor_ids[floor],
        "walk": walk,
        "time_s": time_s,
        "x_m": x_m,
        "y_m": y_m,
        "readings": readings,
    }


_INSERT = insert(fingerprints)
_READ = (
    select(
        fingerprints.c.id,
        floors.c.floor,
        fingerprints.c.walk,
        fingerprints.c.time_s,
        fingerprints.c.x_m,
        fingerprints.c.y_m,
        fingerprints.c.readings,
    )
    .join(floors, floors.c.id == fingerprints.c.floor_id)
    .order_by(fingerprints.c.id)
    .limit(CHUNK)
)
