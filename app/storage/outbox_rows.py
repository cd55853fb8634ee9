"""Alerts on their way to webhooks: a row for each, from the transaction of its Fix until it is delivered."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import bindparam, delete, insert, literal, select, update
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

from app.storage.database import reachable
from app.storage.tables import outbox, sessions, webhooks

LONGEST_FAILURE = 200


@dataclass(frozen=True, slots=True)
class Alert:
    """What is sent to every webhook of a venue. event : the same however often it is sent.  created_ms : server's."""

    event: str
    body: bytes
    created_ms: int


@dataclass(frozen=True, slots=True)
class Delivery:
    """One alert for one webhook. attempts : this one included.  Times are Unix ms of the server's clock."""

    id: int
    webhook: str
    url: str
    secret: bytes
    event: str
    body: bytes
    created_ms: int
    attempts: int


class OutboxRows:
    """Hands out deliveries, each to one worker at a time; every method is one transaction.

    Each raises DependencyDown where the database cannot be reached, having changed nothing.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def claim(self, now_ms: int, until_ms: int, limit: int, busy: Mapping[str, int], each: int) -> list[Delivery]:
        """Deliveries that are due, oldest first; nobody else gets them until a time, by which they are to be settled.

        Parameters
        ----------
        limit : most that are given.  busy : requests that are under way to each webhook already.
        each : most that may be under way to one.
        """
        full = [webhook for webhook, count in busy.items() if count >= each]
        query = _READ_DUE.where(outbox.c.webhook.not_in(full)).limit(limit)
        async with reachable(), self._engine.connect() as connection:
            due = (await connection.execute(query, {"now": now_ms})).all()
        under_way = Counter(busy)
        chosen = []
        for row in due:
            under_way[row.webhook] += 1
            if under_way[row.webhook] <= each:
                chosen.append(row)
        if not chosen:  # mostly: looking takes no lock
            return []
        claimed = []
        async with reachable(), self._engine.begin() as connection:
            for row in chosen:
                seen = {"of": row.id, "seen": row.due_ms, "until": until_ms}
                if (await connection.execute(_CLAIM, seen)).rowcount == 1:
                    claimed.append(row)
        return [_delivery(row) for row in claimed]

    async def delivered(self, delivery: Delivery, now_ms: int) -> None:
        """It has arrived."""
        async with reachable(), self._engine.begin() as connection:
            await connection.execute(delete(outbox).where(outbox.c.id == delivery.id))
            await connection.execute(
                update(webhooks).where(webhooks.c.webhook == delivery.webhook).values(delivered_ms=now_ms, failure=None)
            )

    async def failed(self, delivery: Delivery, failure: str, due_ms: int | None) -> None:
        """It has not; to be tried again at due_ms, or given up where that is None."""
        here = outbox.c.id == delivery.id
        async with reachable(), self._engine.begin() as connection:
            if due_ms is None:
                await connection.execute(delete(outbox).where(here))
            else:
                await connection.execute(update(outbox).where(here).values(due_ms=due_ms))
            await connection.execute(
                update(webhooks).where(webhooks.c.webhook == delivery.webhook).values(failure=failure[:LONGEST_FAILURE])
            )


def _delivery(row: Any) -> Delivery:
    return Delivery(
        row.id, row.webhook, row.url, row.secret, row.event, row.body, row.created_ms, attempts=row.attempts + 1
    )


async def post_alert(connection: AsyncConnection, session: str, alert: Alert) -> None:
    """Address an alert to every webhook of the session's venue, inside the transaction that stores its Fix."""
    every = (
        select(
            webhooks.c.webhook,
            literal(alert.event),
            literal(alert.body, outbox.c.body.type),
            literal(alert.created_ms, outbox.c.created_ms.type),
            literal(alert.created_ms, outbox.c.due_ms.type),
            literal(0),
        )
        .join(sessions, sessions.c.venue_id == webhooks.c.venue_id)
        .where(sessions.c.session == session)
    )
    await connection.execute(
        insert(outbox).from_select(["webhook", "event", "body", "created_ms", "due_ms", "attempts"], every)
    )


_READ_DUE = (
    select(
        outbox.c.id,
        outbox.c.webhook,
        webhooks.c.url,
        webhooks.c.secret,
        outbox.c.event,
        outbox.c.body,
        outbox.c.created_ms,
        outbox.c.due_ms,
        outbox.c.attempts,
    )
    .join(webhooks, webhooks.c.webhook == outbox.c.webhook)
    .where(outbox.c.due_ms <= bindparam("now"))
    .order_by(outbox.c.due_ms, outbox.c.id)
)
_CLAIM = (
    update(outbox)
    .where(outbox.c.id == bindparam("of"), outbox.c.due_ms == bindparam("seen"))
    .values(due_ms=bindparam("until"), attempts=outbox.c.attempts + 1)
)
