"""The console's files as they are served, over answers that a test gives, and what a real browser makes of them."""

from __future__ import annotations

import json
import subprocess
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from app.api.console import FILES, HEADERS, MEDIA_TYPES
from tests.scenarios.test_demo_page import BROWSER_FLAGS, _browser

DRIVER = "driver.js"
"""What a test does in the page: a script beside the console's."""


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer that is not plain JSON, or not 200."""

    body: bytes
    media_type: str = "application/json"
    status: int = 200
    headers: Mapping[str, str] = field(default_factory=dict)


def refused(status: int, detail: str) -> Answer:
    """A problem document."""
    return Answer(json.dumps({"detail": detail}).encode(), "application/problem+json", status)


@contextmanager
def console_over(answers: Mapping[str, Any], driver: str = "") -> Iterator[str]:
    """The address of a console. answers : by path, JSON's objects, an Answer, or a function that gives either."""
    page = FILES["index.html"].read_text().replace("</head>", f'<script src="console/{DRIVER}" defer></script></head>')

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            name = self.path.removeprefix("/console/")
            if self.path == "/":
                return self.answer(Answer(page.encode(), "text/html", headers=HEADERS))
            if name == DRIVER:
                return self.answer(Answer(driver.encode(), "text/javascript"))
            if name in FILES:
                return self.answer(Answer(FILES[name].read_bytes(), MEDIA_TYPES[Path(name).suffix], headers=HEADERS))
            found = answers.get(self.path, refused(404, "there is none"))
            if callable(found):
                found = found()
            return self.answer(found if isinstance(found, Answer) else Answer(json.dumps(found).encode()))

        def answer(self, one: Answer) -> None:
            self.send_response(one.status)
            self.send_header("Content-Type", one.media_type)
            self.send_header("Content-Length", str(len(one.body)))
            for name, value in one.headers.items():
                self.send_header(name, value)
            self.end_headers()
            self.wfile.write(one.body)

        def log_message(self, *_: Any) -> None:
            """Nothing is printed."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.05,))
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}"
        finally:
            server.shutdown()
            thread.join()


def seen(address: str, folder: Path, budget_ms: int = 6000, size: tuple[int, int] = (1400, 900)) -> str:
    """The page's markup after some time in a browser window of a size, px; its profile is in the folder."""
    flags = BROWSER_FLAGS.replace("budget=6000", f"budget={budget_ms}").split()
    flags.append(f"--window-size={size[0]},{size[1]}")
    command = [_browser(), *flags, "--disable-popup-blocking", f"--user-data-dir={folder}", "--dump-dom", address]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
