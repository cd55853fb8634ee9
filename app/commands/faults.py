"""surefix faults: put faults into recorded walks, replay them, print what was told and how soon."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

from app.errors import InvalidInput
from app.evaluation.campaign import Protocol, parted, read_walks
from app.evaluation.fault_campaign import CLEAN, FaultScore, fault_score, run_faults
from app.evaluation.faults import FAULTS
from app.evaluation.faulty_walk import Injector
from app.evaluation.recordings import FloorFolder, floor_folders
from app.evaluation.tables import fault_document, fault_table
from app.fusion.interface import Method
from app.fusion.methods import METHODS
from app.fusion.warm_up import warm_up

# options may follow DIR
app = typer.Typer(
    help=__doc__, add_completion=False, subcommand_metavar="", context_settings={"allow_interspersed_args": True}
)
_progress_console = Console(stderr=True)


@app.callback(invoke_without_command=True)
def faults(
    site: Annotated[Path, typer.Argument(metavar="DIR", help="Folder holding one folder of recorded walks per floor.")],
    out: Annotated[Path, typer.Option(help="Folder for faults.json and faults.txt; made if missing.")],
    methods: Annotated[str, typer.Option(help=f"all, or some of: {', '.join(METHODS)}.")] = "surefix",
    named: Annotated[str, typer.Option("--faults", help=f"all, or some of: {', '.join(FAULTS)}.")] = "all",
    folds: Annotated[int, typer.Option(help="Parts that the walks fall into by the hash of their name.")] = 5,
    fold: Annotated[list[int] | None, typer.Option(help="Part to walk; repeat it to pool. Default 0.")] = None,
    floors: Annotated[str, typer.Option(help="Floors, comma-separated; default all.")] = "",
    limit: Annotated[int | None, typer.Option(min=1, help="Walks per floor and fold at most.")] = None,
    jobs: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
    alert_limit: Annotated[float, typer.Option(help="Error that must not pass as usable, metres.")] = 10.0,
    risk: Annotated[float, typer.Option(help="Accepted probability of an error beyond the protection level.")] = 0.01,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same faults.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print faults.json instead of the tables.")] = False,
) -> None:
    """Survey with some of the recorded walks, put faults into the others, and see whether they are told in time."""
    protocol = Protocol(folds, tuple(sorted(set(fold or [0]))), limit, alert_limit_m=alert_limit, risk=risk)
    chosen, injectors = _chosen(methods, METHODS, "methods"), _chosen(named, FAULTS, "faults")
    folders = floor_folders(site, _split(floors))
    out.mkdir(parents=True, exist_ok=True)
    scores = _measure(folders, chosen, injectors, protocol, seed, jobs)
    document = {"site": site.resolve().name, **fault_document(scores, protocol, seed)}
    (out / "faults.json").write_text(json.dumps(document, indent=1) + "\n")
    with (out / "faults.txt").open("w") as file:
        _print(Console(width=160, file=file), scores, protocol)
    if as_json:
        json.dump(document, sys.stdout, indent=1)
        print()
        return
    _print(Console(width=None if sys.stdout.isatty() else 160), scores, protocol)


def _measure(
    folders: Sequence[FloorFolder],
    methods: Mapping[str, Method],
    injectors: Mapping[str, Injector],
    protocol: Protocol,
    seed: int,
    jobs: int,
) -> dict[str, dict[str, FaultScore]]:
    # without a thread that refreshes it: workers are forked off this process
    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=_progress_console, auto_refresh=False) as bar:
        reading = bar.add_task("reading walks", total=sum(len(folder.traces) for folder in folders))
        walks = read_walks(folders, jobs, lambda: bar.update(reading, advance=1, refresh=True))
        warm_up()  # compiled once here, not in every worker
        walked = sum(len(parted(walks, protocol, fold)[1]) for fold in protocol.tested)
        walking = bar.add_task("walking", total=walked * len(methods) * (1 + len(injectors)))

        def advance() -> None:
            bar.update(walking, advance=1, refresh=True)

        found = run_faults(folders, walks, methods, injectors, protocol, seed, jobs, advance)
        bar.update(walking, total=bar.tasks[walking].completed)  # some walks offer nothing to fault
    return {
        name: {fault: fault_score(one, rows[CLEAN].answers, protocol.alert_limit_m) for fault, one in rows.items()}
        for name, rows in found.items()
    }


def _print(console: Console, scores: Mapping[str, Mapping[str, FaultScore]], protocol: Protocol) -> None:
    folds = ", ".join(map(str, protocol.tested))
    for name, rows in scores.items():
        console.print(fault_table(rows, f"{name}, fold {folds}, alert limit {protocol.alert_limit_m:g} m"))


def _chosen(named: str, known: Mapping[str, Any], field: str) -> dict[str, Any]:
    names = list(known) if named == "all" else _split(named)
    unknown = [name for name in names if name not in known]
    if unknown or not names:
        raise InvalidInput(f"no {field} {', '.join(unknown) or 'named'}; there are {', '.join(known)}", field)
    return {name: known[name] for name in names}


def _split(names: str) -> list[str]:
    return [name.strip() for name in names.split(",") if name.strip()]
