"""surefix key: make, list and revoke API keys."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime
from typing import Annotated, TypeVar

import typer
from rich.console import Console
from rich.table import Table

from app.errors import InvalidInput, NotFound
from app.services.access import REMEMBER_S, Scope, key_digest, new_key
from app.services.server_clock import server_ms
from app.settings import settings_of
from app.storage.database import connect
from app.storage.key_rows import KeyRow, KeyRows
from app.storage.migration import require_usable

LONGEST_NAME = 200
Done = TypeVar("Done")
Database = Annotated[str, typer.Option(help="sqlite:///path or postgresql://...; default: SUREFIX_DATABASE.")]

app = typer.Typer(help=__doc__, add_completion=False, no_args_is_help=True)


@app.command()
def create(
    name: Annotated[str, typer.Option(help="Who uses the key; for the listing.")],
    scope: Annotated[list[Scope], typer.Option(help="What it is good for; repeatable. admin includes survey.")],
    database: Database = "",
) -> None:
    """Make a key and print it, alone on a line. It is shown this once: only its digest is stored."""
    if not name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
        raise InvalidInput(f"a name is printable text of at most {LONGEST_NAME} characters", "name")
    key = new_key()
    _run(database, lambda rows: rows.add(name, key_digest(key), {one.value for one in scope}, server_ms()))
    typer.echo(key)


@app.command("list")
def list_keys(database: Database = "") -> None:
    """List every key that was made, without what is secret."""
    table = Table("id", "name", "scopes", "created", "revoked", box=None)
    for row in _run(database, _listed):
        revoked = "" if row.revoked_ms is None else _date(row.revoked_ms)
        table.add_row(str(row.id), row.name, ", ".join(row.scopes), _date(row.created_ms), revoked)
    Console().print(table)


@app.command()
def revoke(
    key_id: Annotated[int, typer.Argument(metavar="ID", help="As `surefix key list` shows it.")],
    database: Database = "",
) -> None:
    """End a key for good."""
    if not _run(database, lambda rows: rows.revoke(key_id, server_ms())):
        raise NotFound(f"there is no valid key {key_id}; `surefix key list` shows all")
    typer.echo(f"revoked; running services refuse it within {REMEMBER_S:g} s")


def _run(database: str, use: Callable[[KeyRows], Awaitable[Done]]) -> Done:
    async def run() -> Done:
        engine = connect(database or settings_of({}).database)
        try:
            await require_usable(engine)
            return await use(KeyRows(engine))
        finally:
            await engine.dispose()

    return asyncio.run(run())


async def _listed(rows: KeyRows) -> list[KeyRow]:
    return await rows.listed()


def _date(at_ms: int) -> str:
    return datetime.fromtimestamp(at_ms / 1000.0, UTC).strftime("%Y-%m-%d %H:%M UTC")
