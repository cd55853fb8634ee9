"""A real PostgreSQL server for tests, on a socket in a folder of its own: it can be killed and come back."""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import pytest

PATIENCE_S = 60.0
ROLE = "surefix"
SERVER_ACCOUNTS = ("postgres", "nobody")
"""PostgreSQL refuses to run as root: where the tests do, it runs as the first of these."""


class PostgresqlProcess:
    """A server whose data nobody needs after a crash of the machine."""

    def __init__(self) -> None:
        self._programs = _programs()
        self._account = _server_account()
        # not under pytest's own folder, which other accounts may not enter
        self._folder = Path(tempfile.mkdtemp(prefix="surefix-postgresql-"))
        if self._account is not None:
            shutil.chown(self._folder, self._account)
        self._process: subprocess.Popen[bytes] | None = None
        self._databases = 0
        self._run("initdb", "--auth=trust", "--username", ROLE, "--encoding=UTF8", "--no-sync", "-D", self._data)

    @property
    def _data(self) -> str:
        return str(self._folder / "data")

    def _command(self, program: str, *arguments: str) -> list[str]:
        return [str(self._programs / program), *arguments]

    def _run(self, program: str, *arguments: str) -> None:
        done = subprocess.run(
            self._command(program, *arguments), user=self._account, capture_output=True, text=True, cwd=self._folder
        )
        assert done.returncode == 0, f"{program}: {done.stderr}"

    def start(self) -> None:
        """Start it and wait until it answers."""
        options = ["-c", "listen_addresses=", "-c", f"unix_socket_directories={self._folder}", "-c", "fsync=off"]
        self._process = subprocess.Popen(
            self._command("postgres", "-D", self._data, *options),
            user=self._account,
            cwd=self._folder,
            stdout=subprocess.DEVNULL,
            stderr=(self._folder / "log").open("ab"),
        )
        probe = self._command("pg_isready", "--quiet", "--host", str(self._folder))
        deadline = time.monotonic() + PATIENCE_S
        while subprocess.run(probe, check=False).returncode:
            log = (self._folder / "log").read_text()
            assert self._process.poll() is None and time.monotonic() < deadline, f"PostgreSQL did not start: {log}"
            time.sleep(0.05)  # polls another process

    def new_database(self) -> str:
        """The address of a database without tables."""
        self._databases += 1
        name = f"test{self._databases}"
        self._run("createdb", "--host", str(self._folder), "--username", ROLE, name)
        return f"postgresql://{ROLE}@/{name}?host={self._folder}"

    def kill(self) -> None:
        """End it at once, as a crash would."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None
            (Path(self._data) / "postmaster.pid").unlink(missing_ok=True)

    def freeze(self) -> None:
        """Stop it and all that it has forked: it is there, and says nothing until it is thawed."""
        server = self._server()
        os.kill(server.pid, signal.SIGSTOP)
        os.waitid(os.P_PID, server.pid, os.WSTOPPED | os.WNOWAIT)  # from here on it forks nothing
        stopped: set[int] = set()
        while more := self._children() - stopped:  # a list read while one of them ends may miss others
            for child in more:
                os.kill(child, signal.SIGSTOP)
            stopped |= more

    def thaw(self) -> None:
        """Let it go on."""
        for process in (self._server().pid, *self._children()):
            os.kill(process, signal.SIGCONT)

    def _server(self) -> subprocess.Popen[bytes]:
        assert self._process is not None
        return self._process

    def _children(self) -> set[int]:
        process = self._server().pid
        return {int(child) for child in Path(f"/proc/{process}/task/{process}/children").read_text().split()}

    def remove(self) -> None:
        """End it, and leave nothing behind."""
        self.kill()
        shutil.rmtree(self._folder)


def _programs() -> Path:
    """The newest version's programs; packages do not put them all on the path."""
    versions = sorted(Path("/usr/lib/postgresql").glob("*/bin/postgres"), key=lambda path: int(path.parts[-3]))
    found = str(versions[-1]) if versions else shutil.which("postgres")
    if found is None:
        reason = "PostgreSQL is not installed: apt-get install postgresql"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    return Path(found).resolve().parent


def _server_account() -> str | None:
    """The account to run as, None for our own."""
    if os.geteuid() != 0:
        return None
    known = {account.pw_name for account in pwd.getpwall()}
    return next((name for name in SERVER_ACCOUNTS if name in known), None)
