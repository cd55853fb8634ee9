from __future__ import annotations

import asyncio
import json
import lzma
import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from typer.testing import CliRunner

from app.commands import import_survey
from app.commands.import_destination import DatabaseDestination, ServiceDestination
from app.commands.simulate import app as simulate
from app.errors import InvalidInput, SurefixError
from app.floorplan.georeference import Georeference
from app.storage.database import connect
from app.storage.migration import migrate
from app.storage.radio_map_rows import ActiveMap, RadioMapRows
from app.storage.venue_rows import FloorRow, VenueRows
from app.wifi.radio_map_codec import decode_radio_map
from tests.open_data import open_data
from tests.survey.test_sensor_log import LOG
from tests.survey.test_ujiindoorloc import GOOD, HEADER
from tests.survey.traces import mac, walk

T = 1_700_000_000_000


@pytest.fixture
def database(tmp_path: Path) -> str:
    address = f"sqlite:///{tmp_path / 'import.db'}"
    migrate(address)
    return address


def run_import(folder: Path, *options: str, code: int = 0) -> dict[str, Any]:
    """The report of an import into venue `site`."""
    result = CliRunner().invoke(import_survey.app, [str(folder), "--venue", "site", "--json", *options])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == code, result.output
    return dict(json.loads(result.stdout))


