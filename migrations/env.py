"""Runs the migrations, each call in one transaction: a database is at one revision or another, never between."""

from __future__ import annotations

from typing import Any

from alembic import context
from sqlalchemy import Connection, create_engine, event, text
from sqlalchemy.pool import NullPool

from app.settings import Settings
from app.storage.database import POSTGRESQL_CONNECT_S, database_url
from app.storage.tables import metadata

LOCK = 0x5375726566697800
"""Of PostgreSQL's advisory locks: services that start at once migrate one after the other."""


def run() -> None:
    """Migrate the database that the caller names (attribute `database`), or the setting does."""
    url = database_url(context.config.attributes.get("database") or Settings().database, blocking=True)
    sqlite = url.get_backend_name() == "sqlite"
    connect_args = {} if sqlite else {"connect_timeout": POSTGRESQL_CONNECT_S}
    engine = create_engine(url, poolclass=NullPool, connect_args=connect_args)
    if sqlite:
        event.listen(engine, "connect", _without_own_transactions)
        event.listen(engine, "begin", _begin)
    with engine.connect() as connection, connection.begin():
        if not sqlite:
            connection.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": LOCK})
        context.configure(
            connection=connection,
            target_metadata=metadata,
            render_as_batch=sqlite,  # SQLite changes a table by copying it
            transactional_ddl=True,
        )
        with context.begin_transaction():
            context.run_migrations()


def _without_own_transactions(connection: Any, _record: Any) -> None:
    # Python's driver begins none before DDL, so a migration that fails would stay half done
    connection.isolation_level = None


def _begin(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN IMMEDIATE")


run()
