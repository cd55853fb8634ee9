from __future__ import annotations

import base64
import dataclasses
import hashlib
import hmac
import ipaddress
import itertools
import json
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest

from app.services import webhook_delivery, webhooks
from app.services.phones import public_number
from app.services.venues import Venues
from app.services.webhook_delivery import (
    FIRST_RETRY_MS,
    GIVE_UP_MS,
    LONGEST_RETRY_MS,
    WebhookDelivery,
    next_attempt_ms,
    signed_headers,
)
from app.services.webhooks import NewWebhook, Webhooks
from app.storage.outbox_rows import Delivery, OutboxRows
from app.storage.venue_rows import VenueRows
from app.storage.webhook_rows import WebhookRow, WebhookRows
from tests.api.phone_service import PhoneService, phone_service
from tests.services.test_session_events import batch
from tests.webhook_receiver import PATIENCE_S, Received, Receiver, webhook_receiver

DELIVERY = Delivery(1, "hook", "http://127.0.0.1:9/", b"k" * 32, "event", b"{}", 1_000_000, 1)


@pytest.fixture
def service(tmp_path: Path) -> Iterator[PhoneService]:
    with phone_service(f"sqlite:///{tmp_path / 'phones.db'}") as made:
        yield made


@contextmanager
def delivering(service: PhoneService) -> Iterator[None]:
    """A worker that delivers, until the end of the block."""
    wired = service.wired
    delivery = WebhookDelivery(OutboxRows(wired.engine), wired.tracking.announcements, lambda: wired.clock_ms[0])
    assert service.client.portal is not None
    running = service.client.portal.start_task_soon(delivery.run)
    try:
        yield
    finally:
        running.cancel()


def webhooks_of(service: PhoneService) -> Webhooks:
    engine = service.wired.engine

    def now_ms() -> int:
        return service.wired.clock_ms[0]

    return Webhooks(WebhookRows(engine), Venues(VenueRows(engine), now_ms), now_ms)


def register(service: PhoneService, url: str) -> NewWebhook:
    made: NewWebhook = service.call(webhooks_of(service).add, "mall", url)
    return made


def until(service: PhoneService, reached: Any) -> WebhookRow:
    """The first webhook, once that is true of it."""
    hooks = webhooks_of(service)
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        row: WebhookRow = service.call(hooks.listed, "mall")[0]
        if reached(row):
            return row
    pytest.fail("the webhook was never so")


def raise_alert(service: PhoneService) -> str:
    """A session whose second batch is in fault."""
    session = service.open()
    service.fix(session, batch(0))
    service.fix(session, batch(1, fault=True))
    return session


def is_signed(received: Received, secret: str) -> bool:
    """As a receiver checks it, by the words of the API page."""
    key = base64.b64decode(secret.removeprefix("whsec_"))
    headers = {name.lower(): value for name, value in received.headers.items()}
    signed = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + received.body
    expected = base64.b64encode(hmac.new(key, signed, hashlib.sha256).digest()).decode()
    return headers["webhook-signature"] == f"v1,{expected}"


def test_a_raised_and_a_cleared_alert_arrive_signed_and_without_the_session(service: PhoneService) -> None:
    with webhook_receiver() as receiver, delivering(service):
        hook = register(service, receiver.url)
        session = raise_alert(service)
        raised = receiver.next()
        service.fix(session, batch(2, fault=True))
        service.fix(session, batch(3))
        cleared = receiver.next()
    assert [is_signed(one, hook.secret) for one in (raised, cleared)] == [True, True]
    assert not is_signed(raised, "whsec_" + base64.b64encode(b"x" * 32).decode())
    bodies = [json.loads(one.body) for one in (raised, cleared)]
    assert [body["type"] for body in bodies] == ["alert.raised", "alert.cleared"]
    assert [body["sequence"] for body in bodies] == [1, 3]
    assert {body["phone"] for body in bodies} == {public_number(session)}
    assert bodies[0]["event"] != bodies[1]["event"]
    assert bodies[0]["excluded"][1]["reason"] == "moved"
    for one in (raised, cleared):
        assert session.encode() not in one.body
        assert session not in str(one.headers)
        assert one.headers["webhook-id"] == json.loads(one.body)["event"]


def test_an_alert_is_delivered_well_within_a_second(service: PhoneService) -> None:
    with webhook_receiver() as receiver, delivering(service):
        register(service, receiver.url)
        raise_alert(service)
        receiver.next()  # from here on the connection's parts are warm
        took_s = []
        for _ in range(5):
            session = service.open()
            service.fix(session, batch(0))
            sent_s = time.monotonic()
            service.fix(session, batch(1, fault=True))
            took_s.append(receiver.next().at_s - sent_s)
    assert sorted(took_s)[2] < 0.5, took_s  # the median, batch and all; next to looking every second


