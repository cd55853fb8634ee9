from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from app.errors import InvalidInput
from app.evaluation.recordings import floor_folders, is_test_walk, read_walk
from app.floorplan.georeference import METRES_PER_DEGREE
from tests.evaluation.small_site import HEIGHT_M, WALKS, WIDTH_M
from tests.open_data import open_data


def test_floors_come_in_the_order_of_their_names_with_sizes_levels_and_traces(small_site: Path) -> None:
    floors = floor_folders(small_site)
    assert [folder.floor.floor for folder in floors] == ["F1", "F2"]
    assert [folder.floor.level for folder in floors] == [0, 1]
    assert {(folder.floor.width_m, folder.floor.height_m) for folder in floors} == {(WIDTH_M, HEIGHT_M)}
    assert [len(folder.traces) for folder in floors] == [WALKS, WALKS]
    assert floors[0].image is None


def test_only_the_floors_asked_for_are_read(small_site: Path) -> None:
    assert [folder.floor.floor for folder in floor_folders(small_site, ["F2"])] == ["F2"]


def test_a_folder_without_floors_and_a_floor_that_is_not_there_are_named(small_site: Path, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="holds no floor"):
        floor_folders(tmp_path)
    with pytest.raises(InvalidInput, match=r"no floors B7 .*there are F1, F2"):
        floor_folders(small_site, ["F1", "B7"])


def test_a_damaged_floor_description_is_named(tmp_path: Path) -> None:
    (tmp_path / "F1").mkdir()
    (tmp_path / "F1" / "floor_info.json").write_text('{"map_info": []}')
    with pytest.raises(InvalidInput, match="F1 is not a floor"):
        floor_folders(tmp_path)


def test_every_walk_is_tested_in_exactly_one_fold_which_its_name_decides() -> None:
    names = [f"5dd9e7aac5b77e0006b17{n:03x}" for n in range(300)]
    for name in names:
        assert sum(is_test_walk(name, 5, fold) for fold in range(5)) == 1
        assert is_test_walk(name, 5, int(hashlib.md5(name.encode()).hexdigest(), 16) % 5)
    assert all(30 < sum(is_test_walk(name, 5, fold) for name in names) < 90 for fold in range(5))


def test_a_trace_without_truth_is_no_walk(tmp_path: Path) -> None:
    path = tmp_path / "lost.txt"
    path.write_text("1574000000000\tTYPE_WAYPOINT\t1\t2\n1574000000100\tTYPE_ACCELEROMETER\t0\t0\t9.8\t3\n")
    assert read_walk("F1", path) is None


def test_the_open_floors_have_the_frame_that_their_description_states() -> None:
    for folder in floor_folders(open_data("mall")):
        origin = folder.floor.georeference
        assert origin is not None
        latitude, longitude = origin.to_wgs84(folder.floor.width_m, folder.floor.height_m)
        assert (latitude - origin.latitude_deg) * METRES_PER_DEGREE == pytest.approx(folder.floor.height_m)
        assert longitude > origin.longitude_deg
        assert folder.image is not None
        walk = read_walk(folder.floor.floor, folder.traces[0])
        assert walk is not None
        assert (walk.trace.waypoint_xy_m > 0).all()
        assert (walk.trace.waypoint_xy_m < [folder.floor.width_m, folder.floor.height_m]).all()
