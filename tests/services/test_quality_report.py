from __future__ import annotations

import dataclasses
import io
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pytest
from PIL import Image

from app.floorplan.georeference import Georeference
from app.fusion.single_fix import single_fix_levels_m
from app.services.quality_picture import picture_of
from app.services.quality_report import MOST_CELLS, RISK, Findings, ReportFloor, examined, made_report
from app.survey.spool import row_of, write_row
from app.wifi.beacons import beacon_key
from app.wifi.bssid import format_bssid
from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import calibrated_map
from app.wifi.left_out import left_out_scans
from app.wifi.radio_map import build_radio_map
from app.wifi.radio_map_codec import encode_radio_map
from tests.wifi.surveys import corridor

FLOORS = [ReportFloor(name, 60.0, 20.0, None, None, None) for name in ("B1", "F1", "F2")]
UNSTEADY, MOVED_DB = 3, 25.0
WALKS = 6


def survey(floors: tuple[str, ...] = ("B1", "F1")) -> list[Fingerprint]:
    """Walks along a corridor of 40 m on each floor; one access point changes its power from walk to walk."""
    made = []
    for one in corridor(repeats=WALKS, floors=floors):
        rssi_dbm = one.rssi_dbm + np.where((one.bssid == UNSTEADY) & (one.time_s % 2 == 0), -MOVED_DB, 0.0)
        made.append(dataclasses.replace(one, walk=f"{one.floor} {one.time_s:.0f}", rssi_dbm=rssi_dbm))
    return made


@pytest.fixture(scope="module")
def findings() -> Findings:
    return examined(survey(), build_radio_map(survey(), 7), FLOORS)


def floor(findings: Findings, name: str) -> dict[str, Any]:
    return next(one for one in findings.described["floors"] if one["floor"] == name)


def test_the_report_counts_what_it_is_made_of(findings: Findings) -> None:
    told = findings.described
    assert (told["version"], told["fingerprints"], told["walks"]) == (7, 2 * WALKS * 21, 2 * WALKS)
    assert [one["floor"] for one in told["floors"]] == ["B1", "F1"]  # on F2 nothing was surveyed
    assert floor(findings, "F1")["scans"] == WALKS * 21
    assert orjson.loads(orjson.dumps(told, option=orjson.OPT_SERIALIZE_NUMPY)) == told


def test_errors_are_those_of_walks_left_out_and_the_cells_hold_all_of_them(findings: Findings) -> None:
    told = findings.described["error"]
    assert told["scans"] == 2 * WALKS * 21
    assert 0.0 < told["median"] <= told["mean"] < told["quantile_95"] < 15.0
    placed = sum(cell["scans"] for one in findings.described["floors"] for cell in one["cells"])
    assert placed == told["scans"] - told["unplaced"] - told["wrong_floor"]
    for cell in floor(findings, "F1")["cells"]:
        assert 0.0 <= cell["error"] <= cell["worst"] and 1 <= cell["walks"] <= WALKS
        assert cell["y"] == 2.0 and -2.0 < cell["x"] < 44.0


def test_levels_are_those_of_the_default_method_and_say_how_many_errors_they_hold(findings: Findings) -> None:
    told = findings.described["level"]
    assert (told["risk"], told["learnt_from"]) == (RISK, 0)  # the map was not calibrated
    radio_map = build_radio_map(survey(), 7)
    left_out = left_out_scans(survey())
    right = left_out.floor_right
    level_m = single_fix_levels_m(radio_map, left_out.match, RISK)[right]
    assert told["median"] == pytest.approx(np.median(level_m))
    assert told["inside"] == pytest.approx(np.mean(left_out.error_m[right] <= level_m))
    cells = [cell for one in findings.described["floors"] for cell in one["cells"]]
    assert np.average([cell["level"] for cell in cells], weights=[cell["scans"] for cell in cells]) == pytest.approx(
        level_m.mean()
    )


def test_what_use_is_compared_with_is_that_of_the_map_and_found_for_one_that_is_older(findings: Findings) -> None:
    calibrated = examined(survey(), calibrated_map(survey(), 7), FLOORS)
    assert calibrated.described["likeness"] == findings.described["likeness"]
    assert calibrated.described["level"]["learnt_from"] == 2 * WALKS
    assert sum(row[3] for row in findings.described["likeness"]["likeness_cells"]) == len(survey())


def test_scans_of_beacons_are_no_part_of_it(findings: Findings) -> None:
    one = survey()[0]
    beacon = dataclasses.replace(one, bssid=np.array([beacon_key("a beacon")]), rssi_dbm=np.array([-60.0]))
    found = examined([*survey(), beacon], build_radio_map(survey(), 7), FLOORS)
    assert found.described == findings.described


def test_what_the_corridor_does_not_reach_is_a_gap(findings: Findings) -> None:
    coverage = floor(findings, "F1")["coverage"]
    assert (coverage["basis"], coverage["area"]) == ("frame", 1200.0)
    assert 0.15 < coverage["covered"] < 0.3
    (gap,) = coverage["gaps"]
    assert (gap["x"], gap["y"]) == (59.5, 19.5)
    assert gap["distance"] == pytest.approx(np.hypot(19.5, 18.5), abs=0.8)


