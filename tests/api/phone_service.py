"""The endpoints of phones over a real database, with a method that tests can foretell."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from fastapi import FastAPI, Request
from fastapi.testclient import TestClient
from httpx import Response
from sqlalchemy import insert, select
from sqlalchemy.ext.asyncio import AsyncEngine

from app.api.events import events_router
from app.api.problems import install_problems
from app.api.sessions import sessions_router
from app.errors import Unauthenticated
from app.floorplan.georeference import Georeference
from app.fusion.interface import Floor, Method, Site
from app.fusion.state_codec import decode_state
from app.services.site_cache import SiteCache, SiteRevision
from app.services.tracking import Tracking
from app.storage.database import connect
from app.storage.session_rows import SessionRows
from app.storage.session_state import HotStates, hot_states
from app.storage.tables import metadata, venues
from tests.odometer import ODOMETER

KEY = "key"
LIMIT_BYTES = 2_000_000
SITE = Site(
    {
        "F1": Floor("F1", 0, 100.0, 60.0, Georeference(30.0, 120.0, 0.0)),
        "F2": Floor("F2", 1, 100.0, 60.0),
    }
)


@dataclass
class Wired:
    """The application and its parts; the clock that it reads, and the venue revisions that it has read."""

    app: FastAPI
    tracking: Tracking
    rows: SessionRows
    engine: AsyncEngine
    hot: HotStates
    clock_ms: list[int]
    loads: list[int]


def wire(
    url: str, sessions: str = "memory", site: Site = SITE, methods: Mapping[str, Method] = MappingProxyType({})
) -> Wired:
    """The endpoints of phones over that database, in which the venue `mall` is made where it is missing."""
    engine = connect(url)
    clock_ms, loads = [1_700_000_000_000], []

    async def load(venue: str) -> SiteRevision:
        async with engine.connect() as connection:
            revision = await connection.scalar(select(venues.c.revision).where(venues.c.venue == venue))
        loads.append(int(revision or 0))
        return SiteRevision(int(revision or 0), site)

    hot = hot_states(sessions, decode_state, 3600.0)
    rows = SessionRows(engine)
    tracking = Tracking(rows, hot, SiteCache(load), {"odometer": ODOMETER, **methods}, 12.0, lambda: clock_ms[0])

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        async with engine.begin() as connection:
            await connection.run_sync(metadata.create_all)
            if await connection.scalar(select(venues.c.venue)) is None:
                await connection.execute(insert(venues).values(venue="mall", name="Mall", revision=1))
        yield
        await hot.close()
        await engine.dispose()

    async def authorise(request: Request) -> None:
        if request.headers.get("authorization") != f"Bearer {KEY}":
            raise Unauthenticated("no key")

    app = FastAPI(lifespan=lifespan)
    install_problems(app)
    app.include_router(sessions_router(lambda: tracking, authorise, LIMIT_BYTES))
    app.include_router(events_router(lambda: tracking, authorise))
    return Wired(app, tracking, rows, engine, hot, clock_ms, loads)


@dataclass
class PhoneService:
    """A client of the endpoints, and what is behind them."""

    client: TestClient
    wired: Wired

    def open(self, **body: Any) -> str:
        """A new session's id."""
        answer = self.client.post("/v1/sessions", json={"venue": "mall", "method": "odometer", **body})
        assert answer.status_code == 201, answer.text
        return str(answer.json()["session"])

    def send(self, session: str, body: dict[str, Any]) -> Response:
        """One batch, as JSON."""
        answer: Response = self.client.post(f"/v1/sessions/{session}/batches", json=body)
        return answer

    def fix(self, session: str, body: dict[str, Any]) -> dict[str, Any]:
        """The Fix of a batch that must be accepted."""
        answer = self.send(session, body)
        assert answer.status_code == 200, answer.text
        return dict(answer.json())

    def call(self, function: Callable[..., Awaitable[Any]], *arguments: Any) -> Any:
        """What a coroutine function gives, run where the application runs."""
        assert self.client.portal is not None
        return self.client.portal.call(function, *arguments)


@contextmanager
def phone_service(
    url: str, sessions: str = "memory", site: Site = SITE, methods: Mapping[str, Method] = MappingProxyType({})
) -> Iterator[PhoneService]:
    """The endpoints over that database, running."""
    wired = wire(url, sessions, site, methods)
    headers = {"Authorization": f"Bearer {KEY}"}
    with TestClient(wired.app, headers=headers, raise_server_exceptions=False) as client:
        yield PhoneService(client, wired)
