"""Surveys: from an upload in files to fingerprints in the database and, if wished, a new active radio map."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from app.errors import Conflict
from app.services.left_behind import ShortLived
from app.services.radio_maps import ATTEMPTS, RadioMaps
from app.services.venues import Venues, floor_extent
from app.services.worker_processes import WorkerProcesses
from app.storage.radio_map_rows import OutdatedError
from app.storage.survey_rows import NewSurvey, SurveyRows
from app.survey.admission import FloorExtent
from app.survey.rejection import Rejection
from app.survey.spool import Row, read_rows
from app.survey.upload import SurveyFindings, SurveyFormat, Upload, read_upload


@dataclass(frozen=True, slots=True)
class Receipt:
    """What became of an upload.

    accepted : fingerprints that landed.  rejected : the first rejections; rejected_count : all of them.
    version : the radio map that was published with it, None if none was.
    """

    survey: int
    accepted: int
    rejected: tuple[Rejection, ...]
    rejected_count: int
    version: int | None


class Surveys:
    """Takes surveys in.

    Each method raises NotFound where there is no such venue, DependencyDown where the database cannot be reached.

    Parameters
    ----------
    now_ms : the server's clock.
    """

    def __init__(
        self,
        rows: SurveyRows,
        venues: Venues,
        radio_maps: RadioMaps,
        workers: WorkerProcesses,
        now_ms: Callable[[], int],
    ) -> None:
        self._rows = rows
        self._venues = venues
        self._radio_maps = radio_maps
        self._workers = workers
        self._now_ms = now_ms

    async def floors(self, venue: str) -> tuple[int, dict[str, int], dict[str, FloorExtent]]:
        """The venue's key, the key of each floor, and the extent of each floor."""
        found, rows = await self._venues.read(venue)
        return found.id, {row.floor: row.id for row in rows}, {row.floor: floor_extent(row) for row in rows}

    async def add(self, venue: str, upload: Upload, publish: bool) -> Receipt:
        """Read an upload and store it, all of it or nothing.

        Parameters
        ----------
        publish : also build the next radio map of every survey of the venue and make it the active one, in the same
            transaction.

        Raises
        ------
        InvalidInput : nothing of the upload can be used; names the field.
        NotFound : the venue, or the floor that the upload is of.
        Conflict : others kept publishing meanwhile.
        """
        venue_id, floor_ids, extents = await self.floors(venue)
        with tempfile.TemporaryDirectory(prefix=ShortLived.SURVEY) as folder:
            spool = Path(folder) / "fingerprints"
            findings = await self._workers.run(read_upload, upload, extents, spool)
            return await self.land(venue_id, floor_ids, upload.format, findings, spool, publish)

    async def land(
        self,
        venue_id: int,
        floor_ids: Mapping[str, int],
        kind: SurveyFormat,
        findings: SurveyFindings,
        spool: Path,
        publish: bool,
    ) -> Receipt:
        """Store the fingerprints of a spool. Raises Conflict as add does."""
        survey = NewSurvey(
            kind.value, findings.device, findings.accepted, findings.rejected_count, created_ms=self._now_ms()
        )
        version = None
        if publish:
            async with self._radio_maps.turn(venue_id):
                key, version = await self._publish(venue_id, floor_ids, survey, spool)
        else:
            key = await self._rows.add(venue_id, survey, _rows_of(spool), floor_ids)
        return Receipt(key, findings.accepted, findings.rejected, findings.rejected_count, version)

    async def _publish(
        self, venue_id: int, floor_ids: Mapping[str, int], survey: NewSurvey, spool: Path
    ) -> tuple[int, int]:
        """Store a survey and the radio map with it; gives their numbers."""
        for _ in range(ATTEMPTS):
            present = await self._rows.ids(venue_id)
            built = await self._radio_maps.built(venue_id, present, complete=True, active=True, addition=spool)
            try:
                return await self._rows.add(venue_id, survey, _rows_of(spool), floor_ids, built), built.version
            except OutdatedError:
                continue
        raise Conflict("others kept publishing radio maps of this venue; nothing was stored, send the survey again")


def _rows_of(spool: Path) -> Iterator[Row]:
    with spool.open("rb") as stream:
        yield from read_rows(stream)
