"""surefix demo: a simulated building, surveyed and full of walking phones, on a real server."""

from __future__ import annotations

import asyncio
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated

import httpx
import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from app.errors import SurefixError
from app.settings import Settings
from app.simulation.recording import World, make_world
from app.simulation.visitors import Visitors, open_venue, survey_venue

SURVEY_WALKS = 24
"""A floor; enough that every corridor is walked."""
START_PATIENCE_S = 300.0
"""The first start compiles the kernels, on a slow machine for minutes."""
STOP_PATIENCE_S = 10.0

app = typer.Typer(help=__doc__, add_completion=False, subcommand_metavar="")
console = Console(stderr=True, highlight=False)


@app.callback(invoke_without_command=True)
def demo(
    phones: Annotated[int, typer.Option(min=0, max=200, help="Phones walking at once.")] = 8,
    building: Annotated[str, typer.Option(help="Kind: office, mall or hospital.")] = "office",
    floors: Annotated[int, typer.Option(min=1, max=9, help="Floors.")] = 2,
    seed: Annotated[int, typer.Option(min=0, help="Decides the building and who walks where.")] = 1,
    port: Annotated[int, typer.Option(min=0, max=65535, help="A free one is taken where this is in use.")] = (
        Settings.model_fields["port"].default
    ),
    speed: Annotated[float, typer.Option(min=0.1, max=60.0, help="Seconds walked in one second.")] = 1.0,
    seconds: Annotated[float, typer.Option(min=0.0, help="Stop after walking so long; 0: at Ctrl-C.")] = 0.0,
    database: Annotated[str, typer.Option(help="Keep the data here; default: a file removed at the end.")] = "",
) -> None:
    """Serve a building that does not exist, with phones walking through it."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # the server is stopped however the demo is
    with tempfile.TemporaryDirectory(prefix="surefix-demo-") as folder:
        url = database or f"sqlite:///{Path(folder) / 'demo.db'}"
        try:
            world = make_world(f"demo-{building}-{seed}", building, floors, seed)
            with _server(_free_port(port), url) as (address, server):
                console.print(
                    f"\n  Surefix is running at [bold]{address}/[/bold]   (API: {address}/docs)\n", soft_wrap=True
                )
                _prepare(address, world, seed)
                console.print(f"  {phones} phones are walking. Ctrl-C stops.")
                asyncio.run(_walk(address, server, Visitors(world, seed, speed, _complain), phones, seconds))
        except KeyboardInterrupt:
            pass
    console.print("  Stopped.")


def _free_port(wanted: int) -> int:
    """The wanted port, or where that is taken one that the system chooses."""
    for port in (wanted, 0):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return int(probe.getsockname()[1])
    raise SurefixError("no port is free on 127.0.0.1")


@contextmanager
def _server(port: int, database: str) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """The service on loopback in a process of its own, migrated and ready."""
    if _surefix("migrate", "--database", database).wait() != 0:
        raise SurefixError("there is no database to keep the data in; what was printed above says why")
    console.print("  Starting the server; the first time this takes about a minute.", style="dim")
    process = _surefix("serve", "--host", "127.0.0.1", "--port", str(port), "--database", database)
    address = f"http://127.0.0.1:{port}"
    try:
        deadline = time.monotonic() + START_PATIENCE_S
        while not _ready(address):
            if process.poll() is not None or time.monotonic() > deadline:
                raise SurefixError("the server did not start; what it printed above says why")
            time.sleep(0.1)
        yield address, process
    finally:
        process.terminate()
        try:
            process.wait(STOP_PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _surefix(*arguments: str) -> subprocess.Popen[bytes]:
    """The surefix command in this interpreter, in a session of its own: Ctrl-C must reach the demo first.

    What it says on standard output the demo says itself; what is wrong comes on standard error.
    """
    program = [sys.executable, "-c", "from app.cli import main; main()", *arguments]
    return subprocess.Popen(program, stdout=subprocess.DEVNULL, start_new_session=True)


def _ready(address: str) -> bool:
    try:
        return httpx.get(f"{address}/readyz", timeout=5.0, trust_env=False).is_success
    except httpx.HTTPError:
        return False


def _prepare(address: str, world: World, seed: int) -> None:
    """Venue, floors, survey and radio map, unless the database has them from an earlier demo."""
    with httpx.Client(base_url=address, timeout=300.0, trust_env=False) as client:
        if not open_venue(client, world):
            return
        layout = (TextColumn("  {task.description}"), BarColumn())
        with Progress(*layout, console=console, transient=True) as progress:
            total = len(world.building.floors) * (SURVEY_WALKS + 1)
            task = progress.add_task("surveying", total=total)
            for done in survey_venue(client, world, SURVEY_WALKS, seed):
                progress.update(task, advance=1, description=done)


async def _walk(address: str, server: subprocess.Popen[bytes], visitors: Visitors, phones: int, seconds: float) -> None:
    """Phones walk until the time is over, a signal comes, or the server is gone."""
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stop.set)
    if seconds:
        loop.call_later(seconds, stop.set)
    async with httpx.AsyncClient(base_url=address, timeout=30.0, trust_env=False) as client:
        walking = [asyncio.create_task(visitors.walk(client, number)) for number in range(phones)]
        while not stop.is_set() and server.poll() is None:
            with suppress(TimeoutError):
                await asyncio.wait_for(stop.wait(), 1.0)
            for task in walking:
                if task.done():
                    task.result()  # only a defect ends a phone: raise it
        for task in walking:
            task.cancel()
        await asyncio.gather(*walking, return_exceptions=True)
    if server.poll() is not None:
        raise SurefixError("the server stopped by itself; what it printed above says why")
    console.print(f"  {visitors.batches_sent} batches were answered.")


def _complain(message: str) -> None:
    console.print(f"  {message}", style="red", markup=False, soft_wrap=True)
