from __future__ import annotations

import asyncio
import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import text

from app.storage.session_state import MemoryStates
from tests.api.phone_service import PhoneService, phone_service

T0 = 1_573_190_000_000


@pytest.fixture
def database(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path / 'phones.db'}"


@pytest.fixture
def service(database: str) -> Iterator[PhoneService]:
    with phone_service(database) as made:
        yield made


def batch(sequence: int) -> dict[str, Any]:
    times = [T0 + 1000 * sequence + 10 * i for i in range(5)]
    columns = {"t": times, "x": [0.0] * 5, "y": [0.0] * 5, "z": [9.8] * 5}
    readings = [{"bssid": "a80cca039dd7", "rssi": -50}]
    return {"sequence": sequence, "accelerometer": columns, "wifi": [{"t": times[-1], "readings": readings}]}


def without_session(fix: dict[str, Any]) -> dict[str, Any]:
    return {**fix, "session": ""}


def test_batches_that_arrive_at_once_are_taken_one_after_the_other(service: PhoneService) -> None:
    session = service.open()
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda n: service.send(session, batch(n)), range(16)))
    taken = sorted(answer.json()["sequence"] for answer in answers if answer.status_code == 200)
    assert {answer.status_code for answer in answers} <= {200, 409}
    track = service.client.get(f"/v1/sessions/{session}/track").json()["fixes"]
    assert [fix["sequence"] for fix in track] == taken
    assert [fix["position"]["x"] for fix in track] == [float(n + 1) for n in range(len(taken))]


def test_the_same_batch_sent_many_times_at_once_counts_once(service: PhoneService) -> None:
    session = service.open()
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: service.send(session, batch(0)), range(8)))
    assert len({answer.content for answer in answers}) == 1
    assert sum("Idempotent-Replayed" not in answer.headers for answer in answers) == 1


def test_workers_that_share_a_database_continue_each_others_sessions(database: str) -> None:
    with phone_service(database) as one, phone_service(database) as other:
        session, alone = one.open(), one.open()
        together = [(one, other)[n % 2].fix(session, batch(n)) for n in range(8)]
        expected = [one.fix(alone, batch(n)) for n in range(8)]
    assert list(map(without_session, together)) == list(map(without_session, expected))


def test_workers_that_race_for_a_batch_agree_on_one_fix(database: str) -> None:
    with phone_service(database) as one, phone_service(database) as other, ThreadPoolExecutor(2) as pool:
        session = one.open()
        for sequence in range(20):
            body = batch(sequence)
            answers = list(pool.map(lambda worker, sent=body: worker.send(session, sent), (one, other)))
            assert [answer.status_code for answer in answers] == [200, 200]
            assert answers[0].content == answers[1].content
            assert json.loads(answers[0].content)["position"]["x"] == sequence + 1.0


def test_a_venue_is_read_once_and_again_when_it_has_changed(service: PhoneService) -> None:
    session = service.open()
    for sequence in range(3):
        service.fix(session, batch(sequence))
    assert service.wired.loads == [1]

    async def publish() -> None:
        async with service.wired.engine.begin() as connection:
            await connection.execute(text("UPDATE venues SET revision = revision + 1"))

    service.call(publish)
    for sequence in range(3, 6):
        service.fix(session, batch(sequence))
    assert service.wired.loads == [1, 2]


def test_memory_keeps_the_most_recently_used_states() -> None:
    async def run() -> list[Any]:
        states = MemoryStates(largest=2)
        for session in ("a", "b"):
            await states.put(session, 0, session, b"")
        await states.get("a", 0)
        await states.put("c", 0, "c", b"")
        kept = [await states.get(session, 0) for session in ("a", "b", "c")]
        return [*kept, await states.get("a", 1)]

    assert asyncio.run(run()) == ["a", None, "c", None]