def stored(database: str) -> tuple[dict[str, FloorRow] | None, ActiveMap | None]:
    """Floors by name and the active radio map of venue `site`."""

    async def read() -> Any:
        engine = connect(database)
        found, active = await VenueRows(engine).read("site"), await RadioMapRows(engine).active("site")
        await engine.dispose()
        return (None if found is None else {row.floor: row for row in found[1]}), active

    floors, active = asyncio.run(read())
    return floors, active


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated building of two floors with three walks each."""
    folder = tmp_path_factory.mktemp("site") / "office"
    options = ["--out", str(folder), "--building", "office", "--floors", "2", "--walks", "3", "--rate", "20"]
    assert CliRunner().invoke(simulate, options).exit_code == 0
    return folder


def test_folders_of_floors_become_a_venue_with_plans_walks_and_an_active_map(site: Path, database: str) -> None:
    report = run_import(site, "--database", database)
    assert report["new_floors"] == ["F1", "F2"]
    assert [one["source"] for one in report["surveys"]] == ["F1: 3 traces", "F2: 3 traces"]
    assert (report["rejected_count"], report["version"], report["dry_run"]) == (0, 1, False)
    floors, active = stored(database)
    assert floors is not None and active is not None and active.body is not None
    for name, level in (("F1", 0), ("F2", 1)):
        info = json.loads((site / name / "floor_info.json").read_text())["map_info"]
        row = floors[name]
        assert (row.level, row.width_m, row.height_m) == (level, info["width"], info["height"])
        assert row.has_plan and row.has_image and row.latitude_deg is not None
    assert int(decode_radio_map(active.body).scans.sum()) == report["accepted"] > 20


def test_a_dry_run_reports_the_same_and_stores_nothing(site: Path, database: str) -> None:
    report = run_import(site, "--database", database, "--dry-run")
    assert stored(database) == (None, None)
    real = run_import(site, "--database", database)
    assert report["accepted"] == real["accepted"] and report["version"] is None
    assert [one["floors"] for one in report["surveys"]] == [one["floors"] for one in real["surveys"]]


def test_without_publishing_the_map_stays_as_it_is(site: Path, database: str) -> None:
    assert run_import(site, "--database", database, "--no-publish")["version"] is None
    _, active = stored(database)
    assert active is not None and (active.version, active.body) == (None, None)


def test_a_second_import_adds_to_the_venue_and_leaves_its_floors(site: Path, database: str) -> None:
    first = run_import(site, "--database", database)
    again = run_import(site / "F1" / "path_data_files", "--database", database, "--no-publish")
    assert [one["source"] for one in again["surveys"]] == ["F1: 3 traces"]
    third = run_import(site, "--database", database)
    assert (third["new_floors"], third["version"]) == ([], 2)
    assert third["accepted"] == first["accepted"]


def test_traces_of_a_floor_that_is_not_there_are_refused(database: str, site: Path, tmp_path: Path) -> None:
    run_import(site, "--database", database)
    (tmp_path / "attic").mkdir()
    (tmp_path / "attic" / "one.txt").write_bytes(walk())
    report = run_import(tmp_path / "attic", "--database", database, code=1)
    reason = "the venue has no floor 'attic'; it has F1, F2"
    assert report["rejected"] == [{"item": "attic: 1 traces", "reason": reason}]
    assert report["surveys"] == [] and report["version"] is None


def test_bad_files_and_rows_are_reported_one_by_one_and_the_rest_lands(
    site: Path, database: str, tmp_path: Path
) -> None:
    run_import(site, "--database", database, "--no-publish")
    mixed = tmp_path / "mixed"
    (mixed / "F1").mkdir(parents=True)
    (mixed / "F1" / "good.txt").write_bytes(walk())
    (mixed / "F1" / "cut.txt.xz").write_bytes(lzma.compress(walk(seconds=400))[:-100])
    (mixed / "points.csv").write_text(
        f"floor,x,y,t,bssid,rssi\nF2,1,2,{T},{mac(1)},-50\nF2,1,nan,{T},{mac(1)},-50\nF9,1,2,{T},{mac(1)},-50\n"
    )
    (mixed / "notes.txt").write_text("bring an umbrella")
    report = run_import(mixed, "--database", database)
    assert [(one["source"], one["accepted"]) for one in report["surveys"]] == [("F1: 2 traces", 10), ("points.csv", 1)]
    assert [one["item"] for one in report["rejected"]] == ["cut.txt.xz", "points.csv row 3", "points.csv row 4"]
    assert [Path(name).name for name in report["skipped"]] == ["notes.txt"]
    assert report["version"] == 1


def test_of_a_file_without_a_usable_row_every_row_is_told_with_what_to_do(database: str, tmp_path: Path) -> None:
    rows = f"floor,x,y,t,bssid,rssi\nF1,1,2,{T},{mac(1)},-50\nF1,1,3,{T},{mac(1)},-50\n"
    (tmp_path / "points.csv").write_text(rows)
    report = run_import(tmp_path / "points.csv", "--database", database, code=1)
    reason = "the venue has no floor 'F1'; make it: PUT /v1/venues/{venue}/floors/{floor}, or import a folder of floors"
    assert report["rejected"] == [{"item": f"points.csv row {row}", "reason": reason} for row in (2, 3)]
    assert report["rejected_count"] == 2
    assert stored(database) == (None, None)


def test_what_a_venue_cannot_be_called_is_refused_with_what_it_can(database: str, site: Path) -> None:
    with pytest.raises(InvalidInput, match="venue 'bad name' is no identifier: it has 1 to 64 letters"):
        run_import(site, "--database", database, "--venue", "bad name")


def test_ujiindoorloc_gets_a_floor_for_each_building_and_level_in_metres_on_the_ground(
    database: str, tmp_path: Path
) -> None:
    rows = [GOOD, GOOD.replace("-7541.2643", "-7441.2643"), GOOD.replace(",2,1,", ",0,0,"), "bad\n"]
    (tmp_path / "uji").mkdir()
    (tmp_path / "uji" / "training.csv.xz").write_bytes(lzma.compress((HEADER + "".join(rows)).encode()))
    report = run_import(tmp_path / "uji", "--database", database)
    assert sorted(report["new_floors"]) == ["B0F0", "B1F2"]
    assert (report["accepted"], report["version"]) == (3, 1)
    assert [one["item"] for one in report["rejected"]] == ["training.csv.xz row 5"]
    floors, active = stored(database)
    assert floors is not None and active is not None and active.body is not None
    assert floors["B1F2"].level == 2
    assert floors["B1F2"].latitude_deg == pytest.approx(39.992, abs=1e-2)
    radio_map = decode_radio_map(active.body)
    xy_m = radio_map.xy_m[radio_map.floor == radio_map.floors.index("B1F2")]
    assert math.dist(*xy_m) == pytest.approx(76.6, abs=0.1)


def test_a_log_of_the_sensor_app_becomes_walks_on_each_floor_it_visits(database: str, tmp_path: Path) -> None:
    (tmp_path / "log.txt").write_text("\n".join(LOG))
    report = run_import(tmp_path / "log.txt", "--database", database)
    assert [(one["source"], one["floors"]) for one in report["surveys"]] == [
        ("B1F0: 1 traces", {"B1F0": 1}),
        ("B1F1: 1 traces", {"B1F1": 1}),
    ]
    floors, _ = stored(database)
    assert floors is not None
    assert floors["B1F1"].level == 1
    assert floors["B1F1"].height_m == pytest.approx(37.0, abs=0.1)


def test_logs_of_one_name_in_two_folders_are_two_walks(database: str, tmp_path: Path) -> None:
    for folder in ("may", "june"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "log.txt").write_text("\n".join(LOG))
    report = run_import(tmp_path, "--database", database)
    assert [one["source"] for one in report["surveys"]] == ["B1F0: 2 traces", "B1F1: 2 traces"]


def test_the_recorded_ujiindoorloc_validation_set_is_imported(database: str) -> None:
    report = run_import(open_data("ujiindoorloc", "validationData.csv.xz"), "--database", database)
    assert (report["accepted"], report["rejected_count"], len(report["new_floors"])) == (1111, 0, 13)
    floors, _ = stored(database)
    assert floors is not None
    assert 290 < floors["B0F0"].width_m < 330 and 200 < floors["B0F0"].height_m < 240


@pytest.mark.parametrize("content", [None, {"readme.md": b"nothing"}])
def test_a_folder_without_any_survey_is_refused(
    database: str, tmp_path: Path, content: dict[str, bytes] | None
) -> None:
    folder = tmp_path / "folder"
    if content is not None:
        folder.mkdir()
        for name, text in content.items():
            (folder / name).write_bytes(text)
    with pytest.raises(InvalidInput):
        run_import(folder, "--database", database)
    assert stored(database) == (None, None)


def test_the_report_is_readable_without_json(site: Path, database: str) -> None:
    result = CliRunner().invoke(import_survey.app, [str(site), "--venue", "site", "--database", database])
    assert result.exit_code == 0
    assert "F1: 3 traces" in result.output and "Radio map version 1 of venue site is active." in result.output


class Recorded:
    """A service that answers as it is told and keeps what it was asked."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, str]] = []
        self.venue: dict[str, Any] | None = None
        self.refuse = ""

    def answer(self, request: httpx.Request) -> httpx.Response:
        request.read()
        self.asked.append((request.method, str(request.url.raw_path, "ascii")))
        if request.method == self.refuse:
            return httpx.Response(403, json={"detail": "the key lacks the scope"})
        if request.url.path == "/v1/venues" and request.method == "GET":
            return httpx.Response(200, json={"venues": []})
        if request.method == "GET":
            return httpx.Response(200, json=self.venue) if self.venue else httpx.Response(404, json={"detail": "none"})
        if request.url.path.endswith("/surveys"):
            version = 1 if request.url.params["publish"] == "true" else None
            return httpx.Response(201, json={"survey": len(self.asked), "accepted": 5, "version": version})
        return httpx.Response(
            204 if request.url.path.endswith("/image") else 201, json=None if "image" in str(request.url) else {}
        )


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch) -> Recorded:
    service = Recorded()

    @contextmanager
    def destination(url: str, key: str | None, database: str) -> Iterator[ServiceDestination]:
        assert (url, key, database) == ("http://there", "secret", "")
        yield ServiceDestination(httpx.Client(base_url=url, transport=httpx.MockTransport(service.answer)))

    monkeypatch.setattr(import_survey, "_destination", destination)
    return service


