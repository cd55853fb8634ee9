from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.api.batch_body import parse_batch
from app.api.decoding import Packing
from app.commands.load import app
from app.errors import InvalidInput
from app.simulation.load_walks import made_up_walk, recorded_walks, with_sequence
from tests.faults.phone_server import PhoneServer
from tests.open_data import open_data


def test_made_up_batches_are_what_a_phone_sends_each_second_and_the_same_for_the_same_seed() -> None:
    walk = made_up_walk(7, 5)
    batches = [parse_batch(with_sequence(n, rest), Packing.JSON) for n, rest in enumerate(walk)]
    assert [batch.accelerometer.time_s.size for batch in batches] == [100] * 5
    assert [len(batch.wifi) for batch in batches] == [1, 0, 1, 0, 1]
    assert batches[0].wifi[0].bssid.size == 40
    assert made_up_walk(7, 5) == walk
    assert made_up_walk(8, 5) != walk


def test_recorded_walks_become_batches_in_order() -> None:
    walk, other = recorded_walks(open_data("mall", "F1"), 2)
    batches = [parse_batch(with_sequence(n, rest), Packing.JSON) for n, rest in enumerate(walk)]
    ends = [batch.end_s for batch in batches if batch.end_s is not None]
    assert ends == sorted(ends)
    assert any(batch.wifi for batch in batches)
    assert other != walk


def test_a_load_test_prints_throughput_latencies_and_errors(tmp_path: Path) -> None:
    with PhoneServer(f"sqlite:///{tmp_path / 'phones.db'}") as server:
        arguments = ["--url", str(server.client.base_url), "--key", "key", "--method", "odometer", "--phones", "3"]
        arguments += ["--seconds", "1", "--rate", "0", "--json"]
        done = CliRunner().invoke(app, [*arguments, "--venue", "mall"])
        assert done.exit_code == 0, done.output
        outcome = json.loads(done.stdout)
        assert outcome["errors"] == {} and outcome["phones"] == 3
        assert outcome["batches"] > 10 and outcome["batches_per_second"] > 10
        latency = outcome["latency_ms"]
        assert 0 < latency["p50"] <= latency["p90"] <= latency["p99"] <= latency["max"]
        refused = CliRunner().invoke(app, [*arguments, "--venue", "other"])
        assert refused.exit_code == 1
        assert json.loads(refused.stdout)["errors"] == {"POST /v1/sessions: 404 there is no venue 'other'": 3}


def test_a_service_that_does_not_answer_is_named_with_its_address() -> None:
    arguments = ["--venue", "mall", "--url", "http://me:secret@127.0.0.1:1", "--phones", "2", "--seconds", "1"]
    done = CliRunner().invoke(app, [*arguments, "--rate", "0", "--json"])
    assert done.exit_code == 1
    (failure,) = json.loads(done.stdout)["errors"]
    assert failure.startswith("POST http://127.0.0.1:1/v1/sessions: ConnectError")


@pytest.mark.parametrize("url", ["127.0.0.1:8000", "localhost:8000", "http://", "http://host:port", "ftp://host"])
def test_what_is_no_address_of_a_service_is_refused(url: str) -> None:
    refused = CliRunner().invoke(app, ["--venue", "mall", "--url", url]).exception
    assert isinstance(refused, InvalidInput) and refused.field == "url" and "http://host:port" in str(refused)


@pytest.mark.parametrize("folder", ["missing", "empty"])
def test_a_folder_without_traces_is_an_error(tmp_path: Path, folder: str) -> None:
    (tmp_path / "empty").mkdir()
    done = CliRunner().invoke(app, ["--venue", "mall", "--trace-dir", str(tmp_path / folder)])
    assert done.exit_code != 0 and folder in str(done.exception)
