from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.commands.transfer import app
from app.errors import InvalidInput
from tests.evaluation.small_site import write_small_site

FEW = ("--folds", "2", "--limit", "1", "--jobs", "1")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_site(tmp_path_factory.mktemp("transferred") / "site")


def _transfer(*arguments: str | Path) -> Result:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None:
        raise result.exception
    return result


def test_every_floors_settings_are_judged_on_every_floor(site: Path, tmp_path: Path) -> None:
    shown = json.loads(_transfer(site, *FEW, "--json", "--out", tmp_path).stdout)
    assert shown == json.loads((tmp_path / "transfer.json").read_text())
    pairs = [(row["learnt_on"], row["judged_on"]) for row in shown["rows"]]
    assert pairs == [(learnt, floor) for floor in ("F1", "F2") for learnt in ("shipped", "F1", "F2")]
    factors = {row["learnt_on"]: row["settings"]["tails"] for row in shown["rows"]}
    assert [risk for risk, _ in factors["F1"]] == [0.01, 0.05]
    assert "leave one floor out" in (tmp_path / "transfer.txt").read_text()


def test_a_site_of_one_floor_is_refused(site: Path, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="two floors"):
        _transfer(site, *FEW, "--floors", "F1", "--out", tmp_path)
