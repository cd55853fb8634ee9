"""surefix buildings: survey and walk simulated buildings that no setting was chosen on; are levels and alarms true?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from app.commands.named_choices import chosen
from app.commands.out_folder import make_folder
from app.commands.progress import counting
from app.commands.written_results import write_results
from app.evaluation.building_campaign import Visited, pooled, visit_buildings
from app.evaluation.trust_rows import LEGEND, TrustRow, trust_row, trust_rows_table
from app.evaluation.written_figures import plain
from app.fusion.methods import METHODS
from app.fusion.warm_up import warm_up

FIRST_SEED = 4000
"""Buildings of other seeds are free for whoever tunes."""

app = typer.Typer(help=__doc__, add_completion=False, subcommand_metavar="")


@app.callback(invoke_without_command=True)
def buildings(
    out: Annotated[Path, typer.Option(help="Folder for buildings.json and buildings.txt; made if missing.")],
    count: Annotated[int, typer.Option("--buildings", min=1, max=9999, help="Buildings.")] = 20,
    walks: Annotated[int, typer.Option(min=1, max=9999, help="Visits to each.")] = 50,
    methods: Annotated[str, typer.Option(help=f"all, or some of: {', '.join(METHODS)}.")] = "surefix",
    seed: Annotated[
        int, typer.Option(min=0, help="Of the first building; each of the others has the next.")
    ] = FIRST_SEED,
    jobs: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print buildings.json instead of the tables.")] = False,
) -> None:
    """Draw buildings from seeds, survey each, let strangers walk through, and compare every answer with the truth."""
    asked = chosen(methods, METHODS, "methods")
    make_folder(out)
    warm_up()  # compiled once here, not in every worker
    with counting("buildings", count) as advance:
        visited = list(visit_buildings(range(seed, seed + count), walks, asked, jobs=jobs, done=advance))
    document = {"seed": seed, "walks": walks, "methods": plain({name: _rows(visited, name) for name in asked})}
    document["buildings"] = {
        one.traits.name: {**asdict(one.traits), "survey_walks": one.survey_walks} for one in visited
    }
    write_results(out, "buildings", document, lambda console: _print(console, visited, asked), as_json)


def _rows(visited: Sequence[Visited], method: str) -> dict[str, TrustRow]:
    """`all`, each kind of building that occurs, and each building."""
    rows = {"all": trust_row(pooled(visited, method))}
    for kind in sorted({one.traits.kind for one in visited}):
        rows[kind] = trust_row(pooled([one for one in visited if one.traits.kind == kind], method))
    return rows | {one.traits.name: trust_row(one.answers[method]) for one in visited}


def _print(console: Console, visited: Sequence[Visited], methods: Mapping[str, Any]) -> None:
    described = {one.traits.name: _described(one) for one in visited}
    for name in methods:
        rows: dict[tuple[str, ...], TrustRow] = {
            (row, described.get(row, "")): one for row, one in _rows(visited, name).items()
        }
        console.print(trust_rows_table(rows, f"{name} in new buildings", ["buildings", "floors, survey, offset"]))
    for line in LEGEND:
        console.print(line, style="dim", soft_wrap=True, highlight=False)


def _described(one: Visited) -> str:
    traits = one.traits
    return f"{traits.floors}, {traits.survey_m_per_m2:.2f} m/m2, {traits.offset_spread_db:.1f} dB"
