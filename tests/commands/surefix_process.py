"""The surefix command in a process of its own."""

from __future__ import annotations

import os
import queue
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

PATIENCE_S = 120.0
_PROGRAM = [sys.executable, "-c", "from app.cli import main; main()"]
_ADDRESS = re.compile(r"http://\S+")


def surefix(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """What the command prints and its exit code, run in that folder without settings of the environment."""
    return subprocess.run(
        [*_PROGRAM, *arguments],
        cwd=folder,
        env=_environment(),
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )


@dataclass
class Serving:
    """A `surefix serve` that has said where it is."""

    process: subprocess.Popen[str]
    address: str

    def stop(self) -> int:
        """Ask it to end, as an operator does; its exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(PATIENCE_S)


@contextmanager
def serving(arguments: Sequence[str], folder: Path) -> Iterator[Serving]:
    """A server that is ready; stopped at the end."""
    process = subprocess.Popen(
        [*_PROGRAM, "serve", *arguments], cwd=folder, env=_environment(), stdout=subprocess.PIPE, text=True
    )
    try:
        yield Serving(process, _announced(process))
    finally:
        if process.poll() is None:
            process.terminate()
            process.wait(PATIENCE_S)
        assert process.stdout is not None
        process.stdout.close()


def _announced(process: subprocess.Popen[str]) -> str:
    """The address that the server prints once it is ready."""
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()
    assert process.stdout is not None
    threading.Thread(target=lambda: lines.put(process.stdout.readline()), daemon=True).start()  # type: ignore[union-attr]
    found = _ADDRESS.search(lines.get(timeout=PATIENCE_S))
    assert found is not None, "the server ended without saying where it is"
    return found[0].rstrip("/")


def _environment() -> dict[str, str]:
    root = str(Path(__file__).parents[2])
    return {**{key: value for key, value in os.environ.items() if not key.startswith("SUREFIX_")}, "PYTHONPATH": root}
