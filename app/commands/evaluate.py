"""surefix evaluate: replay recorded walks through the methods, print error tables, write plots."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.commands.named_choices import chosen, split_names
from app.commands.out_folder import make_folder
from app.commands.progress import counting
from app.errors import InvalidInput
from app.evaluation.alone import ROWS
from app.evaluation.campaign import Protocol, read_walks, run, walked_in
from app.evaluation.integrity import integrity
from app.evaluation.late_replay import late_rows
from app.evaluation.plots import error_distribution, error_over_time, shown_walks, tracks
from app.evaluation.recordings import FloorFolder, floor_folders
from app.evaluation.replay import Answer
from app.evaluation.scoring import score
from app.evaluation.stanford import stanford
from app.evaluation.tables import LEGEND, document, error_table, integrity_table, parts_table, trust_table
from app.fusion.interface import Method
from app.fusion.methods import METHODS
from app.fusion.warm_up import warm_up

# options may follow DIR
app = typer.Typer(
    help=__doc__, add_completion=False, subcommand_metavar="", context_settings={"allow_interspersed_args": True}
)


@app.callback(invoke_without_command=True)
def evaluate(
    site: Annotated[Path, typer.Argument(metavar="DIR", help="Folder holding one folder of recorded walks per floor.")],
    out: Annotated[Path, typer.Option(help="Folder for results.json and the plots; made if missing.")],
    methods: Annotated[str, typer.Option(help=f"all, or some of: {', '.join(ROWS)}.")] = "all",
    folds: Annotated[int, typer.Option(help="Parts that the walks fall into by the hash of their name.")] = 5,
    fold: Annotated[
        list[str] | None, typer.Option(help="Part to walk; repeat it or say all to pool. Default 0.")
    ] = None,
    floors: Annotated[str, typer.Option(help="Floors, comma-separated; default all.")] = "",
    limit: Annotated[int | None, typer.Option(min=1, help="Walks per floor and fold at most.")] = None,
    jobs: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
    alert_limit: Annotated[float, typer.Option(help="Error that must not pass as usable, metres.")] = 10.0,
    risk: Annotated[float, typer.Option(help="Accepted probability of an error beyond the protection level.")] = 0.01,
    seconds: Annotated[float, typer.Option(help="Longest batch.")] = 1.0,
    bluetooth: Annotated[bool, typer.Option("--bluetooth", help="Phones report beacons, too.")] = False,
    survey_share: Annotated[
        float, typer.Option(help="Make the map of this share of the survey walks, as if it had gaps.")
    ] = 1.0,
    smoothed: Annotated[bool, typer.Option("--smoothed", help="Add rows of the smoothed tracks.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print results.json instead of the tables.")] = False,
) -> None:
    """Survey with some of the recorded walks, walk the others, and compare every answer with the truth."""
    protocol = Protocol(
        folds, _tested(fold or ["0"], folds), limit, seconds, alert_limit, risk, bluetooth, survey_share
    )
    rows = chosen(methods, ROWS, "methods")
    folders = floor_folders(site, split_names(floors))
    make_folder(out)
    answers = _measure(folders, rows, protocol, jobs, smoothed)
    results = {"site": site.resolve().name, **document(answers, protocol)}
    (out / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    _draw(answers, folders, out)
    if as_json:
        json.dump(results, sys.stdout, indent=1)
        print()
        return
    scores = {name: score(found) for name, found in answers.items()}
    console = Console(width=None if sys.stdout.isatty() else 220)
    trusted = integrity_table({name: integrity(found) for name, found in answers.items()}, protocol)
    for table in (error_table(scores), trust_table(scores, protocol), trusted, parts_table(answers)):
        console.print(table)
    for line in LEGEND:
        console.print(line, style="dim", soft_wrap=True, highlight=False)
    console.print(f"{out}: results.json and {len(list(out.glob('*.png')))} plots", highlight=False)


def _measure(
    folders: Sequence[FloorFolder], methods: Mapping[str, Method], protocol: Protocol, jobs: int, smoothed: bool
) -> dict[str, list[Answer]]:
    with counting("reading walks", sum(len(folder.traces) for folder in folders)) as advance:
        walks = read_walks(folders, jobs, advance)
    warm_up()  # compiled once here, not in every worker
    replays = len(methods) * sum(len(walked_in(walks, protocol, fold)) for fold in protocol.tested)
    with counting("walking", replays) as advance:
        answers = run(folders, walks, methods, protocol, jobs, advance)
    if smoothed:
        with counting("smoothing", replays) as advance:
            answers |= late_rows(folders, walks, methods, protocol, jobs, advance)
    return answers


def _draw(answers: Mapping[str, list[Answer]], folders: Sequence[FloorFolder], out: Path) -> None:
    error_distribution(answers, out / "error_cdf.png")
    for name in [name for name in answers if name in METHODS] or list(answers):
        for folder in folders:
            floor = folder.floor.floor
            walks = shown_walks([answer for answer in answers[name] if answer.floor == floor])
            if walks:
                tracks(walks, folder, f"{name}, {floor}", out / f"tracks_{name}_{floor}.png")
        limit_m = answers[name][0].alert_limit_m
        stanford(answers[name], limit_m, f"{name}, alert limit {limit_m:g} m", out / f"stanford_{name}.png")
        walks = shown_walks(answers[name])
        if walks:
            error_over_time(walks, f"{name}: error and protection level", out / f"error_over_time_{name}.png")


def _tested(fold: Sequence[str], folds: int) -> tuple[int, ...]:
    if "all" in fold:
        return tuple(range(folds))
    if not all(one.isdecimal() for one in fold):
        raise InvalidInput(f"fold must be a number from 0 to {folds - 1}, or all", "fold")
    return tuple(sorted({int(one) for one in fold}))
