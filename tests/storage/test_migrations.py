from __future__ import annotations

import asyncio
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Engine, create_engine, inspect, text

from app.errors import DependencyDown, InvalidInput
from app.storage import migration
from app.storage.database import connect, database_url
from app.storage.migration import SCRIPTS, migrate, newest_revision, require_migrated
from app.storage.tables import metadata


def engine_of(url: str) -> Engine:
    return create_engine(database_url(url, blocking=True))


def required(url: str) -> None:
    async def require() -> None:
        engine = connect(url)
        try:
            await require_migrated(engine)
        finally:
            await engine.dispose()

    asyncio.run(require())


def test_the_migrations_leave_exactly_the_tables_that_the_service_uses(database: str) -> None:
    engine = engine_of(database)
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        differences: list[Any] = compare_metadata(context, metadata)
    engine.dispose()
    assert differences == []


def test_the_comparison_would_notice_a_missing_index_and_another_type(database: str) -> None:
    engine = engine_of(database)
    with engine.connect() as connection:
        connection.execute(text("DROP INDEX ix_sessions_expires_ms"))
        context = MigrationContext.configure(connection)
        assert [kind for kind, _ in compare_metadata(context, metadata)] == ["add_index"]
    engine.dispose()


def test_a_migrated_database_is_accepted_and_migrating_again_changes_nothing(database: str) -> None:
    required(database)
    assert migrate(database) == newest_revision()
    required(database)


def test_an_empty_database_is_refused_with_the_command_that_helps(empty_database: str) -> None:
    with pytest.raises(DependencyDown, match="surefix migrate"):
        required(empty_database)


def test_a_database_of_another_revision_is_refused_by_number(database: str) -> None:
    engine = engine_of(database)
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    engine.dispose()
    with pytest.raises(DependencyDown, match="9999"):
        required(database)


def test_services_that_start_at_once_may_all_migrate(empty_database: str) -> None:
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        assert set(pool.map(migrate, [empty_database] * 4)) == {newest_revision()}
    required(empty_database)


def test_the_newest_revision_is_the_one_that_alembic_finds() -> None:
    config = Config()
    config.set_main_option("script_location", str(SCRIPTS))
    config.set_main_option("path_separator", "os")
    assert ScriptDirectory.from_config(config).get_current_head() == newest_revision()


def test_a_migration_that_fails_leaves_nothing_behind(
    empty_database: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scripts = tmp_path / "migrations"
    (scripts / "versions").mkdir(parents=True)
    for name in ("env.py", "script.py.mako"):
        (scripts / name).write_text((SCRIPTS / name).read_text())
    (scripts / "versions" / "0001_broken.py").write_text(
        "import sqlalchemy as sa\nfrom alembic import op\nrevision = '0001'\ndown_revision = None\n"
        "def upgrade():\n"
        "    op.create_table('half', sa.Column('id', sa.Integer(), primary_key=True))\n"
        "    raise ZeroDivisionError\n"
    )
    monkeypatch.setattr(migration, "SCRIPTS", scripts)
    with pytest.raises(ZeroDivisionError):
        migrate(empty_database)
    engine = engine_of(empty_database)
    assert inspect(engine).get_table_names() == []
    engine.dispose()


@pytest.mark.parametrize(
    "url", ["mysql://x/y", "sqlite://", "sqlite:///:memory:", "nonsense", "", "sqlite:////none/x.db"]
)
def test_what_is_no_database_is_refused(url: str) -> None:
    with pytest.raises(InvalidInput) as refusal:
        migrate(url)
    assert refusal.value.field == "database"


def test_a_server_that_cannot_be_reached_is_told() -> None:
    with pytest.raises(DependencyDown):
        migrate("postgresql://nobody@127.0.0.1:1/none")


def test_foreign_keys_are_enforced(database: str) -> None:
    async def orphan() -> None:
        engine = connect(database)
        try:
            async with engine.begin() as connection:
                await connection.execute(
                    text(
                        "INSERT INTO surveys (venue_id, format, accepted, rejected, created_ms) VALUES (7,'csv',0,0,0)"
                    )
                )
        finally:
            await engine.dispose()

    with pytest.raises(Exception, match=r"(?i)foreign key"):
        asyncio.run(orphan())


def test_sqlite_writes_ahead_so_that_readers_do_not_wait(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'test.db'}"
    migrate(url)

    async def read_while_written() -> tuple[Any, Any]:
        engine = connect(url)
        try:
            async with engine.connect() as writer, engine.connect() as reader:
                await writer.exec_driver_sql("BEGIN IMMEDIATE")
                await writer.exec_driver_sql("INSERT INTO venues VALUES (1, 'v', 'V', 1, NULL, 0)")
                seen = await reader.scalar(text("SELECT count(*) FROM venues"))
                mode = await reader.scalar(text("PRAGMA journal_mode"))
            return mode, seen
        finally:
            await engine.dispose()

    assert asyncio.run(read_while_written()) == ("wal", 0)


def test_a_file_that_is_something_else_is_refused_and_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "test.db"
    path.write_bytes(b"a letter, long enough to be taken for a database" * 50)
    before = path.read_bytes()
    with pytest.raises(InvalidInput, match="not a database"):
        migrate(f"sqlite:///{path}")
    assert path.read_bytes() == before
