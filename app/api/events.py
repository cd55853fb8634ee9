"""Server-Sent Events of a session, and the tickets that browsers need for them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Query, Request
from fastapi.responses import StreamingResponse
from pydantic import BaseModel

from app.api.batch_body import LARGEST_SEQUENCE
from app.errors import Conflict
from app.services.session_events import SessionEvent, follow
from app.services.tracking import Tracking

RECONNECT_MS = 2000
MOST_LISTENERS = 32
"""To one session, of one worker: each reads every Fix by itself."""
HEADERS = {"Cache-Control": "no-cache", "X-Accel-Buffering": "no"}
_ALLOWED_EVENTS: dict[int | str, dict[str, Any]] = {
    200: {"content": {"text/event-stream": {"schema": {"type": "string"}}}}
}


class TicketBody(BaseModel):
    """A ticket for `/events?ticket=`, to be used before `expires` (Unix ms, server's clock)."""

    ticket: str
    expires: int


def events_router(tracking: Callable[..., Any], position: Callable[[Request], Awaitable[Any]]) -> APIRouter:
    """The endpoints of events.

    Parameters
    ----------
    tracking : dependency that gives the Tracking.  position : dependency that lets only scope `position` pass; asked
    as a function of the request, too, where there is no ticket.
    """
    router = APIRouter(prefix="/v1/sessions", tags=["phones"])

    @router.post(
        "/{session}/tickets",
        status_code=201,
        response_model=TicketBody,
        dependencies=[Depends(position)],
        summary="A short-lived ticket to the events",
    )
    async def ticket(session: str, service: Tracking = Depends(tracking)) -> TicketBody:
        """A browser's EventSource cannot send an Authorization header; it sends this instead, for a minute."""
        text, expires_ms = await service.ticket(session)
        return TicketBody(ticket=text, expires=expires_ms)

    @router.get(
        "/{session}/events", response_class=StreamingResponse, responses=_ALLOWED_EVENTS, summary="Fixes as they come"
    )
    async def events(
        session: str,
        request: Request,
        ticket: Annotated[str | None, Query(max_length=200)] = None,
        last_event_id: Annotated[str, Header()] = "",
        service: Tracking = Depends(tracking),
    ) -> StreamingResponse:
        """`fix`: a Fix, its `sequence` as the event's id. `alert`: `{"alert": "raised" or "cleared", ...}`, when the
        flag enters `fault` and when it leaves, before the Fix that does so. `end`: the session is over. Begins with the
        newest Fix, or after `Last-Event-ID`.
        """
        if ticket is None:
            await position(request)
            await service.live(session)
        else:
            await service.admit(session, ticket)
        if service.announcements.listeners(session) >= MOST_LISTENERS:
            raise Conflict(f"{MOST_LISTENERS} listeners hear this session already; close one first")
        return StreamingResponse(
            _stream(follow(service, session, _sequence(last_event_id))), media_type="text/event-stream", headers=HEADERS
        )

    return router


def _sequence(last_event_id: str) -> int | None:
    """The sequence that an event id names; one that we did not make counts as none."""
    known = last_event_id.isascii() and last_event_id.isdigit() and len(last_event_id) <= 10
    return min(int(last_event_id), LARGEST_SEQUENCE) if known else None


async def _stream(events: AsyncIterator[SessionEvent | None]) -> AsyncIterator[bytes]:
    yield b"retry: %d\n\n" % RECONNECT_MS
    async for event in events:
        if event is None:
            yield b": nothing new\n\n"
            continue
        number = b"id: %d\n" % event.sequence if event.name == "fix" else b""
        yield b"event: %b\n%bdata: %b\n\n" % (event.name.encode(), number, event.data)
