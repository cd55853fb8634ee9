from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.commands.compare import app
from app.errors import InvalidInput
from tests.evaluation.small_site import write_small_site

ROWS = "adaptive_robust_kf,wifi_alone"
SHORT = ("--sites", "E-teaching", "--methods", ROWS, "--limit", "1", "--jobs", "1")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_site(tmp_path_factory.mktemp("compared") / "site")


def _compare(*arguments: str | Path) -> Result:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None:
        raise result.exception
    return result


@pytest.fixture(scope="module")
def out(site: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("compared") / "out"
    _compare(site, *SHORT, "--out", folder, "--page", folder / "docs" / "comparison.md")
    return folder


def test_a_page_a_document_and_plots_come_out(out: Path) -> None:
    document = json.loads((out / "results.json").read_text())
    assert set(document["sites"]["E-teaching"]["rows"]) == set(ROWS.split(","))
    assert set(document["open"]["parts"]) == {"pooled", *(f"fold {fold}" for fold in range(5))}
    assert document["sites"]["E-teaching"]["rows"]["wifi_alone"]["n"] > 30
    assert document["seconds"] > 0.0
    plots = {path.name for path in out.glob("*.png")}
    assert {"cdf_E-teaching.png", "cdf_open.png", "plan_E-teaching.png"} <= plots
    assert {"tracks_open_F1_adaptive_robust_kf.png", "tracks_open_F2_adaptive_robust_kf.png"} <= plots


def test_the_page_elsewhere_has_its_pictures_beside_it(out: Path) -> None:
    text = (out / "docs" / "comparison.md").read_text()
    for name in ("open", "E-teaching"):
        assert f"](comparison/cdf_{name}.png)" in text
        assert (out / "docs" / "comparison" / f"cdf_{name}.png").exists()
    assert "](./cdf_open.png)" in (out / "comparison.md").read_text()


def test_the_page_can_be_written_anew_without_walking(site: Path, out: Path) -> None:
    results, text = (out / "results.json").read_text(), (out / "comparison.md").read_text()
    (out / "comparison.md").unlink()
    _compare(site, *SHORT, "--out", out, "--again")
    assert (out / "comparison.md").read_text() == text
    assert (out / "results.json").read_text() == results


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--methods", "magic"), "no methods magic"),
        (("--sites", "moon"), "no sites moon"),
        (("--methods", ","), "no methods named"),
        (("--again",), "results.json is not there"),
    ],
)
def test_what_cannot_be_compared_is_said_before_any_work(
    site: Path, tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    with pytest.raises(InvalidInput, match=message):
        _compare(site, *options, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
