"""surefix simulate: a seeded building with survey walks, as files in the open data's format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

from app.commands.out_folder import make_folder
from app.errors import InvalidInput
from app.simulation.recording import make_world
from app.simulation.site import survey_walks, write_plans, write_walk

app = typer.Typer(help=__doc__, add_completion=False, subcommand_metavar="")


@app.callback(invoke_without_command=True)
def simulate(
    out: Annotated[Path, typer.Option(help="Folder to write, one folder a floor in it; must be new or empty.")],
    site: Annotated[str, typer.Option(help="Name of the building.")] = "simulated",
    building: Annotated[str, typer.Option(help="Kind: office, mall or hospital.")] = "mall",
    floors: Annotated[int, typer.Option(min=1, max=40, help="Floors.")] = 2,
    walks: Annotated[int, typer.Option(min=1, max=9999, help="Walks a floor.")] = 60,
    rate: Annotated[float, typer.Option(min=20.0, max=200.0, help="Sensor samples a second.")] = 50.0,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same files.")] = 1,
) -> None:
    """Write floor plans and recorded walks of a building that does not exist."""
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InvalidInput(f"{out} is not an empty folder; name another, or remove it first", "out")
    world = make_world(site, building, floors, seed)
    make_folder(out)
    write_plans(world, out)
    console = Console(stderr=True)
    with Progress(
        *Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeRemainingColumn(), console=console
    ) as bar:
        for floor in world.building.floors:
            for name, recording in bar.track(
                survey_walks(world, floor, walks, seed, rate), total=walks, description=f"{floor.floor} walks"
            ):
                write_walk(world, out, name, recording)
    networks, radios = len(world.access_points.bssid), len(world.access_points.level)
    console.print(f"{out}: {floors} floors, {walks} walks each, {networks} networks of {radios} radios, seed {seed}")
