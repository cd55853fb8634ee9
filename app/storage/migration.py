"""Bringing a database to the schema of this version, and telling whether it is there."""

from __future__ import annotations

from pathlib import Path

from sqlalchemy import Connection, column, inspect, select, table
from sqlalchemy.exc import DatabaseError, OperationalError
from sqlalchemy.ext.asyncio import AsyncEngine

from app.errors import DependencyDown, InvalidInput
from app.storage.database import database_url, reachable, why_unreachable

SCRIPTS = Path(__file__).parents[2] / "migrations"
"""Beside app/, in the repository and where the package is installed."""
_VERSIONS = table("alembic_version", column("version_num"))


def newest_revision() -> str:
    """The revision that this version of the service works with."""
    # the number that the file's name begins with; the tests hold it against Alembic's own reading of the folder
    return max(path.name.split("_")[0] for path in (SCRIPTS / "versions").glob("[0-9]*_*.py"))


def migrate(url: str) -> str:
    """Make or change the tables until they are those of newest_revision, which is returned. Blocks.

    Raises
    ------
    InvalidInput : the URL names no database that is supported, no folder to make one in, or a file of another kind.
    DependencyDown : the database cannot be reached.
    """
    from alembic import command
    from alembic.config import Config

    parsed = database_url(url, blocking=True)
    folder = Path(parsed.database or "").parent
    if parsed.get_backend_name() == "sqlite" and not folder.is_dir():
        raise InvalidInput(f"there is no folder {folder} for the database", "database")
    config = Config()
    config.set_main_option("script_location", str(SCRIPTS).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    config.attributes["database"] = url
    try:
        command.upgrade(config, "head")
    except OperationalError as error:
        raise DependencyDown(why_unreachable(parsed, error)) from error
    except DatabaseError as error:
        raise _no_database(error) from error
    return newest_revision()


async def require_migrated(engine: AsyncEngine) -> None:
    """Nothing, if the database has the tables of this version.

    Raises
    ------
    DependencyDown : it has not, or cannot be reached; the message says which.
    """
    async with reachable(), engine.connect() as connection:
        found = await connection.run_sync(_revision)
    wanted = newest_revision()
    if found != wanted:
        state = "has no tables yet" if found is None else f"is at revision {found}, not {wanted}"
        raise DependencyDown(f"the database {state}; run `surefix migrate`")


async def require_usable(engine: AsyncEngine) -> None:
    """The same for a command that is about to work with a database: says where it is and what is wrong.

    A SQLite file that is not there is not made: its path may be mistyped.

    Raises
    ------
    DependencyDown : there is none, or as require_migrated.
    InvalidInput : it is a file of another kind.
    """
    url = engine.url
    path = url.database or ""
    if url.get_backend_name() == "sqlite" and not path.startswith("file:") and not Path(path).exists():
        raise DependencyDown(f"there is no database {path}; `surefix migrate --database sqlite:///{path}` makes it")
    try:
        await require_migrated(engine)
    except DependencyDown as error:
        if error.__cause__ is None:
            raise
        raise DependencyDown(why_unreachable(url, error.__cause__)) from error
    except DatabaseError as error:
        raise _no_database(error) from error


def _no_database(error: DatabaseError) -> InvalidInput:
    """What SQLite says of a file that is something else. Raises the error again, if it is another."""
    if type(error) is not DatabaseError:
        raise error
    return InvalidInput(f"this cannot be used as a database: {error.orig}", "database")


def _revision(connection: Connection) -> str | None:
    if not inspect(connection).has_table(_VERSIONS.name):
        return None
    revision: str | None = connection.scalar(select(_VERSIONS.c.version_num))
    return revision
