"""The service on loopback in a process of its own, as `surefix serve` starts it."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx

PATIENCE_S = 300.0
_SUREFIX = [sys.executable, "-c", "from app.cli import main; main()"]


@contextmanager
def local_server(folder: Path) -> Iterator[httpx.Client]:
    """A client of a server with an empty database in the folder; one worker, no keys.

    Raises
    ------
    RuntimeError : it did not start; what it printed is in `server.log` of the folder.
    """
    database = f"sqlite:///{folder / 'benchmark.db'}"
    subprocess.run([*_SUREFIX, "migrate", "--database", database], check=True, stdout=subprocess.DEVNULL)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    with (folder / "server.log").open("wb") as log:
        process = subprocess.Popen(
            [*_SUREFIX, "serve", "--port", str(port), "--database", database], stdout=log, stderr=log
        )
    try:
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=300.0, trust_env=False) as client:
            _wait(client, process)
            yield client
    finally:
        process.terminate()
        process.wait(PATIENCE_S)


def _wait(client: httpx.Client, process: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline and process.poll() is None:
        try:
            if client.get("/readyz").is_success:
                return
        except httpx.TransportError:
            time.sleep(0.05)
    raise RuntimeError("the server did not start")
