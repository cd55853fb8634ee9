from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.commands.faults import app
from app.errors import InvalidInput
from tests.evaluation.small_site import write_small_site

FEW = ("--faults", "half_gone,gyro_biased", "--folds", "2", "--limit", "1", "--jobs", "1")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_site(tmp_path_factory.mktemp("faulted") / "site")


def _faults(*arguments: str | Path) -> Result:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None:
        raise result.exception
    return result


def test_a_table_comes_out_as_text_and_as_a_document(site: Path, tmp_path: Path) -> None:
    result = _faults(site, *FEW, "--out", tmp_path)
    assert "surefix, fold 0, alert limit 10 m" in result.stdout
    assert (tmp_path / "faults.txt").read_text() == result.stdout
    limits = json.loads((tmp_path / "faults.json").read_text())["parts"]["fold 0"]["limits"]
    assert list(limits) == ["10", "20"]
    rows = limits["10"]["surefix"]
    assert list(rows) == ["none", "half_gone", "gyro_biased"]
    assert [row["walks"] for row in rows.values()] == [2, 2, 2]
    assert rows["none"]["waypoints_m"] == rows["none"]["waypoints_clean_m"]


def test_the_same_seed_gives_the_same_document_on_standard_output(site: Path, tmp_path: Path) -> None:
    shown = [_faults(site, *FEW, "--seed", "3", "--json", "--out", tmp_path).stdout for _ in range(2)]
    assert shown[0] == shown[1]
    assert json.loads(shown[0])["seed"] == 3


def test_simulated_buildings_need_no_recordings(tmp_path: Path) -> None:
    options = ("--faults", "half_gone", "--simulated", "1", "--visits", "1", "--jobs", "1", "--alert-limit", "15")
    shown = json.loads(_faults(*options, "--json", "--out", tmp_path).stdout)
    assert shown["site"] is None
    rows = shown["parts"]["1 simulated buildings"]["limits"]["15"]["surefix"]
    assert {fault: row["walks"] for fault, row in rows.items()} == {"none": 1, "half_gone": 1}


def test_without_recordings_and_simulated_buildings_there_is_nothing_to_fault(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="or both"):
        _faults("--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--methods", "magic"), "no methods magic"),
        (("--faults", "earthquake"), "no faults earthquake"),
        (("--fold", "9"), "fold must be one of 0 to 4"),
        (("--floors", "B7"), "B7"),
    ],
)
def test_what_cannot_be_run_is_said_before_any_work(
    site: Path, tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    with pytest.raises(InvalidInput, match=message):
        _faults(site, *options, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
