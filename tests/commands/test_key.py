from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.commands.key import app
from app.errors import DependencyDown, InvalidInput, NotFound
from app.services.access import PREFIX
from app.storage.migration import migrate


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with a migrated database in its default place."""
    migrate(f"sqlite:///{tmp_path / 'surefix.db'}")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def key(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


def test_a_key_is_printed_once_alone_on_a_line_and_listed_without_it(folder: Path) -> None:
    made = key("create", "--name", "phones", "--scope", "position", "--scope", "survey")
    assert made.exit_code == 0, made.output
    (secret,) = made.stdout.splitlines()
    assert secret.startswith(PREFIX)
    listed = key("list").stdout
    assert "phones" in listed and "position, survey" in listed
    assert secret not in listed
    assert not any(secret.encode() in path.read_bytes() for path in folder.iterdir())


def test_a_key_is_revoked_once(folder: Path) -> None:
    key("create", "--name", "phones", "--scope", "position")
    assert key("revoke", "1").exit_code == 0
    again = key("revoke", "1").exception
    assert isinstance(again, NotFound) and "key list" in str(again)


@pytest.mark.parametrize(
    "arguments",
    [["--name", "x"], ["--scope", "admin"], ["--name", "x", "--scope", "everything"]],
)
def test_a_key_without_name_or_a_known_scope_is_not_made(folder: Path, arguments: list[str]) -> None:
    done = key("create", *arguments)
    assert (done.exit_code, done.stdout) == (2, "")


@pytest.mark.parametrize("name", ["", "  ", "a\nb", "n" * 300])
def test_a_key_needs_a_name_that_can_be_shown(folder: Path, name: str) -> None:
    assert isinstance(key("create", "--name", name, "--scope", "admin").exception, InvalidInput)
    assert len(key("list").stdout.splitlines()) == 1


def test_keys_need_a_migrated_database(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "surefix.db").touch()
    refused = key("create", "--name", "x", "--scope", "admin").exception
    assert isinstance(refused, DependencyDown) and "surefix migrate" in str(refused)
