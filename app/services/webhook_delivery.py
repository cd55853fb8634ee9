"""Delivers alerts to webhooks, beside everything else that a worker does, until each has arrived or is given up.

A delivery is signed as the Standard Webhooks specification has it, so receivers can check it with existing libraries:
`webhook-signature: v1,` and the base64 of HMAC-SHA256 over `{webhook-id}.{webhook-timestamp}.{body}`.
"""

from __future__ import annotations

import asyncio
import base64
import hashlib
import hmac
import logging
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import httpx

from app.errors import DependencyDown
from app.services.announcements import ALERTS, Announcements
from app.services.webhooks import is_barred
from app.storage.outbox_rows import Delivery, OutboxRows

TIMEOUT_S = 10.0
"""A receiver that takes longer has failed."""
LEASE_MS = 30_000
"""A worker that died with a delivery has it taken over after so long."""
FIRST_RETRY_MS = 2_000
LONGEST_RETRY_MS = 900_000
GIVE_UP_MS = 86_400_000
"""After its alert; the delivery is dropped, and the log says so."""
LOOK_EVERY_S = 1.0
"""Retries, and alerts that other workers could not deliver, are found after so long."""
AT_ONCE_EACH = 4
"""Requests to one webhook at a time: a receiver that hangs keeps no other waiting."""
AT_ONCE = 64
USER_AGENT = "Surefix"
_log = logging.getLogger(__name__)


def signed_headers(delivery: Delivery, now_ms: int) -> dict[str, str]:
    """What a delivery is sent with. now_ms : server's clock; goes into the signature, so an old one can be refused."""
    timestamp = str(now_ms // 1000)
    signed = b"%b.%b.%b" % (delivery.event.encode(), timestamp.encode(), delivery.body)
    signature = base64.b64encode(hmac.new(delivery.secret, signed, hashlib.sha256).digest()).decode()
    return {
        "Content-Type": "application/json",
        "User-Agent": USER_AGENT,
        "webhook-id": delivery.event,
        "webhook-timestamp": timestamp,
        "webhook-signature": f"v1,{signature}",
    }


def next_attempt_ms(delivery: Delivery, now_ms: int) -> int | None:
    """When a delivery that failed is tried again: after twice the time each time; None once it is to be given up."""
    if now_ms - delivery.created_ms >= GIVE_UP_MS:
        return None
    return now_ms + min(FIRST_RETRY_MS << min(delivery.attempts - 1, 20), LONGEST_RETRY_MS)


async def _refuse_barred(event: str, info: Mapping[str, Any]) -> None:
    """Let go of a connection to where nothing is sent, before anything is: a name may lead there, and only for a time.

    Called by httpcore at each step of a request.
    """
    if event == "connection.connect_tcp.complete":
        connected = info["return_value"]
        host = connected.get_extra_info("server_addr")[0]
        if is_barred(host):
            await connected.aclose()
            raise httpx.ConnectError(f"its name leads to {host}, which is link-local or tells a machine's secrets")


class WebhookDelivery:
    """Delivers what is in the outbox; every worker has one, and a delivery goes to one of them at a time.

    Parameters
    ----------
    announcements : where this process' alerts are announced.  now_ms : the server's clock.
    """

    def __init__(self, rows: OutboxRows, announcements: Announcements, now_ms: Callable[[], int]) -> None:
        self._rows = rows
        self._announcements = announcements
        self._now_ms = now_ms
        self._client: httpx.AsyncClient | None = None
        self._under_way: Counter[str] = Counter()
        self._tasks: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Deliver for ever; ends by being cancelled, with the requests that are under way."""
        try:
            with self._announcements.listen(ALERTS) as announced:
                while True:
                    announced.clear()
                    try:
                        while await self.look():
                            pass  # a webhook with many waiting leaves room for the others next time
                    except DependencyDown as error:
                        _log.warning("webhooks are delivered later: %s", error)
                    with suppress(TimeoutError):
                        await asyncio.wait_for(announced.wait(), LOOK_EVERY_S)
        finally:
            for task in self._tasks:
                task.cancel()
            await asyncio.gather(*self._tasks, return_exceptions=True)
            if self._client is not None:
                await self._client.aclose()

    async def look(self) -> int:
        """Begin the deliveries that are due, as many as there is room for; gives how many."""
        room = AT_ONCE - self._under_way.total()
        if room <= 0:
            return 0
        now_ms = self._now_ms()
        claimed = await self._rows.claim(now_ms, now_ms + LEASE_MS, room, self._under_way, AT_ONCE_EACH)
        for delivery in claimed:
            self._under_way[delivery.webhook] += 1
            task = asyncio.create_task(self._deliver(delivery))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)
        return len(claimed)

    async def _deliver(self, delivery: Delivery) -> None:
        try:
            await self._settle(delivery, await self._post(delivery))
        except DependencyDown as error:
            _log.warning("webhook %s: alert %s will be sent again: %s", delivery.webhook, delivery.event, error)
        finally:
            self._under_way[delivery.webhook] -= 1
            self._under_way += Counter()  # forgets those at zero
            self._announcements.announce(ALERTS)  # there is room again

    async def _settle(self, delivery: Delivery, failure: str | None) -> None:
        now_ms = self._now_ms()
        if failure is None:
            await self._rows.delivered(delivery, now_ms)
            return
        due_ms = next_attempt_ms(delivery, now_ms)
        if due_ms is None:
            _log.warning("webhook %s: alert %s is given up: %s", delivery.webhook, delivery.event, failure)
        await self._rows.failed(delivery, failure, due_ms)

    async def _post(self, delivery: Delivery) -> str | None:
        """Send it; gives why it did not arrive, None if it did. Redirects are not followed."""
        if self._client is None:  # not before it is needed: it reads certificates
            self._client = httpx.AsyncClient(timeout=None, trust_env=False)
        headers = signed_headers(delivery, self._now_ms())
        try:
            async with asyncio.timeout(TIMEOUT_S):
                request = self._client.build_request(
                    "POST", delivery.url, content=delivery.body, headers=headers, extensions={"trace": _refuse_barred}
                )
                answer = await self._client.send(request, stream=True)
                await answer.aclose()  # what it says beyond its status is not read
        except TimeoutError:
            return f"no answer within {TIMEOUT_S:.0f} s"
        except (httpx.HTTPError, httpx.InvalidURL, UnicodeError) as error:  # the last: a host that is no name
            return f"{type(error).__name__}: {error}"
        return None if answer.is_success else f"answered {answer.status_code}"
