"""For those who run the service: is it alive, is it ready, what has it done."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from fastapi import APIRouter, Depends, Response
from pydantic import BaseModel

from app.api.metrics import Metrics

EXPOSITION = "text/plain; version=0.0.4; charset=utf-8"


class StatusAnswer(BaseModel):
    """`ok`, or `ready`."""

    status: str


def operation_router(metrics: Metrics, ready: Callable[[], Awaitable[None]], reader: Callable[..., Any]) -> APIRouter:
    """The endpoints.

    Parameters
    ----------
    ready : raises DependencyDown while a store cannot be reached or is not migrated.
    reader : dependency that lets pass who may read the metrics.
    """
    router = APIRouter(tags=["operation"])

    @router.head("/healthz", include_in_schema=False)
    @router.get("/healthz", response_model=StatusAnswer, summary="Is the process alive")
    async def healthz() -> StatusAnswer:
        """Asks no store: a process that answers need not be restarted."""
        return StatusAnswer(status="ok")

    @router.head("/readyz", include_in_schema=False)
    @router.get("/readyz", response_model=StatusAnswer, summary="Can it serve")
    async def readyz() -> StatusAnswer:
        """503 while the database or the session store cannot be reached, or the database is not migrated."""
        await ready()
        return StatusAnswer(status="ready")

    @router.get(
        "/metrics",
        response_class=Response,
        responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}},
        dependencies=[Depends(reader)],
        summary="Figures for Prometheus",
    )
    async def figures() -> Response:
        """On a service bound to loopback no key is needed, else scope `admin`."""
        return Response(metrics.exposition(), media_type=EXPOSITION)

    return router
