"""The engine behind the repositories: SQLite beside the service, or PostgreSQL by URL."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from sqlalchemy import event
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, InterfaceError, OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from sqlalchemy.ext.asyncio import AsyncEngine, create_async_engine

from app.errors import DependencyDown, InvalidInput

BUSY_S = 5.0
"""How long a SQLite writer waits for another before the caller is told to come back."""
FORMS = "the database is sqlite:///path or postgresql://user:password@host/name"
ANSWER_S = 10.0
"""How long a request waits for a database that is there and says nothing; its driver takes as long to let go."""
LONG_S = 900.0
"""The same of what may take its time: whole surveys, whole maps, and erasing what has expired."""
POOL_SIZE = 8
POOL_WAIT_S = 5.0
"""For one of them to be free: with a database that says nothing all of them wait."""
POSTGRESQL_CONNECT_S = 3
SQLITE_PRAGMAS = (
    "journal_mode = WAL",
    "synchronous = NORMAL",
    "foreign_keys = ON",
    f"busy_timeout = {BUSY_S * 1000:.0f}",
)
"""What SQLite forgets with every connection. WAL: readers and the writer do not wait for each other."""


def database_url(url: str, *, blocking: bool = False) -> URL:
    """The URL that a setting names, with the driver the service uses.

    Parameters
    ----------
    url : `sqlite:///path` or `postgresql://user:password@host/name`.
    blocking : for code that does not run in an event loop (migrations).

    Raises
    ------
    InvalidInput : anything else.
    """
    try:
        parsed = make_url(url)
    except (ArgumentError, ValueError) as error:
        raise InvalidInput(FORMS, "database") from error  # what SQLAlchemy says may quote a part of the password
    kind = parsed.get_backend_name()
    if kind == "sqlite":
        if not parsed.database or parsed.database == ":memory:":
            raise InvalidInput("a SQLite database is a file: sqlite:///path", "database")
        return parsed.set(drivername="sqlite" if blocking else "sqlite+aiosqlite")
    if kind in ("postgresql", "postgres"):
        if "@" in (parsed.host or ""):  # the rest of a password, which every error would print with the host
            raise InvalidInput(f"{FORMS}; in a password @ is written %40", "database")
        return parsed.set(drivername="postgresql+psycopg")
    raise InvalidInput(FORMS, "database")


def connect(url: str) -> AsyncEngine:
    """An engine; connects at first use.

    Raises
    ------
    InvalidInput : the URL names no database that is supported.
    """
    parsed = database_url(url)
    if parsed.get_backend_name() == "sqlite":
        engine = create_async_engine(parsed, connect_args={"timeout": BUSY_S}, pool_size=POOL_SIZE)
        event.listen(engine.sync_engine, "connect", prepare_sqlite)
        return engine
    return create_async_engine(
        parsed,
        pool_pre_ping=True,
        pool_size=POOL_SIZE,
        pool_timeout=POOL_WAIT_S,
        connect_args={"connect_timeout": POSTGRESQL_CONNECT_S},
    )


def prepare_sqlite(connection: Any, _record: Any = None) -> None:
    """Sets SQLITE_PRAGMAS on a new connection."""
    cursor = connection.cursor()
    for pragma in SQLITE_PRAGMAS:
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def why_unreachable(url: URL, error: BaseException) -> str:
    """Where a database is and why it cannot be reached, on a line and without the password: for who runs the service.

    Who asks the service over HTTP is told neither, see reachable.
    """
    reason = " ".join(str(getattr(error, "orig", error)).split())
    place = url.set(drivername=url.get_backend_name(), query={}).render_as_string(hide_password=True)
    return f"the database {place} cannot be reached: {reason}"


@asynccontextmanager
async def reachable(within_s: float = ANSWER_S) -> AsyncIterator[None]:
    """Turns what a lost, locked or silent database raises into DependencyDown; the transaction inside has been rolled
    back. within_s : what is inside has an answer by then, or is given up."""
    try:
        async with asyncio.timeout(within_s):
            yield
    except (OperationalError, InterfaceError, PoolTimeout, OSError) as error:  # asyncio's TimeoutError is an OSError
        raise DependencyDown(f"the database cannot be reached: {type(error).__name__}") from error
    except DBAPIError as error:
        if not error.connection_invalidated:
            raise
        raise DependencyDown(f"the database cannot be reached: {type(error).__name__}") from error
