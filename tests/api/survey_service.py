"""The endpoints of surveys over a real database, with one venue of two floors."""

from __future__ import annotations

import tempfile
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fastapi import FastAPI, Request
from fastapi.testclient import TestClient
from httpx import Response
from sqlalchemy import func, insert, select
from sqlalchemy.ext.asyncio import AsyncEngine

from app.api.geosubmit import geosubmit_router
from app.api.problems import install_problems, problem_document
from app.api.radio_maps import radio_maps_router
from app.api.surveys import surveys_router
from app.api.tasks import tasks_router
from app.errors import Unauthenticated
from app.services.geosubmission import Geosubmission
from app.services.radio_maps import RadioMaps
from app.services.surveys import Surveys
from app.services.tasks import Tasks
from app.services.venues import Venues
from app.services.worker_processes import WorkerProcesses
from app.storage.database import connect
from app.storage.radio_map_rows import RadioMapRows
from app.storage.survey_rows import SurveyRows
from app.storage.tables import fingerprints, floors, metadata, radio_maps, surveys, venues
from app.storage.task_rows import TaskRows
from app.storage.venue_rows import VenueRows

KEY = "key"
LIMIT_BYTES = 60_000_000
SURVEYS = "/v1/venues/mall/surveys"
CLOCK_MS = 1_700_000_000_000
FLOORS = [
    {"floor": "F1", "name": "F1", "level": 0, "latitude_deg": 30.0, "longitude_deg": 120.0, "rotation_rad": 0.0},
    {"floor": "F2", "name": "F2", "level": 1, "latitude_deg": 30.0, "longitude_deg": 120.0, "rotation_rad": 0.0},
]
TABLES = (surveys, fingerprints, radio_maps)


@dataclass
class Wired:
    """The application and its parts."""

    app: FastAPI
    engine: AsyncEngine
    surveys: Surveys
    radio_maps: RadioMaps
    survey_rows: SurveyRows
    map_rows: RadioMapRows
    tasks: Tasks
    clock_ms: list[int]


def wire(url: str, workers: WorkerProcesses, limit_bytes: int = LIMIT_BYTES) -> Wired:
    """The endpoints over that database; the venue `mall` is made at start. The clock is a list of one number."""
    engine = connect(url)
    clock_ms = [CLOCK_MS]

    def now_ms() -> int:
        return clock_ms[0]

    survey_rows, map_rows, venue_rows = SurveyRows(engine), RadioMapRows(engine), VenueRows(engine)
    stored = Venues(venue_rows, now_ms)
    maps = RadioMaps(map_rows, survey_rows, stored, workers, now_ms)
    service = Surveys(survey_rows, stored, maps, workers, now_ms)
    tasks = Tasks(TaskRows(engine), now_ms, problem_document)
    reports = Geosubmission(venue_rows, service, workers, now_ms)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        await make_venue(engine)
        yield
        await tasks.close()
        await engine.dispose()

    async def authorise(request: Request) -> None:
        if request.headers.get("authorization") != f"Bearer {KEY}" and request.query_params.get("key") != KEY:
            raise Unauthenticated("no key")

    app = FastAPI(lifespan=lifespan)
    install_problems(app)
    app.include_router(surveys_router(lambda: service, lambda: tasks, authorise, limit_bytes))
    app.include_router(tasks_router(lambda: tasks, authorise))
    app.include_router(radio_maps_router(lambda: maps, authorise, authorise))
    app.include_router(geosubmit_router(lambda: reports, authorise))
    return Wired(app, engine, service, maps, survey_rows, map_rows, tasks, clock_ms)


async def make_venue(engine: AsyncEngine, venue: str = "mall") -> None:
    """Tables, and a venue of two floors of 100 by 60 m, one above the other."""
    async with engine.begin() as connection:
        await connection.run_sync(metadata.create_all)
        made = insert(venues).values(venue=venue, name=venue, revision=1, created_ms=0).returning(venues.c.id)
        key = await connection.scalar(made)
        rows = [{"venue_id": key, "width_m": 100.0, "height_m": 60.0, **floor} for floor in FLOORS]
        await connection.execute(insert(floors), rows)


@dataclass
class SurveyService:
    """A client of the endpoints, and what is behind them."""

    client: TestClient
    wired: Wired

    def call(self, function: Callable[..., Awaitable[Any]], *arguments: Any) -> Any:
        """What a coroutine function gives, run where the application runs."""
        assert self.client.portal is not None
        return self.client.portal.call(function, *arguments)

    def counts(self) -> dict[str, int]:
        """Rows of every table that surveys write to, and the venues' revisions."""

        async def count() -> dict[str, int]:
            async with self.wired.engine.connect() as connection:
                found = {
                    table.name: await connection.scalar(select(func.count()).select_from(table)) or 0
                    for table in TABLES
                }
                found["revision"] = await connection.scalar(select(func.sum(venues.c.revision))) or 0
            return found

        return dict(self.call(count))

    def upload(self, content: bytes | str, content_type: str, **query: Any) -> Response:
        """A survey as one body."""
        headers = {"Content-Type": content_type}
        answer: Response = self.client.post(SURVEYS, content=content, params=query, headers=headers)
        return answer

    def upload_traces(self, traces: dict[str, bytes], floor: str | None = "F1", **query: Any) -> Response:
        """A survey of trace files."""
        files = [("files", (name, content, "application/octet-stream")) for name, content in traces.items()]
        parameters = query if floor is None else {"floor": floor, **query}
        answer: Response = self.client.post(SURVEYS, params=parameters, files=files)
        return answer


@contextmanager
def survey_service(url: str, workers: WorkerProcesses, limit_bytes: int = LIMIT_BYTES) -> Iterator[SurveyService]:
    """The endpoints over that database, running."""
    wired = wire(url, workers, limit_bytes)
    headers = {"Authorization": f"Bearer {KEY}"}
    with TestClient(wired.app, headers=headers, raise_server_exceptions=False) as client:
        yield SurveyService(client, wired)


def problem(answer: Response, status: int) -> dict[str, Any]:
    """The problem document of a refusal."""
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    return dict(answer.json())


def left_behind() -> set[Path]:
    """Folders of uploads that nobody has removed."""
    return set(Path(tempfile.gettempdir()).glob("surefix-*"))
