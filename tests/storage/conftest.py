from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.database import connect
from app.storage.migration import migrate
from tests.postgresql_process import PostgresqlProcess

Run = Callable[[Callable[[AsyncEngine], Awaitable[Any]]], Any]


@pytest.fixture(scope="session")
def postgresql() -> Iterator[PostgresqlProcess]:
    """A PostgreSQL server for all the tests that need one."""
    server = PostgresqlProcess()
    server.start()
    yield server
    server.remove()


@pytest.fixture(params=["sqlite", "postgresql"])
def empty_database(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The address of a database without tables, of either kind."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'test.db'}"
    server: PostgresqlProcess = request.getfixturevalue("postgresql")
    return server.new_database()


@pytest.fixture
def database(empty_database: str) -> str:
    """The address of a database as the migrations leave it."""
    migrate(empty_database)
    return empty_database


@pytest.fixture
def run(database: str) -> Run:
    """Runs a coroutine function on an engine, and gives what it gives."""

    def run_with_engine(use: Callable[[AsyncEngine], Awaitable[Any]]) -> Any:
        async def with_engine() -> Any:
            engine = connect(database)
            try:
                return await use(engine)
            finally:
                await engine.dispose()

        return asyncio.run(with_engine())

    return run_with_engine
