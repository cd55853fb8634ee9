"""A real HTTP server that webhooks are delivered to: keeps what comes, and answers as it is told."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

PATIENCE_S = 20.0


@dataclass(frozen=True)
class Received:
    """One request. at_s : monotonic clock."""

    headers: Mapping[str, str]
    body: bytes
    at_s: float


@dataclass
class Receiver:
    """What arrived so far, in order. statuses : answers to come; 204 after the last.  hold : answers wait for it."""

    url: str
    arrived: queue.Queue[Received] = field(default_factory=queue.Queue)
    statuses: queue.Queue[int] = field(default_factory=queue.Queue)
    hold: threading.Event = field(default_factory=threading.Event)

    def next(self) -> Received:
        """The next request; fails where none comes."""
        return self.arrived.get(timeout=PATIENCE_S)


@contextmanager
def webhook_receiver(port: int = 0, holding: bool = False) -> Iterator[Receiver]:
    """A receiver on loopback. port : 0 for a free one.  holding : begin with answers withheld."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            receiver.arrived.put(Received(dict(self.headers), body, time.monotonic()))
            receiver.hold.wait(PATIENCE_S)
            status = 204 if receiver.statuses.empty() else receiver.statuses.get()
            self.send_response(status)
            if status in (301, 302, 307, 308):
                self.send_header("Location", receiver.url + "elsewhere")
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, *_: Any) -> None:
            """Nothing is printed."""

    with ThreadingHTTPServer(("127.0.0.1", port), Handler) as server:
        receiver = Receiver(f"http://127.0.0.1:{server.server_address[1]}/")
        if not holding:
            receiver.hold.set()
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        try:
            yield receiver
        finally:
            receiver.hold.set()
            server.shutdown()
            thread.join()
