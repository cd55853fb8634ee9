from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from app.commands import train_carrying
from app.commands.train_carrying import app
from app.errors import InvalidInput
from app.pdr.carrying_position import CLASSES, FEATURES, MODEL_VERSION
from tests.commands.surefix_process import surefix


def _train(out: Path, *options: str) -> str:
    result = CliRunner().invoke(app, ["--out", str(out), "--users", "3", *options])
    if result.exception is not None:
        raise result.exception
    return result.output


def test_the_same_seed_grows_the_same_file_and_says_what_it_recognises_of_strangers(tmp_path: Path) -> None:
    printed = _train(tmp_path / "one.npz")
    _train(tmp_path / "same.npz")
    _train(tmp_path / "other.npz", "--seed", "2")
    one, same, other = ((tmp_path / f"{name}.npz").read_bytes() for name in ("one", "same", "other"))
    assert one == same
    assert one != other
    share = re.search(r"leave one user out: (0\.\d+) of (\d+) windows, 3 users", printed)
    assert share is not None
    assert 0.5 < float(share[1]) < 1.0
    assert int(share[2]) > 500
    for position in CLASSES:
        assert position.value in printed


def test_the_file_says_what_it_is_for_and_holds_no_pickle(tmp_path: Path) -> None:
    _train(tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz", allow_pickle=False) as arrays:
        assert int(arrays["version"]) == MODEL_VERSION
        assert tuple(arrays["features"].tolist()) == FEATURES
        assert arrays["classes"].tolist() == [one.value for one in CLASSES]
        assert arrays["share"].sum(axis=1) == pytest.approx(1.0)


def test_without_scikit_learn_it_says_what_is_missing_before_anybody_walks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    monkeypatch.setattr(train_carrying, "simulated_windows", lambda *_: pytest.fail("somebody has walked"))
    with pytest.raises(InvalidInput, match="scikit-learn"):
        _train(tmp_path / "model.npz")
    assert not (tmp_path / "model.npz").exists()


def test_the_command_is_registered(tmp_path: Path) -> None:
    ran = surefix("train-carrying", "--help", folder=tmp_path)
    assert ran.returncode == 0
    assert "carrying-position forest" in ran.stdout
