from __future__ import annotations

import importlib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.cli import COMMANDS
from app.errors import InvalidInput
from tests.evaluation.small_site import write_small_site


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_site(tmp_path_factory.mktemp("walked") / "site")


@pytest.mark.parametrize("below", ["", "results"])
@pytest.mark.parametrize(
    ("command", "walked"),
    [
        ("evaluate", True),
        ("faults", True),
        ("compare", True),
        ("transfer", True),
        ("buildings", False),
        ("ageing", False),
        ("simulate", False),
    ],
)
def test_where_no_folder_can_be_made_the_option_is_named_before_any_work(
    site: Path, tmp_path: Path, command: str, walked: bool, below: str
) -> None:
    (tmp_path / "letter").write_text("keep me")
    arguments = [str(site)] if walked else []
    app = importlib.import_module(COMMANDS[command]).app
    refused = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path / "letter" / below)]).exception
    assert isinstance(refused, InvalidInput) and refused.field == "out"
    assert "name another" in str(refused) and str(tmp_path / "letter") in str(refused)
    assert (tmp_path / "letter").read_text() == "keep me"
