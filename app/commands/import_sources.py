"""What a folder holds that can be imported, told from the content of its files, as floors to make and uploads."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from app.errors import InvalidInput
from app.evaluation.recordings import floor_folders
from app.floorplan.georeference import Georeference
from app.survey.rejection import Rejections
from app.survey.sensor_log import Stretch, is_sensor_log, stretches_of, write_traces
from app.survey.ujiindoorloc import UjiScan, frame_about, is_ujiindoorloc, read_ujiindoorloc, uji_address
from app.survey.unpacking import Allowance, damage_named, unpacked
from app.survey.upload import SurveyFormat, Upload

HEAD_BYTES = 4096
MARGIN_M = 10.0
"""About the places of a survey without a plan: the frame of a floor made for it."""
MOST_FILES = 500
"""Traces in one upload; each is an open file while it is sent."""


@dataclass(frozen=True, slots=True)
class ImportFloor:
    """A floor to make where the venue has none of that name. plan : GeoJSON file.  image : PNG file."""

    floor: str
    level: int
    width_m: float
    height_m: float
    georeference: Georeference | None
    plan: Path | None = None
    image: Path | None = None


@dataclass(frozen=True, slots=True)
class ImportPart:
    """One survey to upload."""

    label: str
    upload: Upload


@dataclass(slots=True)
class ImportPlan:
    """Everything found. skipped : files that are nothing known here."""

    floors: dict[str, ImportFloor] = field(default_factory=dict)
    parts: list[ImportPart] = field(default_factory=list)
    rejections: Rejections = field(default_factory=Rejections)
    skipped: list[str] = field(default_factory=list)


def find_sources(root: Path, scratch: Path, frames: Mapping[str, Georeference | None]) -> ImportPlan:
    """Look through a folder (or at one file) and prepare what it holds.

    Parameters
    ----------
    scratch : empty folder for files that are converted.  frames : georeference of each floor that the venue has.

    Raises
    ------
    InvalidInput : there is nothing there, or nothing known.
    """
    if not root.exists():
        raise InvalidInput(f"there is no {root}", "dir")
    plan = ImportPlan()
    folders = [] if root.is_file() else sorted(path.parent for path in root.glob("*/floor_info.json"))
    if folders:
        _add_floor_folders(plan, root)
    paths = [root] if root.is_file() else sorted(path for path in root.rglob("*") if path.is_file())
    found: dict[str, list[Path]] = {"uji": [], "csv": [], "log": [], "trace": []}
    for path in paths:
        if not any(folder in path.parents for folder in folders):
            kind = _kind(path)
            found[kind].append(path) if kind else plan.skipped.append(str(path))
    _add_traces(plan, found["trace"])
    plan.parts += [ImportPart(path.name, Upload(SurveyFormat.CSV, ((path.name, path),))) for path in found["csv"]]
    if found["uji"]:
        _add_ujiindoorloc(plan, found["uji"], scratch, frames)
    if found["log"]:
        _add_logs(plan, found["log"], scratch, frames)
    if not plan.parts:
        raise InvalidInput(f"{root} holds no trace, survey CSV, UJIIndoorLoc CSV or GetSensorData log", "dir")
    return plan


def _kind(path: Path) -> str | None:
    try:
        with opened(path) as stream:
            head = stream.read(HEAD_BYTES)
    except InvalidInput:  # damaged: no survey; it is listed as skipped
        return None
    first = head.split(b"\n", 1)[0]
    if is_ujiindoorloc(head):
        return "uji"
    if b"\tTYPE_" in head:
        return "trace"
    if is_sensor_log(head):
        return "log"
    names = {name.strip().lower() for name in next(csv.reader([first.decode("utf-8-sig", "replace")]), [])}
    return "csv" if {"floor", "x", "y", "bssid"} <= names else None


@contextmanager
def opened(path: Path) -> Iterator[IO[bytes]]:
    """The content of a file, plain or compressed; of a zip its first member. Raises InvalidInput for a damaged one."""
    with path.open("rb") as stream, damage_named(path.name):
        first = next(unpacked(stream, path.name, Allowance()), None)
        yield io.BytesIO() if first is None else first[1]


def _add_floor_folders(plan: ImportPlan, root: Path) -> None:
    for folder in floor_folders(root):
        floor, drawing = folder.floor, root / folder.floor.floor / "geojson_map.json"
        plan.floors[floor.floor] = ImportFloor(
            floor.floor,
            floor.level,
            floor.width_m,
            floor.height_m,
            floor.georeference,
            drawing if drawing.exists() else None,
            folder.image,
        )
        _add_walks(plan, floor.floor, folder.traces)


def _add_traces(plan: ImportPlan, paths: Iterable[Path]) -> None:
    by_floor: dict[str, list[Path]] = {}
    for path in paths:
        folder = path.parent.parent if path.parent.name == "path_data_files" else path.parent
        by_floor.setdefault(folder.name, []).append(path)
    for floor, walks in by_floor.items():
        _add_walks(plan, floor, walks)


def _add_walks(plan: ImportPlan, floor: str, paths: Iterable[Path]) -> None:
    walks = list(paths)
    for at in range(0, len(walks), MOST_FILES):
        files = tuple((path.name, path) for path in walks[at : at + MOST_FILES])
        label = f"{floor}: {len(files)} traces"
        plan.parts.append(ImportPart(label, Upload(SurveyFormat.TRACES, files, floor)))


def _add_ujiindoorloc(
    plan: ImportPlan, paths: list[Path], scratch: Path, frames: Mapping[str, Georeference | None]
) -> None:
    scans = {path: _uji_scans(path, plan.rejections) for path in paths}
    everyone = [scan for found in scans.values() for scan in found]
    if not everyone:
        return
    origin, width_m, height_m = frame_about([scan.place_deg for scan in everyone], MARGIN_M)
    for scan in everyone:
        if scan.floor not in frames:
            plan.floors.setdefault(scan.floor, ImportFloor(scan.floor, scan.level, width_m, height_m, origin))
    for path, found in scans.items():
        converted = scratch / f"{len(plan.parts)}.csv"
        with converted.open("w", newline="") as stream:
            out = csv.writer(stream)
            out.writerow(("floor", "x", "y", "t", "bssid", "rssi"))
            for scan in found:
                frame = frames.get(scan.floor) or origin
                x_m, y_m = frame.to_local(*scan.place_deg)
                place = (scan.floor, f"{x_m:.3f}", f"{y_m:.3f}", scan.time_ms)
                out.writerows((*place, uji_address(number), f"{rssi:g}") for number, rssi in scan.readings)
        plan.parts.append(ImportPart(path.name, Upload(SurveyFormat.CSV, ((path.name, converted),))))


def _uji_scans(path: Path, rejections: Rejections) -> list[UjiScan]:
    rows = Rejections()
    try:
        with opened(path) as stream:
            text = io.TextIOWrapper(stream, encoding="utf-8-sig", errors="replace", newline="")
            scans = list(read_ujiindoorloc(text, rows))
    except InvalidInput as error:
        rejections.add(path.name, str(error))
        return []
    heard = [scan for scan in scans if scan.readings]
    for one in rows.listed:
        rejections.add(f"{path.name} row {one.item}", one.reason)
    for scan in scans:
        if not scan.readings:
            rejections.add(f"{path.name} row {scan.row}", "no access point was heard")
    return heard


def _add_logs(plan: ImportPlan, paths: list[Path], scratch: Path, frames: Mapping[str, Georeference | None]) -> None:
    logs: dict[Path, list[Stretch]] = {}
    for path in paths:
        with opened(path) as stream:
            logs[path] = stretches_of(stream, path.name, plan.rejections)
    waypoints = [one for stretches in logs.values() for stretch in stretches for one in stretch.waypoints]
    if not waypoints:
        return
    origin, width_m, height_m = frame_about([(one.latitude_deg, one.longitude_deg) for one in waypoints], MARGIN_M)
    for one in waypoints:
        if one.floor not in frames:
            plan.floors.setdefault(one.floor, ImportFloor(one.floor, one.level, width_m, height_m, origin))
    placed = {one.floor: frames.get(one.floor) or origin for one in waypoints}
    walks: dict[str, list[Path]] = {}
    for number, (path, stretches) in enumerate(logs.items(), start=1):
        # numbered, since logs of two folders may have one name
        name = f"{path.name.split('.')[0]}-{number}"
        converted = [scratch / f"{name}-{index + 1}.txt" for index in range(len(stretches))]
        with opened(path) as stream, ExitStack() as stack:
            out: list[IO[bytes]] = [stack.enter_context(one.open("xb")) for one in converted]
            write_traces(stream, stretches, placed, out)
        for stretch, file in zip(stretches, converted, strict=True):
            walks.setdefault(stretch.floor, []).append(file)
    for floor, files in walks.items():
        _add_walks(plan, floor, files)
