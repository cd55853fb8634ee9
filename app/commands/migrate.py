"""surefix migrate: make the database's tables, or bring them to this version."""

from __future__ import annotations

from typing import Annotated

import typer

from app.settings import settings_of
from app.storage.migration import migrate as run_migrations

app = typer.Typer(help=__doc__, add_completion=False, subcommand_metavar="")


@app.callback(invoke_without_command=True)
def migrate(
    database: Annotated[str, typer.Option(help="sqlite:///path or postgresql://...; default: SUREFIX_DATABASE.")] = "",
) -> None:
    """Safe to repeat, and to run by several at once; each call is one transaction."""
    revision = run_migrations(database or settings_of({}).database)
    typer.echo(f"the database is at revision {revision}")
