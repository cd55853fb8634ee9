"""Quality reports of radio-map versions, as JSON, as a picture and as a page."""

from __future__ import annotations

from asyncio import to_thread
from collections.abc import Callable
from typing import Any

import orjson
from fastapi import APIRouter, Depends, Request, Response

from app.api.access import bearer_key
from app.api.quality_body import QualityBody
from app.api.quality_page import page_of, waiting_page
from app.api.radio_maps import Version
from app.api.report_document import HEADERS
from app.api.tasks import StartedBody, started, task_path
from app.services.quality import Quality

PNG = "image/png"
HTML = "text/html"
AGAIN_S = 5
"""When to ask again for a report that is being made."""
_AGAIN = {"Retry-After": str(AGAIN_S)}


def quality_router(quality: Callable[..., Any], survey: Callable[..., Any]) -> APIRouter:
    """The endpoints.

    Parameters
    ----------
    quality : dependency that gives the Quality.  survey : dependency that lets pass who may survey.
    """
    router = APIRouter(
        prefix="/v1/venues/{venue}/radio-maps/{version}", tags=["integrity"], dependencies=[Depends(survey)]
    )
    waiting: dict[int | str, dict[str, Any]] = {202: {"model": StartedBody, "description": "it is being made"}}

    @router.get(
        "/quality",
        responses={200: {"model": QualityBody}, **waiting},
        response_class=Response,
        summary="How good a radio map is",
    )
    async def report(venue: str, version: Version, service: Quality = Depends(quality)) -> Response:
        """Told from the survey by itself: every walk is placed by all the others. Made when it is first asked for,
        which is answered 202 until it is done; `drift` is of now."""
        found = await service.report(venue, version)
        if isinstance(found, str):
            return started(found, _AGAIN)
        return Response(orjson.dumps(found.described), media_type="application/json")

    @router.get(
        "/quality.png",
        responses={200: {"content": {PNG: {"schema": {"type": "string", "format": "binary"}}}}, **waiting},
        response_class=Response,
        summary="The same as a picture",
    )
    async def picture(venue: str, version: Version, service: Quality = Depends(quality)) -> Response:
        """A row for each floor: error and protection level over the plan; gaps, look-alike places, and where to survey
        again."""
        found = await service.report(venue, version)
        return (
            started(found, _AGAIN) if isinstance(found, str) else Response(await to_thread(found.drawn), media_type=PNG)
        )

    @router.get(
        "/quality.html",
        responses={
            200: {"content": {HTML: {"schema": {"type": "string"}}}},
            202: {
                "content": {HTML: {"schema": {"type": "string"}}},
                "description": "it is being made; loads itself again where no key was needed",
            },
        },
        response_class=Response,
        summary="The same as a page",
    )
    async def page(venue: str, version: Version, request: Request, service: Quality = Depends(quality)) -> Response:
        """A file by itself, the picture within."""
        found = await service.report(venue, version)
        if isinstance(found, str):
            headers = {"Location": task_path(found), **_AGAIN, **HEADERS}
            again_s = None if bearer_key(request) else AGAIN_S  # a browser that reloads a page sends no key
            return Response(waiting_page(venue, version, again_s), 202, headers, media_type=HTML)
        return Response(page_of(venue, found.described, await to_thread(found.drawn)), headers=HEADERS, media_type=HTML)

    return router
