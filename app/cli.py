"""The `surefix` command: registers the subcommands, a module each in app/commands."""

from __future__ import annotations

import importlib
import sys

import typer

from app.errors import SurefixError

COMMANDS = {
    "serve": "app.commands.serve",
    "migrate": "app.commands.migrate",
    "key": "app.commands.key",
    "import": "app.commands.import_survey",
    "evaluate": "app.commands.evaluate",
    "faults": "app.commands.faults",
    "compare": "app.commands.compare",
    "buildings": "app.commands.buildings",
    "transfer": "app.commands.transfer",
    "ageing": "app.commands.ageing",
    "simulate": "app.commands.simulate",
    "train-carrying": "app.commands.train_carrying",
    "demo": "app.commands.demo",
    "load": "app.commands.load",
}
"""Subcommand -> module with a Typer `app`."""


HELP = "Indoor positioning as a web service that says when not to trust it."


def build() -> typer.Typer:
    """The command with all its subcommands."""
    root = typer.Typer(name="surefix", no_args_is_help=True, pretty_exceptions_enable=False, help=HELP)
    wanted = [name for name in COMMANDS if name in sys.argv[1:2]] or list(COMMANDS)  # one import, not all
    for name in wanted:
        module = importlib.import_module(COMMANDS[name])
        root.add_typer(module.app, name=name)
    return root


def main() -> None:
    """Entry point: a SurefixError is a message and exit code 2, not a traceback."""
    try:
        build()()
    except SurefixError as error:
        typer.echo(f"surefix: {error}", err=True)
        raise SystemExit(2) from error
