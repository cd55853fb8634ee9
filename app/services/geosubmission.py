"""Scans that survey apps report by latitude and longitude, as surveys of the venues that they were taken in."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from app.services.left_behind import ShortLived
from app.services.surveys import Surveys
from app.services.venues import floor_extent
from app.services.worker_processes import WorkerProcesses
from app.storage.venue_rows import FloorRow, VenueRows
from app.survey.geosubmit import PlacedFloor, placed_reports, reports_of
from app.survey.spool import row_of, write_row
from app.survey.upload import SurveyFindings, SurveyFormat
from app.wifi.fingerprint import Fingerprint


class Geosubmission:
    """Takes reports in. They enter the radio map when its next version is built.

    Parameters
    ----------
    now_ms : the server's clock.
    """

    def __init__(
        self, venues: VenueRows, surveys: Surveys, workers: WorkerProcesses, now_ms: Callable[[], int]
    ) -> None:
        self._venues = venues
        self._surveys = surveys
        self._workers = workers
        self._now_ms = now_ms

    async def add(self, sent: bytes) -> int:
        """Store what of a body can be used, one survey a venue; gives how many reports that were.

        Raises
        ------
        InvalidInput : the body holds no list of reports.
        DependencyDown : the database cannot be reached.
        """
        floors = [floor for row in await self._venues.floors() if (floor := _placed(row)) is not None]
        with tempfile.TemporaryDirectory(prefix=ShortLived.GEOSUBMIT) as folder:
            found = await self._workers.run_of(len(sent), _spooled, sent, floors, self._now_ms(), Path(folder))
            for venue, (spool, findings) in found.items():
                venue_id, floor_ids, _ = await self._surveys.floors(venue)
                await self._surveys.land(venue_id, floor_ids, SurveyFormat.GEOSUBMIT, findings, spool, publish=False)
        return sum(findings.accepted for _, findings in found.values())


def _spooled(
    sent: bytes, floors: Sequence[PlacedFloor], now_ms: int, folder: Path
) -> dict[str, tuple[Path, SurveyFindings]]:
    """The fingerprints of a body in a spool for each venue."""
    by_venue: dict[str, list[Fingerprint]] = {}
    for venue, fingerprint in placed_reports(reports_of(sent), floors, now_ms):
        by_venue.setdefault(venue, []).append(fingerprint)
    found = {}
    for number, (venue, fingerprints) in enumerate(by_venue.items()):
        spool = folder / str(number)
        with spool.open("wb") as stream:
            for fingerprint in fingerprints:
                write_row(stream, row_of(fingerprint))
        found[venue] = spool, SurveyFindings({}, Counter(one.floor for one in fingerprints))
    return found


def _placed(row: FloorRow) -> PlacedFloor | None:
    if row.georeference is None:
        return None
    return PlacedFloor(row.venue, row.level, floor_extent(row), row.georeference)
