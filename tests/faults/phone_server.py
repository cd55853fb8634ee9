"""A real server of the phones' endpoints in a process of its own, to be killed."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType

import httpx

PATIENCE_S = 30.0
ROOT = Path(__file__).parents[2]


class PhoneServer:
    """The process, and a client of it."""

    def __init__(self, database: str, sessions: str = "memory") -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self._port = int(probe.getsockname()[1])
        self._arguments = [database, sessions, str(self._port)]
        self._process = self._started()
        self.client = httpx.Client(
            base_url=f"http://127.0.0.1:{self._port}",
            headers={"Authorization": "Bearer key"},
            timeout=PATIENCE_S,
            trust_env=False,
        )
        self._wait()

    def _started(self) -> subprocess.Popen[bytes]:
        return subprocess.Popen([sys.executable, "-m", "tests.faults.phone_server", *self._arguments], cwd=ROOT)

    def _wait(self) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while True:
            assert self._process.poll() is None and time.monotonic() < deadline, "the server did not start"
            try:
                self.client.get("/v1/sessions/none/fix")
            except httpx.TransportError:
                time.sleep(0.05)
            else:
                return

    def kill(self) -> None:
        """SIGKILL: no goodbye."""
        self._process.kill()
        self._process.wait()

    def restart(self) -> None:
        """Kill it, and start it again where it was."""
        self.kill()
        self._process = self._started()
        self._wait()

    def __enter__(self) -> PhoneServer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.client.close()
        self.kill()


def main() -> None:
    """Serve until killed."""
    import uvicorn

    from tests.api.phone_service import wire

    database, sessions, port = sys.argv[1:]
    uvicorn.run(wire(database, sessions).app, host="127.0.0.1", port=int(port), log_level="warning")


if __name__ == "__main__":
    main()
