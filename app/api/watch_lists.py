"""Watch lists of radio-map versions: what is left out, by whom it was found, and taking it off again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, Request, Response
from pydantic import BaseModel, Field

from app.api import examples
from app.api.json_bodies import FROM_ADMINISTRATORS, parse_admin, read_json, request_body
from app.api.radio_maps import Version
from app.services.watch_lists import LONGEST_REASON, WatchedAccessPoint, WatchLists
from app.wifi.bssid import format_bssid

BODY_LIMIT_BYTES = 10_000


class WatchBody(BaseModel):
    """An access point to leave out, and why."""

    model_config = FROM_ADMINISTRATORS

    bssid: Annotated[str, Field(max_length=40, description="a MAC address")]
    reason: Annotated[str, Field(min_length=1, max_length=LONGEST_REASON, pattern=r"^[^\x00-\x1f\x7f]+$")] = "by hand"


class WatchedAnswer(BaseModel):
    """An access point on the list. `state`: `watched` for 48 hours after it was first seen, then `permanent`; both are
    left out by every session of the venue. `removed`: by an administrator, and used again. `evidence`: sessions that
    excluded it, 0 of one added by hand. Times: Unix ms, server's clock."""

    bssid: str
    reason: str
    first_seen: int
    last_seen: int
    evidence: int
    state: Literal["watched", "permanent", "removed"]


class WatchListAnswer(BaseModel):
    """The list of a version, newest first."""

    version: int
    access_points: list[WatchedAnswer]


def watch_lists_router(watch_lists: Callable[..., Any], admin: Callable[..., Any]) -> APIRouter:
    """The endpoints.

    Parameters
    ----------
    watch_lists : dependency that gives the WatchLists.  admin : dependency that lets only scope `admin` pass.
    """
    router = APIRouter(
        prefix="/v1/venues/{venue}/radio-maps/{version}/watch-list", tags=["integrity"], dependencies=[Depends(admin)]
    )

    @router.get("", response_model=WatchListAnswer, summary="Access points that are left out")
    async def listed(venue: str, version: Version, service: WatchLists = Depends(watch_lists)) -> WatchListAnswer:
        """Access points that several sessions excluded within a day as moved, swapped, spoofed, duplicated or vanished,
        or that were added by hand. A new version takes over the list of the one in use, but for what one of its
        surveys has heard since."""
        rows = await service.listed(venue, version)
        return WatchListAnswer(version=version, access_points=[_answer(row) for row in rows])

    @router.post(
        "",
        status_code=201,
        response_model=WatchedAnswer,
        responses={200: {"model": WatchedAnswer, "description": "It was watched already"}},
        summary="Leave an access point out",
        openapi_extra=request_body(WatchBody, example=examples.WATCH),
    )
    async def add(
        venue: str, version: Version, request: Request, response: Response, service: WatchLists = Depends(watch_lists)
    ) -> WatchedAnswer:
        """Sessions leave it out from their next scan on."""
        body = parse_admin(WatchBody, await read_json(request, BODY_LIMIT_BYTES))
        watched, new = await service.add(venue, version, body.bssid, body.reason)
        response.status_code = 201 if new else 200
        return _answer(watched)

    @router.delete("/{bssid}", status_code=204, response_class=Response, summary="Use an access point again")
    async def remove(venue: str, version: Version, bssid: str, service: WatchLists = Depends(watch_lists)) -> Response:
        """It stays on the list as `removed`, and exclusions do not bring it back; adding it does."""
        await service.remove(venue, version, bssid)
        return Response(status_code=204)

    return router


def _answer(watched: WatchedAccessPoint) -> WatchedAnswer:
    row = watched.row
    return WatchedAnswer(
        bssid=format_bssid(row.bssid),
        reason=row.reason,
        first_seen=row.first_seen_ms,
        last_seen=row.last_seen_ms,
        evidence=row.evidence,
        state=watched.state.value,
    )
