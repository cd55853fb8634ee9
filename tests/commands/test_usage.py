from __future__ import annotations

import importlib

import pytest
from typer.testing import CliRunner

from app.cli import COMMANDS, build


def test_the_help_says_what_the_service_is_for() -> None:
    assert "Indoor positioning as a web service" in CliRunner().invoke(build(), ["--help"]).output


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_only_a_command_with_subcommands_asks_for_one(command: str) -> None:
    app = importlib.import_module(COMMANDS[command]).app
    usage = CliRunner().invoke(app, ["--help"]).output.strip().splitlines()[0]
    assert ("COMMAND" in usage) == bool(app.registered_commands)