def test_what_fails_is_sent_again_as_the_same_event_until_it_arrives(
    service: PhoneService, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(webhook_delivery, "LOOK_EVERY_S", 0.01)
    with webhook_receiver() as receiver, delivering(service):
        for status in (500, 302, 404):
            receiver.statuses.put(status)
        hook = register(service, receiver.url)
        raise_alert(service)
        attempts = [receiver.next()]
        for status in (500, 302, 404):
            row = until(service, lambda row, status=status: row.failure == f"answered {status}")
            assert row.waiting == 1 and row.delivered_ms is None
            service.wired.clock_ms[0] += LONGEST_RETRY_MS
            attempts.append(receiver.next())
        row = until(service, lambda row: row.waiting == 0)
        assert row.failure is None and row.delivered_ms == service.wired.clock_ms[0]
    assert len({one.body for one in attempts}) == len({one.headers["webhook-id"] for one in attempts}) == 1
    assert len({one.headers["webhook-timestamp"] for one in attempts}) == 4
    assert all(is_signed(one, hook.secret) for one in attempts)


def test_an_alert_survives_a_restart_and_a_receiver_that_was_away(service: PhoneService) -> None:
    with webhook_receiver() as receiver:
        url, port = receiver.url, int(receiver.url.rsplit(":", 1)[1].strip("/"))
    register(service, url)
    with delivering(service):
        raise_alert(service)
        assert "Connect" in str(until(service, lambda row: row.failure is not None).failure)
    service.wired.clock_ms[0] += LONGEST_RETRY_MS
    with webhook_receiver(port) as receiver, delivering(service):
        assert json.loads(receiver.next().body)["type"] == "alert.raised"
        until(service, lambda row: row.waiting == 0)


def test_a_name_that_leads_to_a_barred_address_gets_nothing(
    service: PhoneService, monkeypatch: pytest.MonkeyPatch
) -> None:
    with webhook_receiver() as receiver, delivering(service):
        register(service, receiver.url.replace("127.0.0.1", "localhost"))
        monkeypatch.setattr(webhooks, "BARRED", (ipaddress.ip_network("127.0.0.0/8"), ipaddress.ip_network("::1")))
        raise_alert(service)
        row = until(service, lambda row: row.failure is not None)
        assert "leads to 127.0.0.1" in str(row.failure) and row.waiting == 1
        assert receiver.arrived.empty()


def test_an_alert_that_never_arrives_is_given_up(service: PhoneService, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webhook_delivery, "LOOK_EVERY_S", 0.01)
    with webhook_receiver() as receiver, delivering(service):
        receiver.statuses.put(500)
        receiver.statuses.put(500)
        register(service, receiver.url)
        raise_alert(service)
        until(service, lambda row: row.failure is not None)
        service.wired.clock_ms[0] += GIVE_UP_MS
        row = until(service, lambda row: row.waiting == 0)
        assert (row.failure, row.delivered_ms) == ("answered 500", None)


def test_a_receiver_that_hangs_keeps_neither_batches_nor_other_receivers_waiting(service: PhoneService) -> None:
    with ExitStack() as stack:
        hanging: Receiver = stack.enter_context(webhook_receiver(holding=True))
        healthy: Receiver = stack.enter_context(webhook_receiver())
        stack.enter_context(delivering(service))
        for receiver in (hanging, healthy):
            register(service, receiver.url)
        sessions = [raise_alert(service) for _ in range(12)]  # more than may be under way to one
        assert {json.loads(healthy.next().body)["phone"] for _ in sessions} == set(map(public_number, sessions))
        assert hanging.arrived.qsize() <= webhook_delivery.AT_ONCE_EACH


def test_attempts_come_after_twice_the_time_each_until_a_longest_and_a_last() -> None:
    now_ms = DELIVERY.created_ms
    waits_ms = []
    for attempt in itertools.count(1):
        due_ms = next_attempt_ms(dataclasses.replace(DELIVERY, attempts=attempt), now_ms)
        if due_ms is None:
            break
        waits_ms.append(due_ms - now_ms)
        now_ms = due_ms
    assert waits_ms[:4] == [FIRST_RETRY_MS, 2 * FIRST_RETRY_MS, 4 * FIRST_RETRY_MS, 8 * FIRST_RETRY_MS]
    assert max(waits_ms) == waits_ms[-1] == LONGEST_RETRY_MS
    assert GIVE_UP_MS <= now_ms - DELIVERY.created_ms < GIVE_UP_MS + LONGEST_RETRY_MS


def test_the_signature_covers_event_time_and_body() -> None:
    plain = signed_headers(DELIVERY, 5_000)
    assert plain["webhook-timestamp"] == "5"
    others = [
        signed_headers(dataclasses.replace(DELIVERY, body=b"{} "), 5_000),
        signed_headers(dataclasses.replace(DELIVERY, event="other"), 5_000),
        signed_headers(dataclasses.replace(DELIVERY, secret=b"l" * 32), 5_000),
        signed_headers(DELIVERY, 6_000),
    ]
    assert len({one["webhook-signature"] for one in [plain, *others]}) == 5
