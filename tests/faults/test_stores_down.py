"""A store that goes away in the middle of a walk: 503 with Retry-After, nothing changed, and then the walk goes on."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from tests.api.phone_service import PhoneService, phone_service
from tests.postgresql_process import PostgresqlProcess
from tests.redis_process import RedisProcess

T0 = 1_573_190_000_000


@pytest.fixture
def redis(tmp_path: Path) -> Iterator[RedisProcess]:
    server = RedisProcess(tmp_path)
    server.start()
    yield server
    server.kill()


@pytest.fixture
def database(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path / 'phones.db'}"


def batch(sequence: int) -> dict[str, Any]:
    scan = {"t": T0 + 1000 * sequence, "readings": [{"bssid": "a80cca039dd7", "rssi": -50}]}
    return {"sequence": sequence, "wifi": [scan]}


def walked(service: PhoneService, session: str, sequences: range) -> list[dict[str, Any]]:
    return [{**service.fix(session, batch(n)), "session": ""} for n in sequences]


def down(answer: Any) -> bool:
    return answer.status_code == 503 and int(answer.headers["Retry-After"]) > 0


def test_sessions_in_redis_walk_as_in_memory(redis: RedisProcess, database: str) -> None:
    with phone_service(database, redis.url) as one, phone_service(database, redis.url) as other:
        session = one.open()
        together = [{**(one, other)[n % 2].fix(session, batch(n)), "session": ""} for n in range(6)]
    with phone_service(database) as plain:
        assert walked(plain, plain.open(), range(6)) == together


def test_while_redis_is_away_batches_are_refused_and_then_the_walk_goes_on(redis: RedisProcess, database: str) -> None:
    with phone_service(database, redis.url) as service:
        session = service.open()
        first = walked(service, session, range(3))
        redis.kill()
        assert down(service.send(session, batch(3)))
        assert down(service.client.delete(f"/v1/sessions/{session}"))
        redis.start()
        rest = walked(service, session, range(3, 6))
        assert [fix["position"]["x"] for fix in first + rest] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


def test_a_redis_that_has_lost_everything_costs_nothing(redis: RedisProcess, database: str) -> None:
    with phone_service(database, redis.url) as service:
        session = service.open()
        walked(service, session, range(3))
        redis.kill()
        redis.start()
        assert walked(service, session, range(3, 4))[0]["position"]["x"] == 4.0


def test_an_erased_session_leaves_nothing_in_redis(redis: RedisProcess, database: str) -> None:
    with phone_service(database, redis.url) as service:
        session = service.open()
        walked(service, session, range(2))
        assert service.call(service.wired.hot.get, session, 1) is not None
        service.client.delete(f"/v1/sessions/{session}")
        assert service.call(service.wired.hot.get, session, 1) is None


def test_while_the_database_is_locked_batches_are_refused_and_then_the_walk_goes_on(
    tmp_path: Path, database: str
) -> None:
    with phone_service(database) as service:
        session = service.open()
        walked(service, session, range(2))
        with closing(sqlite3.connect(tmp_path / "phones.db", isolation_level=None)) as other:
            other.execute("BEGIN EXCLUSIVE")
            assert down(service.send(session, batch(2)))
            other.execute("ROLLBACK")
        assert walked(service, session, range(2, 4))[1]["position"]["x"] == 4.0


def test_while_the_database_is_gone_every_request_says_so(tmp_path: Path, database: str) -> None:
    with phone_service(database) as service:
        session = service.open()
        walked(service, session, range(2))
        service.call(service.wired.engine.dispose)
        folder = tmp_path.rename(tmp_path.with_name(tmp_path.name + "-away"))
        assert down(service.send(session, batch(2)))
        assert down(service.client.get(f"/v1/sessions/{session}/fix"))
        assert down(service.client.post("/v1/sessions", json={"venue": "mall", "method": "odometer"}))
        folder.rename(tmp_path)
        assert walked(service, session, range(2, 3))[0]["position"]["x"] == 3.0


def test_while_postgresql_is_there_but_silent_requests_are_refused_and_then_the_walk_goes_on() -> None:
    server = PostgresqlProcess()
    server.start()
    try:
        with phone_service(server.new_database()) as service:
            session = service.open()
            walked(service, session, range(2))
            server.freeze()
            began_s = time.monotonic()
            assert down(service.send(session, batch(2)))
            assert down(service.client.get(f"/v1/sessions/{session}/fix"))
            assert time.monotonic() - began_s < 60.0
            server.thaw()
            assert walked(service, session, range(2, 4))[1]["position"]["x"] == 4.0
    finally:
        server.remove()
