from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.commands.evaluate import app
from app.errors import InvalidInput
from tests.evaluation.small_site import write_small_site


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_site(tmp_path_factory.mktemp("evaluated") / "site")


def _evaluate(*arguments: str | Path) -> Result:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None:
        raise result.exception
    return result


def test_tables_a_document_and_plots_come_out(site: Path, tmp_path: Path) -> None:
    result = _evaluate(site, "--methods", "surefix", "--folds", "2", "--limit", "2", "--jobs", "1", "--out", tmp_path)
    assert "Horizontal error" in result.stdout
    assert "alert limit 10 m, risk 0.01" in result.stdout
    figures = json.loads((tmp_path / "results.json").read_text())["methods"]["surefix"]
    assert figures["all"]["walks"] == figures["integrity"]["walks"] == 4
    assert [at["alert_limit_m"] for at in figures["integrity"]["limits"]] == [10.0, 15.0, 20.0]
    assert "promised inside the level 0.99" in result.stdout
    assert set(figures["floors"]) == {"F1", "F2"}
    plots = ["error_cdf.png", "error_over_time_surefix.png", "stanford_surefix.png"]
    plots += ["tracks_surefix_F1.png", "tracks_surefix_F2.png"]
    assert sorted(path.name for path in tmp_path.glob("*.png")) == plots


def test_smoothed_tracks_are_rows_beside_what_was_known_at_the_time(site: Path, tmp_path: Path) -> None:
    options = ("--methods", "surefix", "--folds", "2", "--limit", "1", "--jobs", "1", "--smoothed", "--json")
    shown = json.loads(_evaluate(site, *options, "--out", tmp_path).stdout)["methods"]
    assert list(shown) == ["surefix", "surefix smoothed", "surefix 4 s late"]
    assert shown["surefix smoothed"]["all"]["answers"] == shown["surefix"]["all"]["answers"]


def test_json_on_standard_output_is_the_document_and_nothing_else(site: Path, tmp_path: Path) -> None:
    options = ("--methods", "surefix", "--fold", "0", "--fold", "1", "--folds", "2", "--limit", "1", "--jobs", "1")
    result = _evaluate(site, *options, "--floors", "F2", "--alert-limit", "15", "--json", "--out", tmp_path)
    shown = json.loads(result.stdout)
    assert shown == json.loads((tmp_path / "results.json").read_text())
    assert shown["protocol"]["tested"] == [0, 1]
    assert shown["protocol"]["alert_limit_m"] == 15.0
    assert list(shown["methods"]["surefix"]["folds"]) == ["0", "1"]
    assert list(shown["methods"]["surefix"]["floors"]) == ["F2"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--methods", "surefix,magic"), "no methods magic"),
        (("--methods", ","), "no methods named"),
        (("--fold", "9"), "fold must be one of 0 to 4"),
        (("--fold", "-1"), "fold must be a number"),
        (("--floors", "B7"), "no floors B7 .*there are F1, F2"),
    ],
)
def test_what_cannot_be_evaluated_is_said_before_any_work(
    site: Path, tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    with pytest.raises(InvalidInput, match=message):
        _evaluate(site, *options, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
