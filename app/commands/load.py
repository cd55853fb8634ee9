"""surefix load: phones that walk through a venue of a running service, and how fast it answers."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from app.commands.service_address import service_address
from app.errors import InvalidInput
from app.settings import Settings
from app.simulation.load_phones import load as run_load
from app.simulation.load_walks import made_up_walk, recorded_walks

MOST_WALKS = 16
MADE_UP_WALKS = 4
MADE_UP_S = 300

app = typer.Typer(help=__doc__, add_completion=False, subcommand_metavar="")


@app.callback(invoke_without_command=True)
def load(
    venue: Annotated[str, typer.Option(help="Venue to walk in; it must exist.")],
    url: Annotated[str, typer.Option(help="Address of the service.")] = (
        f"http://127.0.0.1:{Settings.model_fields['port'].default}"
    ),
    key: Annotated[str | None, typer.Option(help="API key of scope position.", envvar="SUREFIX_KEY")] = None,
    method: Annotated[str, typer.Option(help="Positioning method.")] = "surefix",
    phones: Annotated[int, typer.Option(min=1, max=10_000, help="Phones at once.")] = 10,
    seconds: Annotated[float, typer.Option(min=0.1, help="How long.")] = 30.0,
    rate: Annotated[
        float, typer.Option(min=0.0, help="Batches a second and phone; 0: as fast as they are answered.")
    ] = 1.0,
    trace_dir: Annotated[Path | None, typer.Option(help="Recorded walks to send; default: made-up readings.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Decides made-up readings and when phones start.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Walk with many phones at once; exit code 1 if any request failed."""
    address = service_address(url)
    if trace_dir is not None:
        if not trace_dir.is_dir():
            raise InvalidInput(f"{trace_dir} is not a folder", "trace_dir")
        walks = recorded_walks(trace_dir, MOST_WALKS)
    else:
        walks = [made_up_walk(seed + n, MADE_UP_S) for n in range(min(MADE_UP_WALKS, phones))]
    opening = {"venue": venue, "method": method}
    outcome = asyncio.run(run_load(str(address), key, opening, walks, phones, seconds, rate, seed)).summary()
    if as_json:
        typer.echo(json.dumps({"phones": phones, **outcome}))
    else:
        _print(phones, outcome)
    if outcome["errors"] or not outcome["batches"]:
        raise typer.Exit(1)


def _print(phones: int, outcome: dict[str, Any]) -> None:
    table = Table(show_header=False, box=None)
    table.add_row("phones", str(phones))
    table.add_row(
        "batches", f"{outcome['batches']} in {outcome['seconds']} s, {outcome['batches_per_second']} a second"
    )
    for rank, value in outcome["latency_ms"].items():
        table.add_row(f"latency {rank}", "-" if value is None else f"{value} ms")
    table.add_row("with a position", str(outcome["positioned"]))
    table.add_row("sent late", str(outcome["late"]))
    table.add_row("errors", ", ".join(f"{count} x {name}" for name, count in outcome["errors"].items()) or "none")
    Console().print(table)
