"""surefix transfer: leave one floor out - settings learnt from the walks of one floor, judged on another."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.commands.named_choices import split_names
from app.commands.out_folder import make_folder
from app.commands.progress import counting
from app.commands.written_results import write_results
from app.evaluation.campaign import Protocol, read_walks, walked_in
from app.evaluation.recordings import floor_folders
from app.evaluation.transfer import Transferred, floor_walks, learnt_levels, leave_one_floor_out, replays
from app.evaluation.trust_rows import LEGEND, TrustRow, trust_rows_table
from app.evaluation.written_figures import plain
from app.fusion.warm_up import warm_up

# options may follow DIR
app = typer.Typer(
    help=__doc__, add_completion=False, subcommand_metavar="", context_settings={"allow_interspersed_args": True}
)


@app.callback(invoke_without_command=True)
def transfer(
    site: Annotated[Path, typer.Argument(metavar="DIR", help="Folder holding one folder of recorded walks per floor.")],
    out: Annotated[Path, typer.Option(help="Folder for transfer.json and transfer.txt; made if missing.")],
    folds: Annotated[int, typer.Option(help="Parts that the walks fall into by the hash of their name.")] = 5,
    floors: Annotated[str, typer.Option(help="Floors, comma-separated; default all.")] = "",
    limit: Annotated[int | None, typer.Option(min=1, help="Walks per floor and fold at most.")] = None,
    jobs: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print transfer.json instead of the table.")] = False,
) -> None:
    """Choose the settings of surefix on each floor alone, and see what its levels are worth on the others."""
    protocol = Protocol(folds, tuple(range(folds)), limit)
    folders = floor_folders(site, split_names(floors))
    make_folder(out)
    with counting("reading walks", sum(len(folder.traces) for folder in folders)) as advance:
        walks = read_walks(folders, jobs, advance)
    warm_up()  # compiled once here, not in every worker
    tested = sum(len(walked_in(walks, protocol, fold)) for fold in protocol.tested)
    with counting("walking", replays(len(folders), tested)) as advance:
        cut = [floor_walks(folder, walks, protocol, jobs, advance) for folder in folders]
        found = list(leave_one_floor_out(cut, learnt_levels))
    document = {"site": site.resolve().name, "rows": plain(found)}
    write_results(out, "transfer", document, lambda console: _print(console, found), as_json)


def _print(console: Console, found: Sequence[Transferred]) -> None:
    rows: dict[tuple[str, ...], TrustRow] = {}
    for one in found:
        settings = one.settings
        factors = (f"{settings.tail_at(risk):.2f}" for risk in one.row.risks)
        words = (one.judged_on, one.learnt_on, f"{settings.lasting:g}", f"{settings.distance_weight:g}", *factors)
        rows[words] = one.row
    names = ["judged\non", "learnt\non", "lasting", "weight"]
    names += [f"factor\n{risk:g}" for risk in (found[0].row.risks if found else ())]
    console.print(trust_rows_table(rows, "surefix, leave one floor out", names))
    for line in LEGEND:
        console.print(line, style="dim", soft_wrap=True, highlight=False)
