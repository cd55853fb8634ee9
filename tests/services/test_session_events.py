from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack, aclosing
from pathlib import Path
from typing import Any

import pytest

from app.api.events import MOST_LISTENERS
from app.errors import Unauthenticated
from app.services.session_events import SessionEvent, follow
from app.services.session_news import SessionNews
from app.services.tickets import LIFETIME_MS, check_ticket, issue_ticket
from app.storage.session_rows import FixRow
from tests.api.phone_service import PhoneService, phone_service
from tests.odometer import FAULT_BSSID

T0 = 1_573_190_000_000


@pytest.fixture
def service(tmp_path: Path) -> Iterator[PhoneService]:
    with phone_service(f"sqlite:///{tmp_path / 'phones.db'}") as made:
        yield made


def batch(sequence: int, fault: bool = False) -> dict[str, Any]:
    bssid = f"{FAULT_BSSID:012x}" if fault else "a80cca039dd7"
    scan = {"t": T0 + 1000 * sequence, "readings": [{"bssid": bssid, "rssi": -50}]}
    return {"sequence": sequence, "wifi": [scan]}


def events(service: PhoneService, session: str, after: int | None, count: int) -> list[SessionEvent]:
    """The first events that a follower gets."""

    async def collect() -> list[SessionEvent]:
        got: list[SessionEvent] = []
        async with aclosing(follow(service.wired.tracking, session, after)) as stream:  # type: ignore[type-var]
            async for event in stream:
                if event is not None:
                    got.append(event)
                if len(got) == count:
                    break
        return got

    return list(service.call(collect))


def test_following_begins_with_the_newest_fix(service: PhoneService) -> None:
    session = service.open()
    for sequence in range(3):
        service.fix(session, batch(sequence))
    (event,) = events(service, session, None, 1)
    assert (event.name, event.sequence) == ("fix", 2)
    assert event.data == service.client.get(f"/v1/sessions/{session}/fix").content


def test_an_alert_is_raised_before_the_fix_in_fault_and_cleared_after(service: PhoneService) -> None:
    session = service.open()
    for sequence, fault in enumerate((False, True, True, False)):
        service.fix(session, batch(sequence, fault))
    got = events(service, session, 0, 5)
    assert [(event.name, event.sequence) for event in got] == [
        ("alert", 1),
        ("fix", 1),
        ("fix", 2),
        ("alert", 3),
        ("fix", 3),
    ]
    raised, cleared = json.loads(got[0].data), json.loads(got[3].data)
    assert (raised["alert"], raised["flag"], raised["t"]) == ("raised", "fault", T0 + 1000)
    assert raised["excluded"][1]["bssid"] == "0a:00:00:00:00:fa"
    assert cleared["alert"] == "cleared"


def test_who_resumes_within_a_fault_is_not_alerted_again(service: PhoneService) -> None:
    session = service.open()
    for sequence, fault in enumerate((True, True, False)):
        service.fix(session, batch(sequence, fault))
    assert [event.name for event in events(service, session, 0, 3)] == ["fix", "alert", "fix"]


def test_a_follower_is_woken_by_the_next_fix_and_by_the_end(service: PhoneService) -> None:
    session = service.open()
    service.fix(session, batch(0))
    portal = service.client.portal
    assert portal is not None
    stream: AsyncIterator[SessionEvent | None] = follow(service.wired.tracking, session, None)

    async def following() -> SessionEvent | None:
        return await asyncio.wait_for(anext(stream), 10.0)

    first = portal.call(following)
    waiting = portal.start_task_soon(following)
    service.fix(session, batch(1))
    second = waiting.result(10.0)
    waiting = portal.start_task_soon(following)
    service.client.delete(f"/v1/sessions/{session}")
    last = waiting.result(10.0)
    assert first is not None and second is not None and last is not None
    assert [(event.name, event.sequence) for event in (first, second, last)] == [("fix", 0), ("fix", 1), ("end", 1)]


def test_a_follower_is_woken_by_what_another_worker_has_stored_and_by_the_end_of_the_session(
    service: PhoneService,
) -> None:
    session, portal = service.open(), service.client.portal
    assert portal is not None
    tracking, rows = service.wired.tracking, service.wired.rows
    news = SessionNews(rows, tracking.announcements, lambda: service.wired.clock_ms[0])
    service.fix(session, batch(0))
    stream: AsyncIterator[SessionEvent | None] = follow(tracking, session, None)

    async def following() -> SessionEvent | None:
        return await asyncio.wait_for(anext(stream), 10.0)

    made = FixRow(1, T0 + 1000, service.client.get(f"/v1/sessions/{session}/fix").content)

    async def elsewhere() -> bool:
        return await rows.add_fix(session, 0, made, b"state", service.wired.clock_ms[0] + 1000)

    assert portal.call(following) is not None
    portal.call(news.look)
    waiting = portal.start_task_soon(following)
    assert portal.call(elsewhere)
    portal.call(news.look)
    second = waiting.result(10.0)
    waiting = portal.start_task_soon(following)
    service.wired.clock_ms[0] += 2000
    portal.call(news.look)
    last = waiting.result(10.0)
    assert second is not None and last is not None
    assert [(event.name, event.sequence) for event in (second, last)] == [("fix", 1), ("end", 1)]


def test_only_so_many_hear_one_session(service: PhoneService) -> None:
    session = service.open()
    announcements = service.wired.tracking.announcements
    with ExitStack() as listeners:
        for _ in range(MOST_LISTENERS):
            listeners.enter_context(announcements.listen(session))
        refused = service.client.get(f"/v1/sessions/{session}/events")
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:surefix:problem:conflict")


def test_a_ticket_opens_the_events_of_its_session_alone_and_for_a_minute(service: PhoneService) -> None:
    session, other = service.open(), service.open()
    answer = service.client.post(f"/v1/sessions/{session}/tickets")
    assert answer.status_code == 201
    ticket = answer.json()["ticket"]
    assert answer.json()["expires"] == service.wired.clock_ms[0] + LIFETIME_MS
    del service.client.headers["Authorization"]
    assert service.client.get(f"/v1/sessions/{other}/events", params={"ticket": ticket}).status_code == 401
    service.call(service.wired.tracking.admit, session, ticket)
    service.wired.clock_ms[0] += LIFETIME_MS + 1
    assert service.client.get(f"/v1/sessions/{session}/events", params={"ticket": ticket}).status_code == 401


@pytest.mark.parametrize("forged", ["", ".", "1.2", "x", "9" * 300, "é.ü", "\ud800.", "99999999999999."])
def test_a_forged_ticket_is_refused(forged: str) -> None:
    for key in (b"k" * 16, b""):
        with pytest.raises(Unauthenticated):
            check_ticket(forged, key, 0)


def test_a_ticket_with_another_expiry_is_refused() -> None:
    ticket, expires_ms = issue_ticket(b"k" * 16, 1000)
    check_ticket(ticket, b"k" * 16, expires_ms)
    for wrong, key in ((ticket.replace(str(expires_ms), str(expires_ms + 1)), b"k" * 16), (ticket, b"j" * 16)):
        with pytest.raises(Unauthenticated):
            check_ticket(wrong, key, 0)
