from __future__ import annotations

import importlib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.cli import COMMANDS
from app.errors import SurefixError

WITHOUT_MAKING_ONE = {
    "serve": ["serve", "--port", "0"],
    "key create": ["key", "create", "--name", "me", "--scope", "admin"],
    "key list": ["key", "list"],
    "import": ["import", "points.csv", "--venue", "mall"],
}
"""Commands that work with a database that `migrate` has made."""


def told(arguments: list[str], database: str) -> str:
    """What the command says of a database that it cannot work with."""
    app = importlib.import_module(COMMANDS[arguments[0]]).app
    refused = CliRunner().invoke(app, [*arguments[1:], "--database", database]).exception
    assert isinstance(refused, SurefixError) and "\n" not in str(refused)
    return str(refused)


@pytest.mark.parametrize("command", sorted(WITHOUT_MAKING_ONE))
def test_a_database_that_is_not_there_is_named_and_not_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for database in ("sqlite:///mistyped.db", "sqlite:////nosuch/x.db"):
        assert f"`surefix migrate --database {database}`" in told(WITHOUT_MAKING_ONE[command], database)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", [*sorted(WITHOUT_MAKING_ONE), "migrate"])
def test_a_server_that_cannot_be_reached_is_named_with_the_reason_and_without_the_password(command: str) -> None:
    said = told(WITHOUT_MAKING_ONE.get(command, [command]), "postgresql://me:secret@127.0.0.1:1/mall")
    assert "postgresql://me:***@127.0.0.1:1/mall" in said and "Connection refused" in said
    assert "secret" not in said


@pytest.mark.parametrize("command", [*sorted(WITHOUT_MAKING_ONE), "migrate"])
@pytest.mark.parametrize(
    "database", ["foo", "mysql://x", "postgresql://me:secret/mall", "postgresql://me:a@secret@x/y"]
)
def test_what_is_no_address_of_a_database_is_answered_with_the_forms_and_never_quoted(
    command: str, database: str
) -> None:
    said = told(WITHOUT_MAKING_ONE.get(command, [command]), database)
    assert "sqlite:///path or postgresql://user:password@host/name" in said and "secret" not in said


@pytest.mark.parametrize("command", sorted(WITHOUT_MAKING_ONE))
def test_a_file_of_another_kind_is_refused(tmp_path: Path, command: str) -> None:
    (tmp_path / "letter.txt").write_text("dear database, " * 200)
    assert "file is not a database" in told(WITHOUT_MAKING_ONE[command], f"sqlite:///{tmp_path / 'letter.txt'}")
