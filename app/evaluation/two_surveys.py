"""One building surveyed twice by somebody standing at the same points (the open set `um_dsi`): what three weeks do.

Each scan is a session of its own, with nothing to go by but the map. A scan at a point that the map knows is easier
than one between points, so both are asked: of the first survey with the asked points or scans left out, and of the
second.
"""

from __future__ import annotations

import lzma
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from app.errors import InvalidInput
from app.estimation.arrays import FloatArray
from app.evaluation.building_campaign import ByRisk
from app.evaluation.campaign import Advance, Protocol, coverage_of, replayed, surveyed
from app.evaluation.recordings import FloorFolder, RecordedWalk
from app.evaluation.trust_rows import ALERT_LIMIT_M, RISKS
from app.fusion.interface import Floor, Method
from app.observations import AxisSamples, WifiScan
from app.survey.trace import Device, Trace
from app.wifi.fingerprint import Fingerprint

FLOOR = "F1"
POINT_GROUPS = 7
"""Into which points are put, neighbours apart; a group is left out at a time."""
CASES = 4


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """One scan of somebody who stood still. point : number of the place in the order of places along the building."""

    point: int
    xy_m: FloatArray
    scan: WifiScan


def read_standing(folder: Path) -> list[Standing]:
    """The scans of one survey: a folder with coordinates, rssis and timestamps, one line a scan.

    Raises
    ------
    InvalidInput : no such files, or they do not fit together.
    """
    try:
        places = [tuple(map(float, line.split(",")))[:2] for line in _lines(folder, "coordinates")]
        readings = [[cell.split(":") for cell in line.split(",")] for line in _lines(folder, "rssis")]
        times = [
            datetime.strptime(line + "000", "%Y%m%d%H%M%S%f").replace(tzinfo=UTC).timestamp()
            for line in _lines(folder, "timestamps")
        ]
        number = {place: index for index, place in enumerate(sorted(set(places)))}
        found = []
        for place, heard, time_s in zip(places, readings, times, strict=True):
            bssid, first = np.unique([int(name) for name, _ in heard], return_index=True)
            rssi_dbm = np.array([float(level) for _, level in heard])[first]
            scan = WifiScan(time_s, bssid.astype(np.int64), rssi_dbm, np.full(len(bssid), time_s))
            found.append(Standing(number[place], np.array(place), scan))
    except (OSError, ValueError, lzma.LZMAError) as error:
        raise InvalidInput(f"{folder} is not a survey of standing scans: {error}", folder.name) from error
    return found


def two_surveys(
    first: Sequence[Standing], second: Sequence[Standing], method: Method, jobs: int = 1, done: Advance = lambda: None
) -> dict[str, ByRisk]:
    """Answers to single scans of either survey, on maps of the first; done : called after each of the CASES.

    Points of the two surveys are the same. At known points the map of the first survey's own scans holds the half of
    each point's scans that was taken before.
    """
    halves = [list[Standing](), list[Standing]()]
    for point in sorted({one.point for one in first}):
        scans = [one for one in first if one.point == point]
        halves[0] += scans[: len(scans) // 2]
        halves[1] += scans[len(scans) // 2 :]

    def left_out(asked: Sequence[Standing]) -> ByRisk:
        answers: ByRisk = {risk: [] for risk in RISKS}
        for group in range(POINT_GROUPS):
            found = _asked(
                _without(first, group), [one for one in asked if one.point % POINT_GROUPS == group], method, jobs
            )
            for risk, of_group in found.items():
                answers[risk] += of_group
        return answers

    cases: dict[str, Callable[[], ByRisk]] = {
        "known points, first survey": lambda: _asked(halves[0], halves[1], method, jobs),
        "known points, second survey": lambda: _asked(halves[0], second, method, jobs),
        "points left out, first survey": lambda: left_out(first),
        "points left out, second survey": lambda: left_out(second),
    }
    found = {}
    for name, ask in cases.items():
        found[name] = ask()
        done()
    return found


def _without(standing: Sequence[Standing], group: int) -> list[Standing]:
    return [one for one in standing if one.point % POINT_GROUPS != group]


def _asked(known: Sequence[Standing], asked: Sequence[Standing], method: Method, jobs: int) -> ByRisk:
    survey = [_walk(one) for one in known]
    far_m = np.max([one.xy_m for one in known], axis=0).tolist()
    site = surveyed([FloorFolder(Floor(FLOOR, 0, far_m[0], far_m[1]), None, ())], survey)
    coverage, methods = coverage_of(survey), {method.method: method}
    return {
        risk: replayed(
            site,
            coverage,
            [_walk(one) for one in asked],
            methods,
            replace(Protocol(), risk=risk, alert_limit_m=ALERT_LIMIT_M),
            jobs=jobs,
        )[method.method]
        for risk in RISKS
    }


def _walk(one: Standing) -> RecordedWalk:
    """A walk of one scan and one waypoint, where it was taken. Those of a point bear one name: they err alike."""
    x_m, y_m = one.xy_m.tolist()
    name, scan, none = f"point-{one.point:02d}", one.scan, AxisSamples()
    at = np.array([scan.time_s])
    trace = Trace(name, Device(), at, one.xy_m[np.newaxis], none, none, none, none, (scan,))
    fingerprint = Fingerprint(FLOOR, x_m, y_m, scan.time_s, name, scan.bssid, scan.rssi_dbm)
    return RecordedWalk(FLOOR, trace, (fingerprint,), one.xy_m[np.newaxis])


def _lines(folder: Path, name: str) -> list[str]:
    return lzma.decompress((folder / f"{name}.csv.xz").read_bytes()).decode().split()
