"""Scans that survey apps report by latitude and longitude, as surveys of the venues that they were taken in."""

from __future__ import annotations

import asyncio
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from app.services.left_behind import ShortLived
from app.services.surveys import Surveys
from app.services.venues import floor_extent
from app.storage.venue_rows import FloorRow, VenueRows
from app.survey.geosubmit import PlacedFloor, placed_reports
from app.survey.spool import row_of, write_row
from app.survey.upload import SurveyFindings, SurveyFormat
from app.wifi.fingerprint import Fingerprint


class Geosubmission:
    """Takes reports in. They enter the radio map when its next version is built.

    Parameters
    ----------
    now_ms : the server's clock.
    """

    def __init__(self, venues: VenueRows, surveys: Surveys, now_ms: Callable[[], int]) -> None:
        self._venues = venues
        self._surveys = surveys
        self._now_ms = now_ms

    async def add(self, reports: Sequence[Any]) -> int:
        """Store what can be used, one survey a venue; gives how many reports that were.

        Raises
        ------
        DependencyDown : the database cannot be reached.
        """
        floors = [floor for row in await self._venues.floors() if (floor := _placed(row)) is not None]
        by_venue = await asyncio.to_thread(_by_venue, reports, floors, self._now_ms())
        for venue, fingerprints in by_venue.items():
            await self._land(venue, fingerprints)
        return sum(map(len, by_venue.values()))

    async def _land(self, venue: str, fingerprints: Sequence[Fingerprint]) -> None:
        venue_id, floor_ids, _ = await self._surveys.floors(venue)
        findings = SurveyFindings({}, Counter(one.floor for one in fingerprints))
        with tempfile.TemporaryDirectory(prefix=ShortLived.GEOSUBMIT) as folder:
            spool = Path(folder) / "fingerprints"
            await asyncio.to_thread(_write, spool, fingerprints)
            await self._surveys.land(venue_id, floor_ids, SurveyFormat.GEOSUBMIT, findings, spool, publish=False)


def _by_venue(reports: Sequence[Any], floors: Sequence[PlacedFloor], now_ms: int) -> dict[str, list[Fingerprint]]:
    by_venue: dict[str, list[Fingerprint]] = {}
    for venue, fingerprint in placed_reports(reports, floors, now_ms):
        by_venue.setdefault(venue, []).append(fingerprint)
    return by_venue


def _write(spool: Path, fingerprints: Sequence[Fingerprint]) -> None:
    with spool.open("wb") as stream:
        for fingerprint in fingerprints:
            write_row(stream, row_of(fingerprint))


def _placed(row: FloorRow) -> PlacedFloor | None:
    if row.georeference is None:
        return None
    return PlacedFloor(row.venue, row.level, floor_extent(row), row.georeference)
