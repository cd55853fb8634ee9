from __future__ import annotations

import socket
import time
from pathlib import Path

import httpx
import pytest
from typer.testing import CliRunner

from app.commands.serve import app
from app.errors import InvalidInput, SurefixError
from app.settings import settings_of
from app.storage.migration import migrate
from tests.commands.surefix_process import serving, surefix

READY_WITHIN_S = 5.0
SLACK = 4.0
"""What other tests on the same machine may slow it down by."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A working directory with a migrated database in its default place."""
    migrate(f"sqlite:///{tmp_path / 'surefix.db'}")
    return tmp_path


def test_a_server_says_where_it_is_once_it_answers_and_stops_when_asked(folder: Path) -> None:
    with serving(["--port", "0"], folder) as server, httpx.Client(base_url=server.address, trust_env=False) as client:
        assert client.get("/readyz").json() == {"status": "ready"}
        assert client.post("/v1/venues", json={"venue": "mall"}).status_code == 201
        assert server.stop() in (0, -15)
    with serving(["--port", "0"], folder) as server:
        assert httpx.get(f"{server.address}/v1/venues/mall", trust_env=False).status_code == 200


def test_a_warm_server_is_ready_within_seconds(folder: Path) -> None:
    with serving(["--port", "0"], folder):
        pass
    began = time.monotonic()
    with serving(["--port", "0"], folder):
        assert time.monotonic() - began < READY_WITHIN_S * SLACK


def test_workers_share_the_port_the_database_and_the_figures(folder: Path) -> None:
    with serving(["--port", "0", "--workers", "2"], folder) as server:
        made = httpx.post(f"{server.address}/v1/venues", json={"venue": "mall"}, trust_env=False)
        assert made.status_code == 201
        for _ in range(12):
            # a connection each, so that either worker may answer
            assert httpx.get(f"{server.address}/v1/venues/mall", trust_env=False).status_code == 200
        counted = 'surefix_requests_total{method="GET",route="/v1/venues/{venue}",status="200"} 12.0'
        assert counted in httpx.get(f"{server.address}/metrics", trust_env=False).text


def test_listeners_of_events_do_not_keep_a_server_from_stopping(folder: Path) -> None:
    with serving(["--port", "0"], folder) as server, httpx.Client(base_url=server.address, trust_env=False) as client:
        client.post("/v1/venues", json={"venue": "mall"})
        opening = {"venue": "mall", "method": "integrity_ukf"}
        session = client.post("/v1/sessions", json=opening).json()["session"]
        with client.stream("GET", f"/v1/sessions/{session}/events") as events:
            assert events.status_code == 200
            began = time.monotonic()
            server.stop()
            assert time.monotonic() - began < 20.0


def test_other_machines_are_not_served_before_there_is_a_key(folder: Path) -> None:
    arguments = ["--host", "0.0.0.0", "--port", "0"]
    refused = surefix("serve", *arguments, folder=folder)
    assert refused.returncode == 2
    assert "surefix key create" in refused.stderr and "Traceback" not in refused.stderr
    assert surefix("key", "create", "--name", "n", "--scope", "admin", folder=folder).returncode == 0
    with serving(arguments, folder) as server:
        address = server.address.replace("0.0.0.0", "127.0.0.1")
        assert httpx.get(f"{address}/v1/venues", trust_env=False).status_code == 401


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--database", "mysql://x"], "sqlite"),
        (["--database", "postgresql://nobody@127.0.0.1:1/none"], "cannot be reached"),
        (["--database", "sqlite:///empty.db"], "surefix migrate"),
        (["--sessions", "disk"], "memory"),
        (["--port", "70000"], "--port: "),
        (["--workers", "0"], "--workers: "),
    ],
)
def test_what_cannot_be_served_is_refused_in_words(
    folder: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], word: str
) -> None:
    monkeypatch.chdir(folder)
    refused = CliRunner().invoke(app, arguments).exception
    assert isinstance(refused, SurefixError) and word in str(refused)


@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_port_that_is_in_use_is_refused_with_the_way_to_choose_another(
    folder: Path, monkeypatch: pytest.MonkeyPatch, workers: str
) -> None:
    monkeypatch.chdir(folder)
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        refused = CliRunner().invoke(app, ["--port", port, "--workers", workers]).exception
    assert isinstance(refused, InvalidInput)
    assert str(refused) == f"port {port} of 127.0.0.1 is in use; choose another with --port or SUREFIX_PORT"


def test_a_session_store_that_is_away_is_told_at_start_without_its_password_and_the_server_serves(
    folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with serving(["--port", "0", "--sessions", "redis://me:secret@127.0.0.1:1/0"], folder) as server:
        assert httpx.get(f"{server.address}/healthz", trust_env=False).status_code == 200
        assert httpx.get(f"{server.address}/readyz", trust_env=False).status_code == 503
    said = capfd.readouterr().err
    assert "warning: the session store redis://127.0.0.1:1/0 cannot be reached" in said
    assert "secret" not in said


def test_the_command_line_outweighs_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SUREFIX_PORT", "1234")
    monkeypatch.setenv("SUREFIX_HOST", "::1")
    settings = settings_of({"port": 5678})
    assert (settings.port, settings.host) == (5678, "::1")
    monkeypatch.setenv("SUREFIX_WORKERS", "many")
    with pytest.raises(InvalidInput, match="SUREFIX_WORKERS: "):
        settings_of({})