def test_with_an_address_everything_goes_over_the_api_and_the_last_upload_publishes(
    site: Path, recorded: Recorded
) -> None:
    report = run_import(site, "--url", "http://there", "--key", "secret")
    assert report["version"] == 1
    floor = "/v1/venues/site/floors"
    assert recorded.asked == [
        ("GET", "/v1/venues/site"),
        ("GET", "/v1/venues"),
        ("POST", "/v1/venues"),
        ("PUT", f"{floor}/F1"),
        ("PUT", f"{floor}/F1/image"),
        ("PUT", f"{floor}/F2"),
        ("PUT", f"{floor}/F2/image"),
        ("POST", "/v1/venues/site/surveys?publish=false&floor=F1"),
        ("POST", "/v1/venues/site/surveys?publish=true&floor=F2"),
    ]


def test_a_refusal_of_the_service_is_told_with_its_reason(site: Path, recorded: Recorded) -> None:
    recorded.refuse = "POST"
    with pytest.raises(SurefixError, match="POST /v1/venues: 403 the key lacks the scope"):
        run_import(site, "--url", "http://there", "--key", "secret")


def test_a_service_that_does_not_answer_is_named_with_its_address_and_without_the_password(site: Path) -> None:
    with pytest.raises(SurefixError) as refused:
        run_import(site, "--url", "http://me:secret@127.0.0.1:1")
    assert str(refused.value).startswith("GET http://127.0.0.1:1/v1/venues/site: ")
    assert "refused" in str(refused.value) and "secret" not in str(refused.value)


@pytest.mark.parametrize("other", [httpx.Response(404, text="<p>nothing here</p>"), httpx.Response(200, text="hello")])
def test_what_is_not_surefix_is_not_taken_for_a_service_without_the_venue(other: httpx.Response) -> None:
    client = httpx.Client(base_url="http://there/wrong", transport=httpx.MockTransport(lambda _: other))
    with pytest.raises(InvalidInput, match="what answers at http://there/wrong is not Surefix"):
        ServiceDestination(client).floors("site")


def test_a_destination_knows_the_frames_of_the_floors_that_are_there(database: str, site: Path) -> None:
    recorded = Recorded()
    run_import(site, "--database", database)
    there = DatabaseDestination(database)
    existing = there.floors("site")
    there.close()
    assert existing is not None
    recorded.venue = {
        "floors": [
            {
                "floor": floor,
                "width": extent.width_m,
                "height": extent.height_m,
                "georeference": frame
                and {"latitude": frame.latitude_deg, "longitude": frame.longitude_deg, "rotation": frame.rotation_rad},
            }
            for floor, (extent, frame) in existing.items()
        ]
    }
    client = httpx.Client(base_url="http://there", transport=httpx.MockTransport(recorded.answer))
    assert ServiceDestination(client).floors("site") == existing
    assert isinstance(existing["F1"][1], Georeference)
