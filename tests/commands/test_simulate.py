from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.commands.simulate import app
from app.errors import InvalidInput
from app.survey.trace import read_trace


def _simulate(folder: Path, *options: str) -> None:
    result = CliRunner().invoke(app, ["--out", str(folder), "--building", "office", "--walks", "2", *options])
    if result.exception is not None:
        raise result.exception


def _content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_a_site_has_the_folders_of_the_open_data(tmp_path: Path) -> None:
    _simulate(tmp_path / "site", "--floors", "2")
    for floor in ("F1", "F2"):
        folder = tmp_path / "site" / floor
        size = json.loads((folder / "floor_info.json").read_text())["map_info"]
        assert json.loads((folder / "geojson_map.json").read_text())["features"][0]["geometry"]["type"] == "Polygon"
        assert (folder / "floor_image.png").stat().st_size > 1000
        traces = [read_trace(path.read_bytes(), path.name) for path in (folder / "path_data_files").iterdir()]
        assert len(traces) == 2
        for trace in traces:
            assert (trace.waypoint_xy_m >= 0).all()
            assert (trace.waypoint_xy_m <= [size["width"], size["height"]]).all()


def test_the_same_seed_writes_the_same_files_and_another_seed_others(tmp_path: Path) -> None:
    for name, seed in (("one", "4"), ("same", "4"), ("other", "5")):
        _simulate(tmp_path / name, "--seed", seed, "--floors", "1")
    one, same, other = (_content(tmp_path / name) for name in ("one", "same", "other"))
    assert one == same
    assert one != other


def test_files_that_are_there_are_not_mixed_with_new_ones(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("keep me")
    with pytest.raises(InvalidInput, match="not an empty folder"):
        _simulate(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]
