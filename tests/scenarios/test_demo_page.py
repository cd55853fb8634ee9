"""The demo on a real server, seen through a real browser."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

BROWSER_FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --virtual-time-budget=6000"
)
PHONES = 3


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, subprocess.Popen[bytes], Path]]:
    """The demo's address once its phones are positioned, its process, and what it printed."""
    log = tmp_path_factory.mktemp("demo") / "demo.log"
    command = [sys.executable, "-c", "from app.cli import main; main()", "demo", "--port", "0"]
    with log.open("wb") as stream:
        process = subprocess.Popen([*command, "--phones", str(PHONES), "--speed", "4"], stdout=stream, stderr=stream)
    try:
        yield _when_positioned(process, log), process, log
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.wait(30)


def _when_positioned(process: subprocess.Popen[bytes], log: Path) -> str:
    deadline = time.monotonic() + 300.0
    while time.monotonic() < deadline and process.poll() is None:
        found = re.search(r"http://127\.0\.0\.1:\d+", log.read_text())
        if found and _positioned(found[0]) == PHONES:
            return found[0]
        time.sleep(0.5)  # polls another process; nothing is assumed to be done after it
    pytest.fail(f"the demo's phones were not positioned in time: {log.read_text()[-3000:]}")


def _positioned(address: str) -> int:
    with httpx.Client(base_url=address, trust_env=False) as client:
        venues = client.get("/v1/venues").json()["venues"]
        if not venues:
            return 0
        phones = client.get(f"/v1/venues/{venues[0]['venue']}/phones").json()["phones"]
        return sum(phone["fix"]["position"] is not None for phone in phones)


def _browser() -> str:
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if shutil.which(name):
            return name
    reason = "no Chromium on this machine: apt-get install chromium"
    if os.environ.get("CI") == "true":
        pytest.fail(reason)
    pytest.skip(reason)


def test_the_page_lists_and_draws_the_phones_that_walk(
    demo: tuple[str, subprocess.Popen[bytes], Path], tmp_path: Path
) -> None:
    address, _, _ = demo
    command = [_browser(), *BROWSER_FLAGS.split(), f"--user-data-dir={tmp_path}", "--dump-dom", f"{address}/"]
    page = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    rows = re.search(r'<tbody id="rows">(.*?)</tbody>', page, re.DOTALL)
    assert rows is not None
    assert rows[1].count("<tr") == PHONES
    assert re.search(r"nominal|corrected|outlier|coasting", rows[1])
    assert re.search(r"\d\.\d m", rows[1])
    assert page.count('class="room"') > 10
    assert page.count('class="accuracy"') >= PHONES
    assert re.search(r'id="link"[^>]*data-state="live"', page)


def test_the_readmes_first_batch_is_placed(demo: tuple[str, subprocess.Popen[bytes], Path]) -> None:
    readme = (Path(__file__).parents[2] / "README.md").read_text()
    opened, batch = (json.loads(body) for body in re.findall(r"-d '(\{.*?\})'", readme, re.DOTALL))
    address, _, _ = demo
    with httpx.Client(base_url=address, trust_env=False) as client:
        session = client.post("/v1/sessions", json=opened).json()["session"]
        fix = client.post(f"/v1/sessions/{session}/batches", json=batch).json()
    told = re.search(r'"x": ([\d.]+), "y": ([\d.]+), "floor": "F1"', readme)
    assert told is not None and fix["position"]["floor"] == "F1"
    assert abs(fix["position"]["x"] - float(told[1])) < 2.0 and abs(fix["position"]["y"] - float(told[2])) < 2.0


def test_the_listing_never_shows_a_session_id(demo: tuple[str, subprocess.Popen[bytes], Path]) -> None:
    address, _, _ = demo
    venue = httpx.get(f"{address}/v1/venues", trust_env=False).json()["venues"][0]["venue"]
    phones = httpx.get(f"{address}/v1/venues/{venue}/phones", trust_env=False).json()["phones"]
    for phone in phones:
        assert "session" not in phone["fix"]
        assert httpx.get(f"{address}/v1/sessions/{phone['phone']}/fix", trust_env=False).status_code == 404


def test_the_page_needs_nothing_from_elsewhere_and_may_load_nothing(
    demo: tuple[str, subprocess.Popen[bytes], Path],
) -> None:
    address, _, _ = demo
    page = httpx.get(f"{address}/", trust_env=False)
    assert "default-src 'none'" in page.headers["content-security-policy"]
    for name in re.findall(r'(?:src|href)="(console/[^"]+)"', page.text):
        asset = httpx.get(f"{address}/{name}", trust_env=False)
        assert asset.status_code == 200
        assert not re.search(r"https?://(?!www\.w3\.org/)", asset.text)
    assert not re.search(r"<script(?![^>]*src=)|style=|\son\w+=", page.text)


def test_an_interrupt_stops_the_demo_and_its_server(demo: tuple[str, subprocess.Popen[bytes], Path]) -> None:
    address, process, log = demo
    process.send_signal(signal.SIGINT)
    assert process.wait(30) == 0
    assert "Traceback" not in log.read_text()
    with pytest.raises(httpx.ConnectError):
        httpx.get(address, trust_env=False)
