from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.commands.buildings import app
from app.errors import InvalidInput
from tests.evaluation.small_buildings import SMALL

FEW = ("--buildings", "1", "--walks", "2", "--seed", str(SMALL), "--jobs", "1")


def _buildings(*arguments: str | Path) -> Result:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None:
        raise result.exception
    return result


def test_a_table_comes_out_as_text_and_as_a_document(tmp_path: Path) -> None:
    result = _buildings(*FEW, "--out", tmp_path)
    assert "surefix in new buildings" in result.stdout
    assert (tmp_path / "buildings.txt").read_text() == result.stdout
    document = json.loads((tmp_path / "buildings.json").read_text())
    rows = document["methods"]["surefix"]
    assert list(rows) == ["all", "office", f"office-{SMALL}"]
    assert [row["walks"] for row in rows.values()] == [2, 2, 2]
    assert rows["all"]["risks"] == [0.01, 0.05]
    assert document["buildings"][f"office-{SMALL}"]["survey_walks"] >= 12


def test_the_same_seed_gives_the_same_document_on_standard_output(tmp_path: Path) -> None:
    shown = [_buildings(*FEW, "--json", "--out", tmp_path).stdout for _ in range(2)]
    assert shown[0] == shown[1]
    assert json.loads(shown[0])["seed"] == SMALL


@pytest.mark.parametrize("methods", ["magic", ","])
def test_what_cannot_be_walked_is_said_before_any_work(tmp_path: Path, methods: str) -> None:
    with pytest.raises(InvalidInput, match="no methods"):
        _buildings(*FEW, "--methods", methods, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
