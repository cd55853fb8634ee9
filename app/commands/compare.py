"""surefix compare: every method and ablation on recorded walks and on the papers' simulated sites, as one page."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from app.commands.named_choices import chosen
from app.commands.out_folder import make_folder
from app.commands.progress import counting
from app.errors import InvalidInput
from app.evaluation.alone import ROWS
from app.evaluation.campaign import Protocol, read_walks, run, walked_in
from app.evaluation.comparison import OPEN, figures, on_site, steps_walked
from app.evaluation.comparison_page import page
from app.evaluation.comparison_plots import site_distribution
from app.evaluation.paper_sites import PaperSite, paper_sites
from app.evaluation.plots import shown_walks, tracks
from app.evaluation.recordings import FloorFolder, RecordedWalk, floor_folders
from app.evaluation.replay import Answer
from app.evaluation.written_figures import plain
from app.fusion.interface import Method
from app.fusion.methods import METHODS
from app.fusion.warm_up import warm_up
from app.simulation.plan_files import plan_image

_DRAWN = (*METHODS, "wifi_alone", "pdr_alone")

# options may follow DIR
app = typer.Typer(
    help=__doc__, add_completion=False, subcommand_metavar="", context_settings={"allow_interspersed_args": True}
)
_console = Console(stderr=True)


@app.callback(invoke_without_command=True)
def compare(
    site: Annotated[Path, typer.Argument(metavar="DIR", help="Folder holding one folder of recorded walks per floor.")],
    out: Annotated[Path, typer.Option(help="Folder for results.json, comparison.md and the plots; made if missing.")],
    target: Annotated[
        Path | None, typer.Option("--page", help="Also write the page here, its plots beside it.")
    ] = None,
    methods: Annotated[str, typer.Option(help="all, or rows, comma-separated.")] = "all",
    sites: Annotated[str, typer.Option(help="all, or simulated sites, comma-separated.")] = "all",
    limit: Annotated[int | None, typer.Option(min=1, help="Walks per floor and fold, and per site, at most.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the simulated sites.")] = 1,
    jobs: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
    again: Annotated[bool, typer.Option(help="Write the page anew from OUT/results.json, walking nothing.")] = False,
) -> None:
    """Walk everything with everything, and write down how it compares with what the papers say."""
    results = out / "results.json"
    if again:
        if not results.exists():
            raise InvalidInput(f"{results} is not there; compare without --again first", "again")
        document = json.loads(results.read_text())
    else:
        rows = chosen(methods, ROWS, "methods")
        papers = chosen(sites, {paper.site: paper for paper in paper_sites()}, "sites")
        folders = floor_folders(site)
        make_folder(out)
        warm_up()  # compiled once here, not in every worker
        began = time.monotonic()
        document = {"seed": seed, "jobs": jobs, "sites": {}}
        for paper in papers.values():
            paper = paper if limit is None else replace(paper, walks=min(limit, paper.walks))
            document["sites"][paper.site] = _on_site(paper, rows, seed, jobs, out)
        on_sites_s = time.monotonic() - began
        document[OPEN] = _on_open_walks(folders, rows, limit, jobs, out)
        document["seconds"] = time.monotonic() - began
        document[OPEN]["seconds"] = document["seconds"] - on_sites_s
        results.write_text(json.dumps(document, indent=1) + "\n")
    (out / "comparison.md").write_text(page(document, "."))
    if target is not None:
        pictures = target.parent / target.stem
        make_folder(pictures, "page")
        for picture in sorted(out.glob("cdf_*.png")):
            shutil.copyfile(picture, pictures / picture.name)
        target.write_text(page(document, target.stem))
    _console.print(f"{out}: comparison.md, results.json, {len(list(out.glob('*.png')))} plots", highlight=False)


def _on_site(paper: PaperSite, methods: Mapping[str, Method], seed: int, jobs: int, out: Path) -> dict[str, Any]:
    with counting(paper.site, paper.walks * len(methods)) as advance:
        site, answers = on_site(paper, methods, seed, jobs, advance)
    steps = sum(map(steps_walked, site.walks))
    _draw_cdf(answers, paper.site, paper.title, out)
    plan = out / f"plan_{paper.site}.png"
    plan.write_bytes(plan_image(site.world.building.floors[0]))
    shown = {name: _sparse(found) for name, found in answers.items() if name == paper.method}
    _draw_tracks(shown, replace(site.folder, image=plan), paper.site, paper.method, out)
    rows = {name: plain(figures(found, steps, site.gross_s)) for name, found in answers.items()}
    described = {name: getattr(paper, name) for name in ("title", "method", "stated", "assumed", "walks")}
    return {**described, "rows": rows}


def _on_open_walks(
    folders: Sequence[FloorFolder], methods: Mapping[str, Method], limit: int | None, jobs: int, out: Path
) -> dict[str, Any]:
    protocol = Protocol(tested=tuple(range(Protocol().folds)), limit=limit)
    with counting("reading walks", sum(len(folder.traces) for folder in folders)) as advance:
        walks = read_walks(folders, jobs, advance)
    tested = {fold: walked_in(walks, protocol, fold) for fold in protocol.tested}
    with counting("open walks", len(methods) * sum(map(len, tested.values()))) as advance:
        answers = run(folders, walks, methods, protocol, jobs, advance)
    _draw_cdf(answers, OPEN, "Open walks, all folds", out)
    for folder in folders:
        here = {name: [a for a in found if a.floor == folder.floor.floor] for name, found in answers.items()}
        for name in METHODS:
            _draw_tracks(here, folder, f"{OPEN}_{folder.floor.floor}", name, out)
    parts: dict[str, Any] = {}
    for part, folds in [("pooled", protocol.tested), *((f"fold {fold}", (fold,)) for fold in protocol.tested)]:
        steps = _steps([walk for fold in folds for walk in tested[fold]])
        of_part = {name: [a for a in found if a.fold in folds] for name, found in answers.items()}
        parts[part] = {name: plain(figures(found, steps)) for name, found in of_part.items()}
    return {"walks": {f"fold {fold}": len(walked) for fold, walked in tested.items()}, "parts": parts}


def _steps(walks: Sequence[RecordedWalk]) -> int:
    return sum(map(steps_walked, walks))


def _draw_cdf(answers: Mapping[str, Sequence[Answer]], name: str, title: str, out: Path) -> None:
    drawn = {row: answers[row] for row in _DRAWN if row in answers} or answers
    site_distribution(drawn, title, out / f"cdf_{name}.png")


def _draw_tracks(
    answers: Mapping[str, Sequence[Answer]], folder: FloorFolder, name: str, method: str, out: Path
) -> None:
    walks = shown_walks(answers.get(method, ()))
    if walks:
        tracks(walks, folder, f"{method}, {name}", out / f"tracks_{name}_{method}.png")


def _sparse(answers: Sequence[Answer]) -> list[Answer]:
    """The answers with a waypoint marked every ten seconds only, where the truth is known at every one."""
    return [replace(answer, waypoint=index % 10 == 0) for index, answer in enumerate(answers)]
