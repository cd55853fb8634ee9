"""Quality reports of radio-map versions: made when first asked for, stored with the version, and what use adds."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import orjson

from app.errors import DependencyDown, SurefixError, told_as
from app.services.identifiers import is_identifier, no_version
from app.services.left_behind import ShortLived
from app.services.map_drift import described_drift
from app.services.map_use import MapUse
from app.services.quality_report import ReportFloor, made_report
from app.services.resurvey_overlay import overlaid
from app.services.tasks import Tasks
from app.services.venues import Venues
from app.services.watch_lists import WatchLists, WatchState
from app.services.worker_processes import WorkerProcesses
from app.storage.report_rows import ReportRow, ReportRows, VersionKey
from app.storage.survey_rows import SurveyRows
from app.survey.spool import write_row
from app.wifi.bssid import format_bssid
from app.wifi.survey_likeness import stored_likeness

AGAIN_MS = 600_000
"""After a report could not be made, until it is tried again."""


@dataclass(frozen=True, slots=True)
class QualityReport:
    """A report as it stands now. described : JSON's objects.  picture : PNG, without what use has shown since.
    canvases : where on it each floor is."""

    described: dict[str, Any]
    picture: bytes
    canvases: dict[str, Any]

    def drawn(self) -> bytes:
        """The picture with where to survey again; takes a while where there is such a place."""
        squares = self.described["drift"]["resurvey"]
        return overlaid(self.picture, self.canvases, squares) if squares else self.picture


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
        map_use: MapUse,
        workers: WorkerProcesses,
        tasks: Tasks,
        now_ms: Callable[[], int],
    ) -> None:
        self._rows = rows
        self._surveys = surveys
        self._venues = venues
        self._watch_lists = watch_lists
        self._map_use = map_use
        self._workers = workers
        self._tasks = tasks
        self._now_ms = now_ms
        self._making: dict[int, str] = {}
        self._failed_ms: dict[int, int] = {}
        self._turn = asyncio.Lock()

    async def report(self, venue: str, version: int) -> QualityReport | str:
        """The report of a version, or, until it is made, the name of the task that makes it.

        Raises
        ------
        NotFound : there is no such version.
        DependencyDown : the database cannot be reached.
        SurefixError : it could not be made a short while ago; trying at every request would help nobody.
        """
        found = await self._rows.read(venue, version) if is_identifier(venue) else None
        if found is None:
            raise no_version(venue, version)
        key, stored = found
        if stored is None:
            return await self._begin(venue, version, key)
        described = orjson.loads(stored.report)
        described["created"] = stored.created_ms
        use = await self._use(venue, version, key, described.pop("likeness"), described.pop("floor_names"))
        described["drift"] = {**use, **await self._watched(venue, version, described.pop("strongest"))}
        return QualityReport(described, stored.picture, described.pop("canvases"))

    async def _begin(self, venue: str, version: int, key: VersionKey) -> str:
        if self._now_ms() - self._failed_ms.get(key.map_id, -AGAIN_MS) < AGAIN_MS:
            raise SurefixError("this report cannot be made; when that was tried the log said why")
        async with self._turn:
            task = self._making.get(key.map_id)
            if task is None:
                task = self._making[key.map_id] = await self._tasks.start(lambda: self._job(venue, version, key))
        return task

    async def _job(self, venue: str, version: int, key: VersionKey) -> bytes:
        try:
            report, picture = await self._made(venue, version, key)
            await self._rows.add(key.map_id, ReportRow(report, picture, self._now_ms()))
        except Exception as error:
            if not isinstance(told_as(error), DependencyDown):
                self._failed_ms[key.map_id] = self._now_ms()
            raise
        finally:
            self._making.pop(key.map_id, None)
        return b""  # it is read where it was asked for

    async def _made(self, venue: str, version: int, key: VersionKey) -> tuple[bytes, bytes]:
        floors = []
        for row in (await self._venues.read(venue))[1]:
            plan = await self._venues.plan(venue, row.floor) if row.has_plan else None
            image = await self._venues.image(venue, row.floor) if row.has_image else None
            floors.append(ReportFloor(row.floor, row.width_m, row.height_m, row.georeference, plan, image))
        with tempfile.TemporaryDirectory(prefix=ShortLived.QUALITY) as folder:
            spool = Path(folder) / "fingerprints"
            with spool.open("wb") as stream:
                async for rows in self._surveys.fingerprints(key.surveys):
                    for one in rows:
                        write_row(stream, one)
            made = datetime.fromtimestamp(key.created_ms / 1000.0, UTC).strftime("%Y-%m-%d")
            title = f"{venue}, radio map version {version} of {made}"
            return await self._workers.run(made_report, spool, await self._rows.body(key.map_id), floors, title)

    async def _use(
        self, venue: str, version: int, key: VersionKey, likeness: dict[str, Any], floors: list[str]
    ) -> dict[str, Any]:
        """What the scans of sessions say of the map."""
        learnt = stored_likeness({name: np.array(rows, np.float64) for name, rows in likeness.items()})
        assert learnt is not None  # every report has it
        since_ms = max(self._map_use.since_ms(), key.created_ms)  # the period may have begun before there was a map
        return described_drift(await self._map_use.drift(venue, version, learnt, floors), since_ms)

    async def _watched(self, venue: str, version: int, strongest: dict[str, list[Any]]) -> dict[str, Any]:
        """How many of the map's access points are no longer relied on, and where each was heard strongest."""
        listed = []
        for one in await self._watch_lists.listed(venue, version):
            bssid = format_bssid(one.row.bssid)
            if one.state is WatchState.REMOVED or bssid not in strongest:
                continue
            floor, x_m, y_m = strongest[bssid]
            listed.append({"floor": floor, "x": x_m, "y": y_m, "bssid": bssid, "reason": one.row.reason})
        share = len(listed) / len(strongest) if strongest else 0.0
        return {"watched_share": share, "access_points": listed}
