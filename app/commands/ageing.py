"""surefix ageing: what a radio map is worth months after its survey, simulated and in a building surveyed twice."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.commands.named_choices import refuse_unknown
from app.commands.out_folder import make_folder
from app.commands.progress import counting
from app.commands.written_results import write_results
from app.errors import InvalidInput
from app.evaluation.ageing_campaign import MONTHS, visit_ageing_buildings
from app.evaluation.trust_rows import LEGEND, TrustRow, trust_row, trust_rows_table
from app.evaluation.two_surveys import CASES, read_standing, two_surveys
from app.evaluation.written_figures import plain
from app.fusion.methods import METHODS
from app.fusion.warm_up import warm_up

FIRST_SEED = 5000

# options may follow DIR
app = typer.Typer(
    help=__doc__, add_completion=False, subcommand_metavar="", context_settings={"allow_interspersed_args": True}
)


@app.callback(invoke_without_command=True)
def ageing(
    out: Annotated[Path, typer.Option(help="Folder for ageing.json and ageing.txt; made if missing.")],
    site: Annotated[
        Path | None, typer.Argument(metavar="[DIR]", help="um_dsi: a folder for each survey, the earliest is the map.")
    ] = None,
    buildings: Annotated[int, typer.Option(min=1, max=9999, help="Simulated buildings.")] = 6,
    walks: Annotated[int, typer.Option(min=1, max=9999, help="Visits to each at each age.")] = 16,
    method: Annotated[str, typer.Option(help=f"One of: {', '.join(METHODS)}.")] = "surefix",
    seed: Annotated[
        int, typer.Option(min=0, help="Of the first building; each of the others has the next.")
    ] = FIRST_SEED,
    jobs: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print ageing.json instead of the tables.")] = False,
) -> None:
    """Survey once, let the access points age, and ask the old map."""
    refuse_unknown([method], METHODS, "method")
    surveys = None if site is None else _two_surveys(site)
    make_folder(out)
    warm_up()  # compiled once here, not in every worker
    with counting("buildings", buildings) as advance:
        ages = visit_ageing_buildings(range(seed, seed + buildings), walks, METHODS[method], MONTHS, jobs, advance)
    tables: dict[str, dict[tuple[str, ...], TrustRow]] = {
        "months": {(f"{one.months:g}", f"{100.0 * one.changed:.0f} %"): trust_row(one.answers) for one in ages}
    }
    if surveys is not None:
        first, second = (read_standing(folder) for folder in surveys)
        with counting("surveys", CASES) as advance:
            asked = two_surveys(first, second, METHODS[method], jobs, advance)
        tables["surveys"] = {(name,): trust_row(answers) for name, answers in asked.items()}
    document = {
        "seed": seed,
        "method": method,
        "months": [{"months": one.months, "changed": one.changed, **plain(trust_row(one.answers))} for one in ages],
        "surveys": {name: plain(row) for (name,), row in tables.get("surveys", {}).items()},
    }
    write_results(out, "ageing", document, lambda console: _print(console, method, tables), as_json)


def _two_surveys(site: Path) -> list[Path]:
    folders = sorted(path.parent for path in site.glob("*/rssis.csv.xz"))
    if len(folders) < 2:
        raise InvalidInput(f"{site} holds {len(folders)} surveys where two are expected", site.name)
    return [folders[0], folders[-1]]


def _print(console: Console, method: str, tables: Mapping[str, Mapping[tuple[str, ...], TrustRow]]) -> None:
    titles = {"months": "months after the survey", "surveys": "single scans in a building surveyed twice"}
    named = {"months": ["months", "changed"], "surveys": ["asked"]}
    for name, rows in tables.items():
        console.print(trust_rows_table(rows, f"{method}, {titles[name]}", named[name]))
    for line in LEGEND:
        console.print(line, style="dim", soft_wrap=True, highlight=False)
