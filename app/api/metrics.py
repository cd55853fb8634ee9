"""What Prometheus reads: requests, batches, fixes and sessions, counted where the answers go out.

Counting on the wire keeps the services free of it, and counts what phones really got.
"""

from __future__ import annotations

import os
import time
from typing import Any

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    ProcessCollector,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.multiprocess import MultiProcessCollector
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.services.fix_document import flag_of

SHARED_FOLDER = "PROMETHEUS_MULTIPROC_DIR"
"""Environment variable by which several workers add up; prometheus_client reads it when it is imported."""
BATCH_ROUTE = "/v1/sessions/{session}/batches"
SESSION_ROUTE = "/v1/sessions"
UNKNOWN_ROUTE = "none"
_SECONDS = (0.001, 0.002, 0.003, 0.005, 0.0075, 0.01, 0.015, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0)
disable_created_metrics()  # type: ignore[no-untyped-call]  # a second series for each, which says nothing that `process_start_time_seconds` does not


class Metrics:
    """The figures of one application."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        ProcessCollector(registry=self.registry)
        self._requests = Counter(
            "surefix_requests", "Requests answered.", ("method", "route", "status"), registry=self.registry
        )
        self._seconds = Histogram(
            "surefix_request_seconds",
            "From a request's head to its answer's.",
            ("method", "route"),
            registry=self.registry,
            buckets=_SECONDS,
        )
        self._batches = Histogram(
            "surefix_batch_seconds", "The same, of accepted batches.", registry=self.registry, buckets=_SECONDS
        )
        self._fixes = Counter("surefix_fixes", "New fixes by integrity flag.", ("flag",), registry=self.registry)
        self._sessions = Counter("surefix_sessions_opened", "Sessions opened.", registry=self.registry)

        self._resurvey = Gauge(
            "surefix_resurvey_squares",
            "Squares of the radio map in use that have become unlike their survey.",
            ("venue",),
            registry=self.registry,
            multiprocess_mode="mostrecent",
        )

    def resurvey(self, venue: str, squares: int) -> None:
        """A venue's radio map has been judged by its use."""
        self._resurvey.labels(venue).set(squares)

    def answered(self, method: str, route: str, status: int, seconds: float) -> None:
        """An answer has begun."""
        self._requests.labels(method, route, str(status)).inc()
        self._seconds.labels(method, route).observe(seconds)
        if status == 201 and route == SESSION_ROUTE:
            self._sessions.inc()

    def fixed(self, fix: bytes, seconds: float) -> None:
        """A batch led to a new Fix."""
        self._batches.observe(seconds)
        self._fixes.labels(flag_of(fix).value).inc()

    def exposition(self) -> bytes:
        """Everything in Prometheus' text format, of all workers together."""
        if SHARED_FOLDER not in os.environ:
            return bytes(generate_latest(self.registry))
        together = CollectorRegistry()
        MultiProcessCollector(together)  # type: ignore[no-untyped-call]
        return bytes(generate_latest(together))


class MetricsMiddleware:
    """Counts around an application, without a task or a copy of a body of its own."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        began = time.perf_counter()
        fresh_fix = False

        async def counted(message: Message) -> None:
            nonlocal fresh_fix
            if message["type"] == "http.response.start":
                self._metrics.answered(_method(scope), _route(scope), message["status"], time.perf_counter() - began)
                fresh_fix = _route(scope) == BATCH_ROUTE and message["status"] == 200 and not _replayed(message)
            elif fresh_fix:
                fresh_fix = False
                self._metrics.fixed(message.get("body", b""), time.perf_counter() - began)
            await send(message)

        try:
            await self._app(scope, receive, counted)
        except Exception:
            # answered outside of this middleware, with 500
            self._metrics.answered(_method(scope), _route(scope), 500, time.perf_counter() - began)
            raise


def _route(scope: Scope) -> str:
    """The template of the path: one label for all sessions, and one for everything that is not part of the service."""
    route: Any = scope.get("route")
    return str(getattr(route, "path", UNKNOWN_ROUTE))


def _method(scope: Scope) -> str:
    """The method; of unknown routes one label for all, which a stranger cannot multiply."""
    return str(scope["method"]) if "route" in scope else UNKNOWN_ROUTE


def _replayed(message: Message) -> bool:
    return any(name == b"idempotent-replayed" for name, _ in message.get("headers", ()))
