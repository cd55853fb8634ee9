from __future__ import annotations

import lzma

import pytest

from tests.open_data import open_data
from tests.survey.surveys import reasons, walks_survey
from tests.survey.test_unpacking import zipped
from tests.survey.traces import START_MS, trace, walk, waypoint, wifi


def test_walks_of_many_files_land_under_their_names() -> None:
    found, notes = walks_survey({"one.txt": walk(), "two.txt.xz": lzma.compress(walk()), "three": walk(seconds=10)})
    assert {one.walk for one in found} == {"one", "two", "three"}
    assert notes.rejections.count == 0
    assert notes.device == {"brand": "OPPO", "model": "PBCM10"}


def test_of_walks_with_one_name_the_first_counts() -> None:
    found, notes = walks_survey({"one.txt": walk(), "other/one.txt": walk(seconds=10)})
    assert len(found) == len(walks_survey({"one.txt": walk()})[0])
    assert "second walk called 'one'" in reasons(notes)["other/one.txt"]


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "not a trace"),
        (b"\x00\x01\x02" * 99, "not a trace"),
        (lzma.compress(walk())[:-40], "damaged or cut short"),
        (b"\x1f\x8b\x08garbage", "damaged or cut short"),
        (zipped({"inner.zip": zipped({"a": b""})}), "zip inside a zip"),
        (trace(waypoint(START_MS, 1, 2)), "fewer than two waypoints"),
    ],
)
def test_a_file_that_gives_nothing_is_rejected_by_name_and_the_others_land(content: bytes, reason: str) -> None:
    found, notes = walks_survey({"good.txt": walk(), "bad": content, "better.txt": walk(seconds=10)})
    assert {one.walk for one in found} == {"good", "better"}
    assert list(reasons(notes)) == ["bad"]
    assert reason in reasons(notes)["bad"]


@pytest.mark.parametrize("name", [".txt", "x" * 201 + ".txt", "a\nb.txt"])
def test_a_walk_needs_a_name_that_can_be_stored(name: str) -> None:
    found, notes = walks_survey({name: walk()})
    assert found == []
    assert "names the walk" in reasons(notes)[name]


def test_scans_outside_the_floor_are_rejected_by_walk_and_time() -> None:
    lines = [wifi(START_MS + 1000 * at, 1, -50) for at in (1, 9)]
    found, notes = walks_survey(
        {"out.txt": trace(waypoint(START_MS, 50, 50), *lines, waypoint(START_MS + 10_000, 50, 150))}
    )
    assert len(found) == 1
    assert list(reasons(notes)) == [f"out at {START_MS + 9000}"]
    assert "outside floor F1" in reasons(notes)[f"out at {START_MS + 9000}"]


def test_a_floor_without_a_size_takes_any_place() -> None:
    assert len(walks_survey({"a": walk(x_m=5000.0)}, floor="B1")[0]) == len(walks_survey({"a": walk()})[0]) > 0


def test_recorded_walks_land_without_a_rejection() -> None:
    folder = open_data("mall", "F1", "path_data_files")
    files = {path.name: path.read_bytes() for path in sorted(folder.iterdir())[:6]}
    found, notes = walks_survey(files, floor="B1")
    assert notes.rejections.count == 0
    assert {one.walk for one in found} == {name.split(".")[0] for name in files}
    assert sum(len(one.bssid) for one in found) > 50 * len(found)