def test_a_huge_floor_is_looked_over_in_a_bounded_number_of_cells() -> None:
    huge = ReportFloor("F1", 10_000.0, 8_000.0, None, None, None)
    (found,) = examined(survey(("F1",)), build_radio_map(survey(("F1",)), 1), [huge]).floors
    assert found.missing.size <= 1.01 * MOST_CELLS
    assert found.described["coverage"]["area"] == pytest.approx(80e6, rel=0.01)


def test_the_calibration_sample_supports_what_so_many_walks_do(findings: Findings) -> None:
    risk = findings.described["risk"]
    assert risk["walks"] == 2 * WALKS and risk["smallest"] == pytest.approx(1.0 / (2 * WALKS + 1))
    assert risk["levels"] == {"0.05": None, "0.01": None, "0.001": None}


def test_the_access_point_that_changes_is_the_unsteady_one(findings: Findings) -> None:
    told = findings.described["access_points"]
    assert told["listed"][0]["bssid"] == format_bssid(UNSTEADY)
    assert told["listed"][0]["spread"] > MOVED_DB / 3 > told["limit"]
    assert told["unsteady"] == 1


def test_places_that_sound_alike_are_named_and_drawn() -> None:
    ordinary = survey(("F1",))
    copied = [dataclasses.replace(one, y_m=18.0, walk=f"copy {one.walk}") for one in ordinary]
    found = examined(ordinary + copied, build_radio_map(ordinary + copied, 1), FLOORS)
    told = floor(found, "F1")["look_alikes"]
    assert told["pairs"] >= 21
    for pair in told["listed"]:
        one, other = pair["places"]
        assert abs(one["y"] - other["y"]) == pytest.approx(17.0) and abs(one["x"] - other["x"]) < 8.0
        assert pair["signal_distance"] <= told["signal_limit"]


def test_rooms_nobody_went_into_are_no_gap() -> None:
    place = Georeference(30.0, 120.0, 0.0)

    def square(west: float, south: float, east: float, north: float) -> dict[str, Any]:
        corners = [(west, south), (east, south), (east, north), (west, north), (west, south)]
        positions = [place.to_wgs84(*corner) for corner in corners]
        ring = [[longitude, latitude] for latitude, longitude in positions]
        return {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}

    plan = orjson.dumps({"type": "FeatureCollection", "features": [square(0, 0, 42, 20), square(0, 5, 42, 20)]})
    found = examined(
        survey(("F1",)), build_radio_map(survey(("F1",)), 1), [ReportFloor("F1", 60.0, 20.0, place, plan, None)]
    )
    assert floor(found, "F1")["coverage"] == {"reach": 5.0, "basis": "plan", "area": 210.0, "covered": 1.0, "gaps": []}


def test_one_lone_walk_makes_a_report_without_errors() -> None:
    lone = [one for one in survey(("F1",)) if one.walk == "F1 0"]
    found = examined(lone, build_radio_map(lone, 1), FLOORS)
    told = found.described
    assert (told["error"]["unplaced"], told["error"]["mean"]) == (21, None)
    assert (told["risk"]["walks"], told["risk"]["smallest"]) == (0, 1.0)
    assert (told["access_points"]["median_spread"], told["access_points"]["listed"]) == (None, [])


def test_the_picture_has_its_title_above_all_panels_whatever_is_in_it(findings: Findings) -> None:
    titles = "mall, radio map version 7 of 2026-11-26", "a $title$ of another map"
    one, other = (np.asarray(Image.open(io.BytesIO(picture_of(findings, title)[0])).convert("L")) for title in titles)
    assert one.shape == other.shape
    rows, columns = np.nonzero(one != other)
    assert 0 < rows.max() < 60 and columns.max() < one.shape[1] / 2


@pytest.mark.parametrize("shape", ["bare", "image"])
def test_the_worker_gives_json_and_a_picture_with_a_row_for_each_floor(tmp_path: Path, shape: str) -> None:
    image = io.BytesIO()
    Image.new("RGB", (60, 20), "white").save(image, "PNG")
    floors = [dataclasses.replace(one, image=image.getvalue() if shape == "image" else None) for one in FLOORS]
    with (tmp_path / "spool").open("wb") as stream:
        for one in survey():
            write_row(stream, row_of(one))
    report, picture = made_report(tmp_path / "spool", encode_radio_map(build_radio_map(survey(), 7)), floors, "mall")
    told = orjson.loads(report)
    assert told["version"] == 7
    drawn = Image.open(io.BytesIO(picture))
    for canvas in told["canvases"].values():
        left, top, right, bottom = canvas["pixels"]
        west, south, east, north = canvas["frame"]
        assert drawn.width / 2 < left < right < drawn.width and 0.0 < top < bottom < drawn.height
        assert (right - left) / (east - west) == pytest.approx((bottom - top) / (north - south))
    assert drawn.format == "PNG" and drawn.width > 1500
    assert len(drawn.convert("RGB").getcolors(1 << 24) or []) > 500
