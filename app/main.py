"""create_app(): the only place where the parts of the service are wired together."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from importlib.metadata import version
from typing import Any

from fastapi import FastAPI
from sqlalchemy.ext.asyncio import AsyncEngine

from app.api import console, docs
from app.api.access import Gate, QueryGate
from app.api.events import events_router
from app.api.geolocate import geolocate_router
from app.api.geosubmit import geosubmit_router
from app.api.metrics import Metrics, MetricsMiddleware
from app.api.openapi import install_openapi
from app.api.operation import operation_router
from app.api.phones import phones_router
from app.api.problems import install_problems, problem_document
from app.api.quality import quality_router
from app.api.radio_maps import radio_maps_router
from app.api.sessions import sessions_router
from app.api.surveys import surveys_router
from app.api.tasks import tasks_router
from app.api.venues import venues_router
from app.api.watch_lists import watch_lists_router
from app.api.webhooks import webhooks_router
from app.errors import DependencyDown
from app.fusion.methods import METHODS
from app.fusion.state_codec import decode_state
from app.fusion.warm_up import warm_up
from app.services.access import Access, Scope, is_loopback
from app.services.geolocation import Geolocation
from app.services.geosubmission import Geosubmission
from app.services.left_behind import remove_left_behind
from app.services.map_use import MapUse
from app.services.phones import Phones
from app.services.quality import Quality
from app.services.radio_maps import RadioMaps
from app.services.server_clock import server_ms
from app.services.session_news import SessionNews
from app.services.site_cache import SiteCache
from app.services.site_reading import SiteReader
from app.services.surveys import Surveys
from app.services.tasks import Tasks
from app.services.tracking import Tracking
from app.services.venues import Venues
from app.services.watch_lists import WatchLists
from app.services.webhook_delivery import WebhookDelivery
from app.services.webhooks import Webhooks
from app.services.worker_processes import WorkerProcesses
from app.settings import Settings
from app.storage.database import connect
from app.storage.key_rows import KeyRows
from app.storage.map_use_rows import MapUseRows
from app.storage.migration import require_migrated
from app.storage.outbox_rows import OutboxRows
from app.storage.phone_rows import PhoneRows
from app.storage.radio_map_rows import RadioMapRows
from app.storage.report_rows import ReportRows
from app.storage.session_rows import SessionRows
from app.storage.session_state import HotStates, hot_states
from app.storage.survey_rows import SurveyRows
from app.storage.task_rows import TaskRows
from app.storage.venue_rows import VenueRows
from app.storage.watch_list_rows import WatchListRows
from app.storage.webhook_rows import WebhookRows

PURGE_EVERY_S = 600.0
"""How long what an expired session has left may outlive it."""
_log = logging.getLogger(__name__)


def create_app(settings: Settings | None = None) -> FastAPI:
    """The service; connects to its stores at first use.

    Parameters
    ----------
    settings : default: from the environment, as in workers that a supervisor starts.

    Raises
    ------
    InvalidInput : a setting names a store that is not supported.
    """
    settings = settings or Settings()
    engine = connect(settings.database)
    hot = hot_states(settings.sessions, decode_state, settings.session_hours * 3600.0)
    venue_rows, map_rows, survey_rows = VenueRows(engine), RadioMapRows(engine), SurveyRows(engine)
    session_rows, watch_rows = SessionRows(engine), WatchListRows(engine)
    sites = SiteCache(SiteReader(venue_rows, map_rows, watch_rows).read)
    watch_lists = WatchLists(watch_rows, server_ms, settings.watch_sessions, settings.watch_share, settings.watch_hours)
    metrics = Metrics()
    map_use = MapUse(MapUseRows(engine), server_ms, metrics.resurvey)
    listeners = watch_lists.heard, map_use.heard
    tracking = Tracking(session_rows, hot, sites, METHODS, settings.session_hours, server_ms, listeners)
    workers, tasks = WorkerProcesses(), Tasks(TaskRows(engine), server_ms, problem_document)
    venues = Venues(venue_rows, server_ms)
    radio_maps = RadioMaps(map_rows, survey_rows, venues, workers, server_ms)
    surveys = Surveys(survey_rows, venues, radio_maps, workers, server_ms)
    quality = Quality(ReportRows(engine), survey_rows, venues, watch_lists, map_use, workers, tasks, server_ms)
    geolocation = Geolocation(venue_rows, sites)
    news = SessionNews(session_rows, tracking.announcements, server_ms)
    delivery = WebhookDelivery(OutboxRows(engine), tracking.announcements, server_ms)
    forgetting = tracking.purge, watch_lists.forget, map_use.forget, remove_left_behind
    loopback = is_loopback(settings.host)
    app = FastAPI(
        title="Surefix",
        version=version("surefix"),
        description="Indoor positioning that says when not to trust it.",
        redirect_slashes=False,  # a redirect is no problem document, and loses the body
        docs_url=None,  # app/api/docs.py, which needs no internet
        redoc_url=None,
        lifespan=_lifespan(
            (partial(_purge_now_and_then, *forgetting), map_use.run, news.run, delivery.run),
            (map_use.close, tasks.close, workers.close, hot.close, engine.dispose),
        ),
    )
    app.add_middleware(MetricsMiddleware, metrics=metrics)
    install_problems(app)
    install_openapi(app)

    access = Access(KeyRows(engine), open_without_keys=loopback)
    position, admin, anyone = Gate(access, Scope.POSITION), Gate(access, Scope.ADMIN), Gate(access, *Scope)
    surveying = Scope.SURVEY, Scope.ADMIN
    given_tracking = _given(tracking)
    for router in (
        sessions_router(given_tracking, position, settings.batch_limit_bytes),
        events_router(given_tracking, position),
        geolocate_router(_given(geolocation), QueryGate(access, Scope.POSITION)),
        venues_router(_given(venues), anyone, admin, workers),
        surveys_router(_given(surveys), _given(tasks), Gate(access, *surveying), settings.survey_limit_bytes),
        tasks_router(_given(tasks), Gate(access, *surveying)),
        radio_maps_router(_given(radio_maps), anyone, Gate(access, *surveying)),
        geosubmit_router(_given(Geosubmission(venue_rows, surveys, workers, server_ms)), QueryGate(access, *surveying)),
        phones_router(_given(Phones(PhoneRows(engine, settings.session_hours), server_ms)), admin),
        quality_router(_given(quality), Gate(access, *surveying)),
        watch_lists_router(_given(watch_lists), admin),
        webhooks_router(_given(Webhooks(WebhookRows(engine), venues, server_ms)), admin),
        operation_router(metrics, _readiness(engine, hot), _nobody_asked if loopback else admin),
        console.router,
        docs.router,
    ):
        app.include_router(router)
    return app


def _given(service: Any) -> Callable[[], Awaitable[Any]]:
    """A service as a dependency; a coroutine, because FastAPI sends plain functions to another thread."""

    async def dependency() -> Any:
        return service

    return dependency


async def _nobody_asked() -> None:
    """The dependency that lets everyone pass."""


def _lifespan(
    beside: Sequence[Callable[[], Coroutine[Any, Any, None]]], closing: Sequence[Callable[[], Awaitable[None]]]
) -> Callable[[FastAPI], Any]:
    """Compiles before the first request, runs what goes on beside requests, and closes in order at the end."""

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        await asyncio.to_thread(warm_up)  # no request waits for a compiler
        async with AsyncExitStack() as stack:
            for close in reversed(closing):
                stack.push_async_callback(close)
            running = [asyncio.create_task(one()) for one in beside]
            for task in running:
                task.add_done_callback(_tell_if_failed)
            yield
            for task in running:
                task.cancel()
            await asyncio.gather(*running, return_exceptions=True)

    return lifespan


def _tell_if_failed(task: asyncio.Task[None]) -> None:
    if not task.cancelled() and (error := task.exception()) is not None:
        _log.error("what goes on beside requests has stopped; restart the service", exc_info=error)


async def _purge_now_and_then(*purges: Callable[[], Awaitable[object]]) -> None:
    while True:
        try:
            for purge in purges:
                await purge()
        except DependencyDown as error:
            _log.warning("what has expired is erased later: %s", error)
        await asyncio.sleep(PURGE_EVERY_S)


def _readiness(engine: AsyncEngine, hot: HotStates) -> Callable[[], Awaitable[None]]:
    async def ready() -> None:
        await require_migrated(engine)
        await hot.ping()

    return ready
