"""Quality reports of radio-map versions: made when first asked for, stored with the version, and what use adds."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson

from app.errors import NotFound, SurefixError
from app.services.quality_report import ReportFloor, made_report
from app.services.tasks import Tasks, TaskStatus
from app.services.venues import Venues, georeference_of
from app.services.watch_lists import WatchLists, WatchState
from app.services.worker_processes import WorkerProcesses
from app.storage.report_rows import ReportRow, ReportRows, VersionKey
from app.storage.survey_rows import SurveyRows
from app.survey.spool import write_row
from app.wifi.bssid import format_bssid


@dataclass(frozen=True, slots=True)
class QualityReport:
    """A report as it stands now. described : JSON's objects.  picture : PNG."""

    described: dict[str, Any]
    picture: bytes


class Quality:
    """Gives reports, and has those made that nobody has asked for before.

    Parameters
    ----------
    now_ms : the server's clock.
    """

    def __init__(
        self,
        rows: ReportRows,
        surveys: SurveyRows,
        venues: Venues,
        watch_lists: WatchLists,
        workers: WorkerProcesses,
        tasks: Tasks,
        now_ms: Callable[[], int],
    ) -> None:
        self._rows = rows
        self._surveys = surveys
        self._venues = venues
        self._watch_lists = watch_lists
        self._workers = workers
        self._tasks = tasks
        self._now_ms = now_ms
        self._making: dict[int, str] = {}
        self._turn = asyncio.Lock()

    async def report(self, venue: str, version: int) -> QualityReport | str:
        """The report of a version, or, until it is made, the name of the task that makes it.

        Raises
        ------
        NotFound : there is no such version.
        DependencyDown : the database cannot be reached.
        """
        stored = await self._rows.read(venue, version)
        if stored is None:
            return await self._begin(venue, version)
        described = orjson.loads(stored.report)
        described["created"] = stored.created_ms
        described["drift"] = await self._drift(venue, version, described.pop("strongest"))
        return QualityReport(described, stored.picture)

    async def _begin(self, venue: str, version: int) -> str:
        key = await self._rows.version(venue, version)
        if key is None:
            raise NotFound(f"venue {venue[:64]!r} has no radio map version {version}")
        async with self._turn:
            task = self._making.get(key.map_id)
            if task is None:
                task = self._making[key.map_id] = await self._tasks.start(lambda: self._job(venue, key))
        return task

    async def _job(self, venue: str, key: VersionKey) -> tuple[TaskStatus, bytes]:
        try:
            report, picture = await self._made(venue, key)
            await self._rows.add(key.map_id, ReportRow(report, picture, self._now_ms()))
        except SurefixError as error:
            document = {"type": "about:blank", "title": "The report could not be made", "detail": str(error)}
            return TaskStatus.FAILED, orjson.dumps(document)
        finally:
            self._making.pop(key.map_id, None)
        return TaskStatus.DONE, b""

    async def _made(self, venue: str, key: VersionKey) -> tuple[bytes, bytes]:
        floors = []
        for row in (await self._venues.read(venue))[1]:
            plan = await self._venues.plan(venue, row.floor) if row.has_plan else None
            image = await self._venues.image(venue, row.floor) if row.has_image else None
            floors.append(ReportFloor(row.floor, row.width_m, row.height_m, georeference_of(row), plan, image))
        with tempfile.TemporaryDirectory(prefix="surefix-quality-") as folder:
            spool = Path(folder) / "fingerprints"
            with spool.open("wb") as stream:
                async for rows in self._surveys.fingerprints(key.surveys):
                    for one in rows:
                        write_row(stream, one)
            return await self._workers.run(made_report, spool, await self._rows.body(key.map_id), floors)

    async def _drift(self, venue: str, version: int, strongest: dict[str, list[Any]]) -> dict[str, Any]:
        """How much of the map use has shown to be no longer true: the share of its access points that are watched.

        Where each was heard strongest in the survey is where to survey again.
        """
        again = []
        for one in await self._watch_lists.listed(venue, version):
            bssid = format_bssid(one.row.bssid)
            if one.state is WatchState.REMOVED or bssid not in strongest:
                continue
            floor, x_m, y_m = strongest[bssid]
            again.append({"floor": floor, "x": x_m, "y": y_m, "bssid": bssid, "reason": one.row.reason})
        return {"score": len(again) / len(strongest) if strongest else 0.0, "resurvey": again}
