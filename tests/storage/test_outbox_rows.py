from __future__ import annotations

import asyncio

from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.outbox_rows import Alert, Delivery, OutboxRows
from app.storage.session_rows import SessionRows
from app.storage.webhook_rows import WebhookRows
from tests.storage.conftest import Run
from tests.storage.test_session_rows import NOW_MS, fix, opened

LEASE_MS = 1000


def alert(number: int = 0, now_ms: int = NOW_MS) -> Alert:
    return Alert(f"event {number}", b'{"number":%d}' % number, now_ms)


async def alerted(engine: AsyncEngine, count: int = 1, webhooks: tuple[str, ...] = ("hook",)) -> SessionRows:
    """A session of the venue `mall`, whose webhooks get that many alerts."""
    rows = await opened(engine, "a")
    found = await rows.venue("mall")
    assert found is not None
    for webhook in webhooks:
        assert await WebhookRows(engine).add(found[0], webhook, f"http://{webhook}/", b"secret", NOW_MS, 9)
    for number in range(count):
        assert await rows.add_fix("a", number - 1, fix(number), b"", NOW_MS, alert(number, NOW_MS + number))
    return rows


async def claimed(engine: AsyncEngine, now_ms: int = NOW_MS + 100) -> list[Delivery]:
    return await OutboxRows(engine).claim(now_ms, now_ms + LEASE_MS, 100, {}, 100)


def test_an_alert_is_stored_with_its_fix_or_not_at_all(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await alerted(engine)
        assert not await rows.add_fix("a", -1, fix(1), b"", NOW_MS, alert(1))
        (only,) = await claimed(engine)
        expected = Delivery(only.id, "hook", "http://hook/", b"secret", "event 0", b'{"number":0}', NOW_MS, 1)
        assert only == expected

    run(use)


def test_an_alert_goes_to_every_webhook_of_its_venue_and_to_no_other(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await opened(engine, "b", "elsewhere")
        found = await rows.venue("elsewhere")
        assert found is not None
        await WebhookRows(engine).add(found[0], "other", "http://other/", b"", NOW_MS, 9)
        await alerted(engine, webhooks=("one", "two"))
        assert sorted(delivery.webhook for delivery in await claimed(engine)) == ["one", "two"]

    run(use)


def test_of_workers_that_look_at_once_one_gets_each_delivery(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        await alerted(engine, 6)
        taken = await asyncio.gather(*(claimed(engine) for _ in range(4)))
        events = sorted(delivery.event for one in taken for delivery in one)
        assert events == [f"event {number}" for number in range(6)]

    run(use)


def test_a_delivery_whose_worker_died_is_handed_out_again(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        await alerted(engine)
        (first,) = await claimed(engine)
        assert await claimed(engine, NOW_MS + 100 + LEASE_MS - 1) == []
        (second,) = await claimed(engine, NOW_MS + 100 + LEASE_MS)
        assert (second.event, first.attempts, second.attempts) == (first.event, 1, 2)

    run(use)


def test_what_arrived_is_gone_and_what_failed_comes_back_when_it_is_due(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows, hooks = OutboxRows(engine), WebhookRows(engine)
        found = await (await alerted(engine, 3)).venue("mall")
        assert found is not None
        arrived, failed, given_up = await claimed(engine)
        await rows.failed(failed, "x" * 500, NOW_MS + 5000)
        await rows.failed(given_up, "answered 500", None)
        (listed,) = await hooks.listed(found[0])
        assert (listed.failure, listed.delivered_ms, listed.waiting) == ("answered 500", None, 2)
        await rows.delivered(arrived, NOW_MS + 200)
        (listed,) = await hooks.listed(found[0])
        assert (listed.failure, listed.delivered_ms, listed.waiting) == (None, NOW_MS + 200, 1)
        assert await claimed(engine, NOW_MS + 4999) == []
        assert [again.event for again in await claimed(engine, NOW_MS + 10 * LEASE_MS)] == [failed.event]

    run(use)


def test_a_webhook_with_many_waiting_leaves_room_for_the_others(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = OutboxRows(engine)
        await alerted(engine, 8, ("one",))
        found = await SessionRows(engine).venue("mall")
        assert found is not None
        await WebhookRows(engine).add(found[0], "two", "http://two/", b"", NOW_MS, 9)
        await SessionRows(engine).add_fix("a", 7, fix(8), b"", NOW_MS, alert(8, NOW_MS + 8))
        first = await rows.claim(NOW_MS + 100, NOW_MS + LEASE_MS, 4, {}, 2)
        assert [one.webhook for one in first] == ["one", "one"]
        rest = await rows.claim(NOW_MS + 100, NOW_MS + LEASE_MS, 4, {"one": 2}, 2)
        assert [one.webhook for one in rest] == ["two"]

    run(use)


def test_a_removed_webhook_takes_what_was_on_its_way_along(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        found = await (await alerted(engine, 2)).venue("mall")
        assert found is not None
        hooks = WebhookRows(engine)
        assert not await hooks.remove(found[0] + 1, "hook")
        assert await hooks.remove(found[0], "hook")
        assert not await hooks.remove(found[0], "hook")
        assert await claimed(engine) == []

    run(use)


def test_a_venue_has_no_more_webhooks_than_it_may_even_when_many_are_added_at_once(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await opened(engine, "a")
        found = await rows.venue("mall")
        assert found is not None
        hooks = WebhookRows(engine)
        adding = [hooks.add(found[0], f"hook {n}", "http://h/", b"", NOW_MS, 3) for n in range(5)]
        assert sorted(await asyncio.gather(*adding)) == [False, False, True, True, True]
        assert len(await hooks.listed(found[0])) == 3

    run(use)


def test_an_alert_outlives_its_session(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await alerted(engine)
        assert await rows.erase("a")
        assert len(await claimed(engine)) == 1

    run(use)
