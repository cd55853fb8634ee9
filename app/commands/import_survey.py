"""surefix import: recorded surveys from a folder into a venue, with what could not be used row by row."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import httpx
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from app.commands.import_destination import DatabaseDestination, Destination, Existing, ServiceDestination
from app.commands.import_sources import ImportPart, ImportPlan, find_sources
from app.commands.service_address import service_address
from app.errors import InvalidInput, SurefixError
from app.services.identifiers import refuse_identifier
from app.settings import settings_of
from app.survey.admission import FloorExtent
from app.survey.rejection import Rejection, Rejections
from app.survey.upload import SurveyFindings, UselessSurvey, read_upload

SHOWN = 20
"""Rejections printed; --json has all that are listed."""

# options may follow DIR
app = typer.Typer(
    help=__doc__, add_completion=False, subcommand_metavar="", context_settings={"allow_interspersed_args": True}
)
_progress_console = Console(stderr=True)


@app.callback(invoke_without_command=True)
def import_survey(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", help="Traces (a folder a floor), CSV, UJIIndoorLoc CSV or GetSensorData logs; or one file."
        ),
    ],
    venue: Annotated[str, typer.Option(help="Venue to import into; made if there is none.")],
    database: Annotated[str, typer.Option(help="Write straight into it; default: SUREFIX_DATABASE.")] = "",
    url: Annotated[str, typer.Option(help="Send to the service at this address instead.")] = "",
    key: Annotated[
        str | None, typer.Option(help="API key of scopes survey and admin, for --url.", envvar="SUREFIX_KEY")
    ] = None,
    publish: Annotated[bool, typer.Option(help="Build the next radio map of all surveys and make it active.")] = True,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Read and report; change nothing.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Import what DIR holds; exit code 1 if nothing of it could be used."""
    if url and database:
        raise InvalidInput("name a database or the address of a service, not both", "url")
    refuse_identifier(venue, "venue")
    with tempfile.TemporaryDirectory(prefix="surefix-import-") as scratch, _destination(url, key, database) as there:
        existing = there.floors(venue)
        sources = find_sources(folder, Path(scratch), {floor: frame for floor, (_, frame) in (existing or {}).items()})
        report = _run(sources, there, venue, existing, publish, dry_run)
    if as_json:
        typer.echo(json.dumps(report))
    else:
        _print(report)
    if not report["accepted"]:
        raise typer.Exit(1)


@contextmanager
def _destination(url: str, key: str | None, database: str) -> Iterator[Destination]:
    there: Destination
    if url:
        headers = {"Authorization": f"Bearer {key}"} if key else {}
        there = ServiceDestination(httpx.Client(base_url=service_address(url), headers=headers))
    else:
        there = DatabaseDestination(database or settings_of({}).database)
    try:
        yield there
    finally:
        there.close()


def _run(
    sources: ImportPlan, there: Destination, venue: str, existing: Existing | None, publish: bool, dry_run: bool
) -> dict[str, Any]:
    """Read every part, then make the floors that are missing and store what can be used."""
    rejections = sources.rejections
    extents = {one.floor: FloorExtent(one.floor, one.width_m, one.height_m) for one in sources.floors.values()}
    extents |= {floor: extent for floor, (extent, _) in (existing or {}).items()}
    layout = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    surveys: list[dict[str, Any]] = []
    version = None
    with (
        Progress(*layout, console=_progress_console) as bar,
        tempfile.TemporaryDirectory(prefix="surefix-import-") as at,
    ):
        reading = bar.add_task("reading", total=len(sources.parts))
        usable: list[tuple[ImportPart, SurveyFindings, Path]] = []
        for number, part in enumerate(sources.parts):
            bar.update(reading, description=f"reading {part.label}")
            findings = _read(part, extents, Path(at) / str(number), rejections)
            if findings is not None:
                usable.append((part, findings, Path(at) / str(number)))
            bar.advance(reading)
        storing = bar.add_task("storing", total=len(usable), visible=bool(usable) and not dry_run)
        new = (
            []
            if dry_run or not usable
            else [one for name, one in sources.floors.items() if name not in (existing or {})]
        )
        if usable and not dry_run:
            if existing is None:
                there.make_venue(venue)
            for floor in new:
                there.make_floor(venue, floor)
        for part, findings, spool in usable:
            receipt: dict[str, Any] = {"survey": None, "accepted": findings.accepted}
            if not dry_run:
                bar.update(storing, description=f"storing {part.label}")
                last = part is usable[-1][0]
                receipt = there.add(venue, part.upload, findings, spool, publish and last)
                version = receipt.get("version")
                bar.advance(storing)
            floors = dict(findings.per_floor)
            surveys.append(
                {"source": part.label, "survey": receipt["survey"], "accepted": receipt["accepted"], "floors": floors}
            )
    return {
        "venue": venue,
        "dry_run": dry_run,
        "new_floors": [one.floor for one in new],
        "surveys": surveys,
        "accepted": sum(one["accepted"] for one in surveys),
        "rejected": [{"item": one.item, "reason": one.reason} for one in rejections.listed],
        "rejected_count": rejections.count,
        "skipped": sources.skipped,
        "version": version,
    }


def _read(
    part: ImportPart, extents: dict[str, FloorExtent], spool: Path, rejections: Rejections
) -> SurveyFindings | None:
    try:
        findings = read_upload(part.upload, extents, spool)
    except UselessSurvey as error:
        rejections.extend(_of(part, error.rejected), error.rejected_count)
        return None
    except SurefixError as error:
        rejections.add(part.label, str(error))
        return None
    rejections.extend(_of(part, findings.rejected), findings.rejected_count)
    return findings


def _of(part: ImportPart, rejected: Iterable[Rejection]) -> list[Rejection]:
    """The same; a row says what it is a row of, since several files may be imported at once."""
    return [
        one if isinstance(one.item, str) else Rejection(f"{part.label} row {one.item}", one.reason) for one in rejected
    ]


def _print(report: dict[str, Any]) -> None:
    console = Console()
    table = Table("source", "survey", "fingerprints", "floors", box=None)
    for one in report["surveys"]:
        floors = ", ".join(f"{floor} {count}" for floor, count in sorted(one["floors"].items()))
        table.add_row(one["source"], str(one["survey"] or "-"), str(one["accepted"]), floors)
    console.print(table)
    if report["rejected_count"]:
        console.print(f"{report['rejected_count']} rejected:", highlight=False)
        for one in report["rejected"][:SHOWN]:
            console.print(f"  {one['item']}: {one['reason']}", markup=False, highlight=False, soft_wrap=True)
        if report["rejected_count"] > SHOWN:
            console.print(f"  and {report['rejected_count'] - SHOWN} more; --json lists them", highlight=False)
    for path in report["skipped"]:
        console.print(f"  {path}: not a survey, skipped", markup=False, highlight=False, style="dim", soft_wrap=True)
    if report["dry_run"]:
        console.print("Nothing was stored (--dry-run).")
    elif report["version"] is not None:
        console.print(f"Radio map version {report['version']} of venue {report['venue']} is active.", highlight=False)
