"""surefix faults: put faults into recorded and simulated walks, replay them, print what was told and how soon."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.commands.named_choices import chosen, split_names
from app.commands.out_folder import make_folder
from app.commands.progress import counting
from app.commands.written_results import write_results
from app.errors import InvalidInput
from app.evaluation.campaign import Protocol, parted, read_walks
from app.evaluation.fault_campaign import CLEAN, Answered, FaultScore, at_limit, fault_score, run_faults
from app.evaluation.faults import FAULTS
from app.evaluation.faulty_walk import Injector
from app.evaluation.recordings import FloorFolder, floor_folders
from app.evaluation.simulated_faults import run_simulated_faults
from app.evaluation.tables import fault_document, fault_table
from app.fusion.interface import Method
from app.fusion.methods import METHODS
from app.fusion.warm_up import warm_up

# options may follow DIR
app = typer.Typer(
    help=__doc__, add_completion=False, subcommand_metavar="", context_settings={"allow_interspersed_args": True}
)
ALERT_LIMITS_M = (10.0, 20.0)
FIRST_SEED = 6000
"""Of the simulated buildings."""
Scores = dict[float, dict[str, dict[str, FaultScore]]]
"""Alert limit -> method -> fault -> score."""


@app.callback(invoke_without_command=True)
def faults(
    out: Annotated[Path, typer.Option(help="Folder for faults.json and faults.txt; made if missing.")],
    site: Annotated[
        Path | None, typer.Argument(metavar="[DIR]", help="Folder holding one folder of recorded walks per floor.")
    ] = None,
    simulated: Annotated[int, typer.Option(min=0, help="Simulated buildings, beside DIR or without it.")] = 0,
    visits: Annotated[int, typer.Option(min=1, help="Walks in each of them.")] = 12,
    methods: Annotated[str, typer.Option(help=f"all, or some of: {', '.join(METHODS)}.")] = "surefix",
    named: Annotated[str, typer.Option("--faults", help=f"all, or some of: {', '.join(FAULTS)}.")] = "all",
    folds: Annotated[int, typer.Option(help="Parts that the walks fall into by the hash of their name.")] = 5,
    fold: Annotated[list[int] | None, typer.Option(help="Part to walk; repeat it to pool. Default 0.")] = None,
    floors: Annotated[str, typer.Option(help="Floors, comma-separated; default all.")] = "",
    limit: Annotated[int | None, typer.Option(min=1, help="Walks per floor and fold at most.")] = None,
    jobs: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
    alert_limit: Annotated[
        list[float] | None, typer.Option(help="Error that must not pass as usable, metres; repeat it. Default 10, 20.")
    ] = None,
    risk: Annotated[float, typer.Option(help="Accepted probability of an error beyond the protection level.")] = 0.01,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same faults.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print faults.json instead of the tables.")] = False,
) -> None:
    """Survey with some of the walks, put faults into the others, and see whether they are told in time."""
    limits_m = sorted(set(alert_limit or ALERT_LIMITS_M))
    # a level does not depend on the alert limit: what the largest was told says what the others would have been
    protocol = Protocol(folds, tuple(sorted(set(fold or [0]))), limit, alert_limit_m=limits_m[-1], risk=risk)
    asked, injectors = chosen(methods, METHODS, "methods"), chosen(named, FAULTS, "faults")
    if site is None and not simulated:
        raise InvalidInput("name a folder of recorded walks, or a number of simulated buildings, or both", "site")
    folders = [] if site is None else floor_folders(site, split_names(floors))
    make_folder(out)
    parts: dict[str, Scores] = {}
    if site is not None:
        answers = _measure(folders, asked, injectors, protocol, seed, jobs)
        parts[f"fold {', '.join(map(str, protocol.tested))}"] = _judged(answers, limits_m)
    if simulated:
        warm_up()
        with counting("buildings", simulated) as advance:
            seeds = range(FIRST_SEED, FIRST_SEED + simulated)
            answers = run_simulated_faults(seeds, visits, asked, injectors, protocol, seed, jobs, advance)
        parts[f"{simulated} simulated buildings"] = _judged(answers, limits_m)
    document = {
        "site": None if site is None else site.resolve().name,
        "protocol": asdict(protocol),
        "seed": seed,
        "parts": {part: fault_document(scores) for part, scores in parts.items()},
    }
    write_results(out, "faults", document, lambda console: _print(console, parts), as_json)


def _measure(
    folders: Sequence[FloorFolder],
    methods: Mapping[str, Method],
    injectors: Mapping[str, Injector],
    protocol: Protocol,
    seed: int,
    jobs: int,
) -> dict[str, dict[str, Answered]]:
    with counting("reading walks", sum(len(folder.traces) for folder in folders)) as advance:
        walks = read_walks(folders, jobs, advance)
    warm_up()  # compiled once here, not in every worker
    walked = sum(len(parted(walks, protocol, fold)[1]) for fold in protocol.tested)
    with counting("walking", walked * len(methods) * (1 + len(injectors))) as advance:
        return run_faults(folders, walks, methods, injectors, protocol, seed, jobs, advance)


def _judged(answers: Mapping[str, Mapping[str, Answered]], limits_m: Sequence[float]) -> Scores:
    return {
        limit_m: {
            name: {
                fault: fault_score(at_limit(one, limit_m), rows[CLEAN].answers, limit_m) for fault, one in rows.items()
            }
            for name, rows in answers.items()
        }
        for limit_m in limits_m
    }


def _print(console: Console, parts: Mapping[str, Scores]) -> None:
    for part, scores in parts.items():
        for limit_m, methods in scores.items():
            for name, rows in methods.items():
                console.print(fault_table(rows, f"{name}, {part}, alert limit {limit_m:g} m"))
