"""Adding to a row that may be there already, in either database."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from sqlalchemy import Insert, Table
from sqlalchemy.dialects.postgresql import insert as insert_postgresql
from sqlalchemy.dialects.sqlite import insert as insert_sqlite
from sqlalchemy.ext.asyncio import AsyncConnection


def upsert(
    connection: AsyncConnection, table: Table, keys: Sequence[str], changes: Callable[[Any], Mapping[str, Any]]
) -> Insert:
    """An insert that changes the row of the same key instead, if there is one.

    Parameters
    ----------
    keys : the columns of the primary key.  changes : new values by column, of the columns that were to be inserted.
    """
    if connection.dialect.name == "sqlite":
        of_sqlite = insert_sqlite(table)
        return of_sqlite.on_conflict_do_update(index_elements=keys, set_=changes(of_sqlite.excluded))
    of_postgresql = insert_postgresql(table)
    return of_postgresql.on_conflict_do_update(index_elements=keys, set_=changes(of_postgresql.excluded))
