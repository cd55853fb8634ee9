"""Webhooks of venues in the database."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import delete, func, insert, select
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.database import reachable
from app.storage.radio_map_rows import lock_venue
from app.storage.tables import outbox, webhooks


@dataclass(frozen=True, slots=True)
class WebhookRow:
    """A webhook without its secret. Times are Unix ms of the server's clock.

    waiting : alerts that have not been delivered yet.  delivered_ms : when the newest was, None before the first.
    failure : why the newest attempt failed; None after one that succeeded.
    """

    webhook: str
    url: str
    created_ms: int
    delivered_ms: int | None
    failure: str | None
    waiting: int


class WebhookRows:
    """Reads and writes webhooks; every method is one transaction.

    Each raises DependencyDown where the database cannot be reached, having changed nothing.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def add(self, venue_id: int, webhook: str, url: str, secret: bytes, created_ms: int, most: int) -> bool:
        """A new webhook; False if the venue has that many already."""
        count = select(func.count()).select_from(webhooks).where(webhooks.c.venue_id == venue_id)
        values = {"webhook": webhook, "venue_id": venue_id, "url": url, "secret": secret, "created_ms": created_ms}
        async with reachable(), self._engine.begin() as connection:
            await lock_venue(connection, venue_id)
            if (await connection.scalar(count) or 0) >= most:
                return False
            await connection.execute(insert(webhooks).values(values))
        return True

    async def listed(self, venue_id: int) -> list[WebhookRow]:
        """Every webhook of a venue, oldest first."""
        waiting = (
            select(func.count())
            .select_from(outbox)
            .where(outbox.c.webhook == webhooks.c.webhook)
            .correlate(webhooks)
            .scalar_subquery()
        )
        query = (
            select(
                webhooks.c.webhook,
                webhooks.c.url,
                webhooks.c.created_ms,
                webhooks.c.delivered_ms,
                webhooks.c.failure,
                waiting,
            )
            .where(webhooks.c.venue_id == venue_id)
            .order_by(webhooks.c.created_ms, webhooks.c.webhook)
        )
        async with reachable(), self._engine.connect() as connection:
            rows = (await connection.execute(query)).all()
        return [WebhookRow(*row) for row in rows]

    async def remove(self, venue_id: int, webhook: str) -> bool:
        """Remove a webhook with what was on its way to it; False if there is none."""
        here = webhooks.c.venue_id == venue_id, webhooks.c.webhook == webhook
        async with reachable(), self._engine.begin() as connection:
            return (await connection.execute(delete(webhooks).where(*here))).rowcount == 1
