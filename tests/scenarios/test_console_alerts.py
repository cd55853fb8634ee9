"""The console in a real browser, over a service that plays one phone's alert from beginning to end."""

from __future__ import annotations

import json
import re
import subprocess
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from app.api.console import FILES, MEDIA_TYPES
from tests.scenarios.test_demo_page import BROWSER_FLAGS, _browser

FLAGS = ("nominal", "fault", "fault", "nominal", "fault")
"""Poll by poll; the last stays."""
VENUE = {"venue": "mall", "name": "Mall", "created": 0, "version": 1}
FLOOR = {"floor": "F1", "name": "F1", "level": 0, "width": 40.0, "height": 20.0, "georeference": None}
MARKUP = "<b>moved</b>"


def phone(name: str, flag: str) -> dict[str, Any]:
    excluded = [{"bssid": "a8:0c:ca:03:9d:d7", "reason": MARKUP}, {"observation": "wifi", "reason": "far"}]
    integrity = {"flag": flag, "usable": flag != "fault", "protection_level": 6.0, "alert_limit": 10.0, "risk": 0.01}
    integrity["excluded"] = excluded if flag == "fault" else []
    position = {"x": 5.0, "y": 5.0, "floor": "F1", "latitude": None, "longitude": None}
    fix = {"position": position, "accuracy": 2.0, "heading": 1.0, "integrity": integrity}
    return {"phone": name, "age": 0.5, "fix": fix}


@pytest.fixture
def address() -> Iterator[str]:
    polls = iter(FLAGS)

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            name = "index.html" if self.path == "/" else self.path.removeprefix("/console/")
            if name in FILES:
                return self.answer(FILES[name].read_bytes(), MEDIA_TYPES[Path(name).suffix])
            answers: dict[str, Any] = {
                "/v1/venues": {"venues": [VENUE]},
                "/v1/venues/mall": {**VENUE, "floors": [FLOOR]},
                "/v1/venues/mall/floors/F1": {**FLOOR, "plan": None},
            }
            if self.path == "/v1/venues/mall/phones":
                phones = {"phones": [phone("ab12cd", next(polls, FLAGS[-1])), phone("ef34ab", "nominal")]}
                return self.answer(json.dumps(phones).encode(), "application/json")
            if self.path in answers:
                return self.answer(json.dumps(answers[self.path]).encode(), "application/json")
            return self.send_error(404)

        def answer(self, body: bytes, media_type: str) -> None:
            self.send_response(200)
            self.send_header("Content-Type", media_type)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

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


def test_alerts_are_told_as_they_are_raised_and_cleared_newest_first(address: str, tmp_path: Path) -> None:
    flags = BROWSER_FLAGS.replace("budget=6000", "budget=30000").split()
    command = [_browser(), *flags, f"--user-data-dir={tmp_path}", "--dump-dom", f"{address}/"]
    page = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    found = re.search(r'<ol[^>]*id="alert-list"[^>]*>(.*?)</ol>', page, re.DOTALL)
    assert found is not None
    lines = re.findall(r"<li(.*?)</li>", found[1], re.DOTALL)
    assert [re.findall(r'data-alert="(\w+)"', line) for line in lines] == [["raised"], ["cleared"], ["raised"]]
    assert all("ab12cd" in line and "ef34ab" not in line for line in lines)
    assert "on F1: a8:0c:ca:03:9d:d7" in lines[0] and "and 1 more" in lines[0]
    assert "&lt;b&gt;moved" in lines[0] and MARKUP not in lines[0]
    assert re.search(r"after \d+ s", lines[1])
    assert re.search(r'<p[^>]*id="no-alerts"[^>]*hidden', page)
