from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.commands.ageing import app
from app.errors import InvalidInput
from tests.evaluation.small_buildings import SMALL

FEW = ("--buildings", "1", "--walks", "1", "--seed", str(SMALL), "--jobs", "1")


def _ageing(*arguments: str | Path) -> Result:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None:
        raise result.exception
    return result


def test_every_age_has_a_row_and_more_has_changed_in_each(tmp_path: Path) -> None:
    shown = json.loads(_ageing(*FEW, "--json", "--out", tmp_path).stdout)
    assert shown == json.loads((tmp_path / "ageing.json").read_text())
    assert [row["months"] for row in shown["months"]] == [0.0, 1.0, 3.0, 6.0, 12.0, 25.0]
    changed = [row["changed"] for row in shown["months"]]
    assert changed == sorted(changed) and changed[0] == 0.0 < changed[-1]
    assert shown["surveys"] == {}
    assert "surefix, months after the survey" in (tmp_path / "ageing.txt").read_text()


def test_what_cannot_be_asked_is_said_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no method magic"):
        _ageing(*FEW, "--method", "magic", "--out", tmp_path / "out")
    with pytest.raises(InvalidInput, match="0 surveys"):
        _ageing(tmp_path, *FEW, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
