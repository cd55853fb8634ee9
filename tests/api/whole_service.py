"""The whole service as create_app() wires it, over a migrated database in a folder."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fastapi.testclient import TestClient

from app.main import create_app
from app.services.access import Scope, key_digest, new_key
from app.settings import Settings
from app.storage.database import connect
from app.storage.key_rows import KeyRows
from app.storage.migration import migrate

LOOPBACK = "http://127.0.0.1:8000"
"""Without keys the service answers to no other name."""


@contextmanager
def whole_service(folder: Path, **settings: Any) -> Iterator[TestClient]:
    """A client of the service; its database is new, or the one that an earlier service left in the folder."""
    url = database_in(folder)
    migrate(url)
    app = create_app(Settings(database=url, **settings))
    with TestClient(app, LOOPBACK, raise_server_exceptions=False) as client:
        yield client


def database_in(folder: Path) -> str:
    """The address of the folder's database."""
    return f"sqlite:///{folder / 'surefix.db'}"


def make_key(folder: Path, *scopes: Scope) -> str:
    """A new key in the folder's database."""
    key = new_key()

    async def add() -> None:
        engine = connect(database_in(folder))
        await KeyRows(engine).add("test", key_digest(key), scopes, time.time_ns() // 1_000_000)
        await engine.dispose()

    migrate(database_in(folder))
    asyncio.run(add())
    return key
