"""Sessions of phones: open, send batches, read the newest Fix and the track, erase."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Query, Request, Response

from app.api import examples
from app.api.batch_body import LARGEST_SEQUENCE, BatchBody, parse_batch
from app.api.decoding import Packing, packing_of, prefers, read_body
from app.api.fix_body import FeatureCollectionBody, FixBody, TrackBody, geojson_document, track_document
from app.api.json_bodies import inlined_schema, read_json, request_body
from app.api.session_body import OpenedBody, SessionBody, parse_session
from app.observations import Batch
from app.services.tracking import Tracking
from app.survey.admission import LATEST_MS

SESSION_LIMIT_BYTES = 100_000
LONG_BODY_BYTES = 100_000
"""Body from which a batch is read beside the event loop, one at a time, so that other phones do not wait for it."""
LARGEST_PAGE = 10_000
GEOJSON = "application/geo+json"
Milliseconds = Annotated[int | None, Query(ge=0, le=LATEST_MS)]


async def _read_batch(request: Request, limit_bytes: int, lane: asyncio.Lock) -> Batch:
    packing = packing_of(request.headers.get("content-type"))
    sent = await read_body(request, limit_bytes)
    if len(sent) < LONG_BODY_BYTES:
        return parse_batch(sent, packing)
    async with lane:
        return await asyncio.to_thread(parse_batch, sent, packing)


def sessions_router(tracking: Callable[..., Any], position: Callable[..., Any], limit_bytes: int) -> APIRouter:
    """The endpoints of sessions.

    Parameters
    ----------
    tracking : dependency that gives the Tracking.  position : dependency that lets only scope `position` pass.
    limit_bytes : largest batch, decompressed.
    """
    long_bodies = asyncio.Lock()
    router = APIRouter(prefix="/v1/sessions", tags=["phones"], dependencies=[Depends(position)])

    @router.post(
        "",
        status_code=201,
        response_model=OpenedBody,
        summary="Open a session",
        openapi_extra=request_body(SessionBody, example=examples.SESSION),
    )
    async def open_session(request: Request, service: Tracking = Depends(tracking)) -> OpenedBody:
        """`floor` is a hint and `start` a prior of 5 m; neither binds, but an unknown floor is 404, as an unknown venue
        is. The session's id is a secret of its phone.
        """
        body = parse_session(await read_json(request, SESSION_LIMIT_BYTES))
        opened = await service.open(body.venue, body.method, body.session_start(), body.device_names())
        return OpenedBody(
            session=opened.session,
            venue=opened.venue,
            method=opened.method,
            created=opened.created_ms,
            expires=opened.expires_ms,
        )

    @router.post(
        "/{session}/batches",
        responses={200: {"model": FixBody}},
        response_class=Response,
        summary="Send what the phone has measured, get a Fix",
        openapi_extra=request_body(BatchBody, Packing.JSON, Packing.MSGPACK, example=examples.BATCH),
    )
    async def send_batch(session: str, request: Request, service: Tracking = Depends(tracking)) -> Response:
        """Streams are columns of equal length, ordered by time. `Content-Encoding` may be gzip or zstd.

        As MessagePack a column may also be `bin`: packed little-endian float64, or float32 for a column other than `t`.
        The newest `sequence` sent again gets the stored Fix with `Idempotent-Replayed: true`; an older one is 409.
        Times may lie up to 2 s before what the session has reported, and up to an hour ahead; a batch spans up to 15
        minutes.
        """
        answer = await service.advance(session, await _read_batch(request, limit_bytes, long_bodies))
        headers = {"Idempotent-Replayed": "true"} if answer.replayed else None
        return Response(answer.body, media_type="application/json", headers=headers)

    @router.get(
        "/{session}/fix", responses={200: {"model": FixBody}}, response_class=Response, summary="The newest Fix"
    )
    async def newest_fix(session: str, service: Tracking = Depends(tracking)) -> Response:
        """Before the first batch: a Fix of `sequence` -1 and flag `initialising`."""
        return Response(await service.newest_fix(session), media_type="application/json")

    @router.get(
        "/{session}/track",
        responses={200: {"model": TrackBody, "content": {GEOJSON: {"schema": inlined_schema(FeatureCollectionBody)}}}},
        response_class=Response,
        summary="All fixes, page by page",
    )
    async def track(
        session: str,
        from_ms: Annotated[Milliseconds, Query(alias="from", description="`t` from, Unix ms")] = None,
        to_ms: Annotated[Milliseconds, Query(alias="to", description="`t` until, Unix ms, included")] = None,
        limit: Annotated[int, Query(ge=1, le=LARGEST_PAGE)] = 1000,
        cursor: Annotated[int, Query(ge=-1, le=LARGEST_SEQUENCE, description="`next` of the page before")] = -1,
        smoothed: Annotated[bool, Query(description="as all evidence up to the newest Fix has it")] = False,
        accept: Annotated[str, Header(include_in_schema=False)] = "",
        service: Tracking = Depends(tracking),
    ) -> Response:
        """In order of sequence; `next` is the `cursor` of the next page, null on the last.

        With `Accept: application/geo+json` a FeatureCollection in WGS 84: one Point a Fix, whose `geometry` is null
        where the Fix has no position or its floor no georeference.

        With `smoothed=true` each Fix that has a position is moved to where everything measured before and after it says
        that the walker was: position, accuracy, covariance, heading, protection level and `usable` are those of the
        smoothed track; what was found at the time stays as it was.
        """
        read = service.smoothed.track if smoothed else service.track
        rows = await read(session, cursor, limit + 1, from_ms, to_ms)
        following = str(rows[limit - 1].sequence) if len(rows) > limit else None
        if prefers(accept, GEOJSON, Packing.JSON):
            return Response(geojson_document(rows[:limit], following), media_type=GEOJSON)
        return Response(track_document(session, rows[:limit], following), media_type="application/json")

    @router.delete("/{session}", status_code=204, summary="Erase a session, its track and its state")
    async def erase(session: str, service: Tracking = Depends(tracking)) -> None:
        """Nothing is left; the session is unknown afterwards."""
        await service.erase(session)

    return router
