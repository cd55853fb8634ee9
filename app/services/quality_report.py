"""The quality report of a radio-map version, made of its survey in a process of its own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import orjson

from app.estimation.arrays import BoolArray, FloatArray, IntArray
from app.floorplan.georeference import Georeference
from app.floorplan.walkable import Polygon, plan_polygons, walkable_cells
from app.fusion.single_fix import single_fix_levels_m
from app.integrity.map_quality import ErrorCells, coverage_gaps, distinct_pairs, error_cells, look_alikes
from app.services.quality_description import (
    MOST_NAMED,
    described_access_points,
    described_cells,
    described_error,
    described_gap,
    described_level,
    described_place,
    described_risk,
    strongest_places,
)
from app.survey.spool import fingerprint_of, read_rows
from app.wifi.beacons import parted
from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import calibration_of
from app.wifi.left_out import left_out_scans
from app.wifi.radio_map import RadioMap
from app.wifi.radio_map_codec import decode_radio_map
from app.wifi.similarity import point_distances
from app.wifi.survey_likeness import likeness_of, likeness_sections, stored_likeness

RISK = 0.01
"""Of the levels that are shown: what sessions ask for unless they say otherwise."""
CELL_M = 4.0
"""Of the error map: a few scans each in an ordinary survey."""
RASTER_M, MOST_CELLS = 1.0, 4_000_000
"""Side of the cells that are looked for gaps; on a floor that has more than so many they are larger."""
REACH_M = 5.0
"""A survey scan covers what is within."""
NEIGHBOUR_M, FAR_M = 3.0, 15.0
"""Of look-alikes."""
MOST_POINTS = 3000
"""Reference points that are compared for look-alikes, evenly taken."""


@dataclass(frozen=True, slots=True)
class ReportFloor:
    """A floor as the report needs it. plan : GeoJSON; image : PNG, spanning the frame."""

    floor: str
    width_m: float
    height_m: float
    georeference: Georeference | None
    plan: bytes | None
    image: bytes | None


@dataclass(frozen=True, slots=True, eq=False)
class FloorFindings:
    """What was found on one floor.

    features : the plan's polygons, none where it cannot be placed.  survey_xy_m : (n, 2).  cells : of the errors.
    missing : cells of raster_m that count and are not covered.  alike : (k, 2) pairs of the points of
    Findings.point_xy_m with an end on this floor.  described : the floor's part of the report.
    """

    place: ReportFloor
    features: list[list[Polygon]]
    survey_xy_m: FloatArray
    cells: ErrorCells
    missing: BoolArray
    raster_m: float
    alike: IntArray
    described: dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """Everything found. point_xy_m, point_floor : (p, ...) of the reference points that pairs are of."""

    floors: tuple[FloorFindings, ...]
    floor_names: tuple[str, ...]
    point_xy_m: FloatArray
    point_floor: IntArray
    described: dict[str, Any]


def made_report(spool: Path, radio_map: bytes, floors: Sequence[ReportFloor], title: str) -> tuple[bytes, bytes]:
    """The report as JSON and its picture as PNG, of the fingerprints in a spool and the map that was built of them."""
    from app.services.quality_picture import picture_of  # only the process that draws loads what it takes

    with spool.open("rb") as stream:
        fingerprints = [fingerprint_of(row) for row in read_rows(stream)]
    findings = examined(fingerprints, decode_radio_map(radio_map), floors)
    picture, canvases = picture_of(findings, title)
    described = {**findings.described, "canvases": canvases}
    return orjson.dumps(described, option=orjson.OPT_SERIALIZE_NUMPY), picture


def examined(fingerprints: Sequence[Fingerprint], radio_map: RadioMap, floors: Sequence[ReportFloor]) -> Findings:
    """Everything that a survey and its radio map say about themselves. What was heard of beacons is left out."""
    fingerprints, _ = parted(fingerprints)  # the report is about WiFi
    left_out = left_out_scans(fingerprints, floors=radio_map.floors)
    level_m = single_fix_levels_m(radio_map, left_out.match, RISK)
    learnt_from = calibration_of(radio_map).walks
    likeness = stored_likeness(radio_map.sections) or likeness_of(fingerprints, left_out, radio_map.floors)
    walk_names, walk = np.unique([one.walk for one in fingerprints], return_inverse=True)
    at_floor = np.array([one.floor for one in fingerprints])
    xy_m = np.array([(one.x_m, one.y_m) for one in fingerprints], np.float64).reshape(-1, 2)
    points, pairs, limit = _pairs(radio_map)
    point_xy_m, point_floor = radio_map.xy_m[points], radio_map.floor[points].astype(np.int64)
    distance = {tuple(pair): value for pair, value in zip(pairs[0].tolist(), pairs[1].tolist(), strict=True)}

    found = []
    for place in floors:
        if place.floor not in radio_map.floors:
            continue
        number = radio_map.floors.index(place.floor)
        here = at_floor == place.floor
        of_floor = here[left_out.scan]
        right = of_floor & left_out.floor_right
        placed, errors = left_out.scan[right], (left_out.error_m[right], level_m[right])
        cells = error_cells(xy_m[placed], *errors, walk[placed], CELL_M)
        features = _features(place)
        raster_m = max(RASTER_M, math.sqrt(place.width_m * place.height_m / MOST_CELLS))
        walkable = walkable_cells(features, xy_m[here], (place.width_m, place.height_m), raster_m)
        share, missing, gaps = coverage_gaps(walkable, raster_m, xy_m[here], REACH_M)
        alike = pairs[0][(point_floor[pairs[0]] == number).any(axis=1)]
        listed = distinct_pairs(alike, point_xy_m, point_floor, FAR_M / 2.0, MOST_NAMED)
        described = {
            "floor": place.floor,
            "width": place.width_m,
            "height": place.height_m,
            "scans": int(here.sum()),
            "risk": described_risk(errors[0], walk[placed]),
            "error": described_error(errors[0], int(here[left_out.tried].sum()), int(of_floor.sum())),
            "level": described_level(*errors, RISK, learnt_from),
            "cell": CELL_M,
            "cells": described_cells(cells),
            "coverage": {
                "reach": REACH_M,
                "basis": "plan" if features else "frame",
                "area": float(walkable.sum()) * raster_m**2,
                "covered": share,
                "gaps": [described_gap(gap) for gap in gaps[:MOST_NAMED]],
            },
            "look_alikes": {
                "signal_limit": limit,
                "pairs": len(alike),
                "listed": [
                    {
                        "places": [
                            described_place(radio_map.floors, point_floor[end], point_xy_m[end]) for end in pair
                        ],
                        "apart": float(np.hypot(*(point_xy_m[pair[0]] - point_xy_m[pair[1]]))),
                        "signal_distance": distance[tuple(pair)],
                    }
                    for pair in listed.tolist()
                ],
            },
        }
        found.append(FloorFindings(place, features, xy_m[here], cells, missing, raster_m, listed, described))

    right = left_out.floor_right
    placed, errors = left_out.scan[right], (left_out.error_m[right], level_m[right])
    described = {
        "version": radio_map.version,
        "floor_names": list(radio_map.floors),
        "fingerprints": len(fingerprints),
        "walks": len(walk_names),
        "risk": described_risk(errors[0], walk[placed]),
        "error": described_error(errors[0], len(left_out.tried), len(left_out.scan)),
        "level": described_level(*errors, RISK, learnt_from),
        "access_points": described_access_points(fingerprints, walk, xy_m, at_floor, radio_map),
        "floors": [one.described for one in found],
        "strongest": strongest_places(radio_map),
        "likeness": {name: rows.tolist() for name, rows in likeness_sections(likeness).items()},
    }
    return Findings(tuple(found), radio_map.floors, point_xy_m, point_floor, described)


def _features(place: ReportFloor) -> list[list[Polygon]]:
    if place.plan is None or place.georeference is None:
        return []
    return plan_polygons(orjson.loads(place.plan), place.georeference)


def _pairs(radio_map: RadioMap) -> tuple[IntArray, tuple[IntArray, FloatArray], float]:
    """The points that are compared, the look-alikes among them with their signal distance, and its limit."""
    count = len(radio_map.scans)
    points = np.arange(0, count, max(1, -(-count // MOST_POINTS)))
    distances = point_distances(radio_map, points)
    floor = radio_map.floor[points].astype(np.int64)
    limit, pairs = look_alikes(radio_map.xy_m[points], floor, distances, NEIGHBOUR_M, FAR_M)
    return points, (pairs, distances[pairs[:, 0], pairs[:, 1]]), limit
