"""A folder of recorded walks, one subfolder a floor, and which of them survey and which are walked."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.errors import InvalidInput
from app.estimation.arrays import FloatArray
from app.evaluation.truth import scan_places
from app.floorplan.georeference import Georeference
from app.floorplan.plan import accept_plan
from app.fusion.interface import Floor
from app.observations import Position
from app.survey.placement import fingerprints_of
from app.survey.trace import Trace, read_trace
from app.wifi.fingerprint import Fingerprint


@dataclass(frozen=True, slots=True)
class FloorFolder:
    """One floor on disk.

    image, plan : the raster plan, and GeoJSON repaired as by the service; None where there is none.
    traces : in the order of their names.
    """

    floor: Floor
    image: Path | None
    traces: tuple[Path, ...]
    plan: Mapping[str, Any] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class RecordedWalk:
    """One walk, read once and used in both roles.

    fingerprints : what it adds to a radio map when it is survey.  scan_xy_m : (n, 2) where its scans were taken, linear
    in time: what says whether a place is covered.  start : where its session says that it begins, None if it does not.
    """

    floor: str
    trace: Trace
    fingerprints: tuple[Fingerprint, ...]
    scan_xy_m: FloatArray
    start: Position | None = None


def floor_folders(site: Path, floors: Sequence[str] | None = None) -> list[FloorFolder]:
    """The floors of a site folder in the order of their names, or those named.

    Raises
    ------
    InvalidInput : no floor there, or a named one is missing or damaged.
    """
    there = {folder.name: folder for folder in sorted(site.glob("*/")) if (folder / "floor_info.json").exists()}
    if not there:
        raise InvalidInput(f"{site} holds no floor: a folder with floor_info.json and path_data_files is expected")
    unknown = [floor for floor in floors or () if floor not in there]
    if unknown:
        raise InvalidInput(f"no floors {', '.join(unknown)} in {site}; there are {', '.join(there)}", "floors")
    return [_floor_folder(there[floor]) for floor in floors or there]


def is_test_walk(trace: str, folds: int, fold: int) -> bool:
    """Whether a trace is walked in this fold; in the others it is survey."""
    return int(hashlib.md5(trace.encode(), usedforsecurity=False).hexdigest(), 16) % folds == fold


def read_walk(floor: str, path: Path) -> RecordedWalk | None:
    """Read and place one trace; None for one of less than two waypoints, which has no truth.

    Raises
    ------
    InvalidInput : the file is no trace.
    """
    with path.open("rb") as stream:
        trace = read_trace(stream, path.name)
    if len(trace.waypoint_time_s) < 2:
        return None
    fingerprints, _ = fingerprints_of(trace, floor)
    return RecordedWalk(floor, trace, tuple(fingerprints), scan_places(trace))


def _floor_folder(folder: Path) -> FloorFolder:
    try:
        size = json.loads((folder / "floor_info.json").read_text())["map_info"]
        traces = sorted(path for path in (folder / "path_data_files").iterdir() if ".txt" in path.name)
        width_m, height_m = float(size["width"]), float(size["height"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InvalidInput(f"{folder} is not a floor: {error}", folder.name) from error
    image, drawn = folder / "floor_image.png", folder / "geojson_map.json"
    plan, georeference = _plan(drawn) if drawn.exists() else (None, None)
    floor = Floor(folder.name, _level(folder.name), width_m, height_m, georeference)
    return FloorFolder(floor, image if image.exists() else None, tuple(traces), plan)


def _level(name: str) -> int:
    """Storeys above ground of a floor called F1, F2, B1, ..."""
    number = int(re.sub(r"\D", "", name) or 1)
    return -number if name.startswith("B") else number - 1


def _plan(path: Path) -> tuple[Mapping[str, Any], Georeference]:
    """The plan, and its place: the frame's origin is the south-west corner of the first feature."""
    try:
        plan = accept_plan(json.loads(path.read_text())).plan
        longitudes, latitudes = zip(*_points(plan["features"][0]["geometry"]["coordinates"]), strict=True)
    except (ValueError, KeyError, IndexError, TypeError) as error:
        raise InvalidInput(f"{path} is not a floor plan: {error!r}", path.name) from error
    return plan, Georeference(min(latitudes), min(longitudes), 0.0)


def _points(node: Any) -> Iterator[tuple[float, float]]:
    if isinstance(node[0], int | float):
        yield node[0], node[1]
    else:
        for child in node:
            yield from _points(child)
