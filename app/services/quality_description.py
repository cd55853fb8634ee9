"""What a quality report says of what was found, as plain numbers and names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.integrity.map_quality import (
    UNSTEADY,
    ErrorCells,
    Gap,
    between_walk_spread,
    conformal_level,
    smallest_risk,
)
from app.wifi.bssid import format_bssid
from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import RadioMap

MOST_NAMED = 20
"""Gaps, look-alikes and access points that a report names."""
RISKS = (0.05, 0.01, 0.001)
SPREAD_CELL_M = 3.0
"""What counts as the same place when walks are compared."""


def described_cells(cells: ErrorCells) -> list[dict[str, Any]]:
    """Every cell of the error map."""
    columns = *cells.xy_m.T, cells.mean_m, cells.worst_m, cells.level_m, cells.scans, cells.walks
    names = "x", "y", "error", "worst", "level", "scans", "walks"
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [dict(zip(names, row, strict=True)) for row in rows]


def described_gap(gap: Gap) -> dict[str, Any]:
    """A gap in the coverage; the distance is null where nothing at all was surveyed."""
    return {
        "x": gap.xy_m[0],
        "y": gap.xy_m[1],
        "area": gap.area_m2,
        "distance": gap.distance_m if np.isfinite(gap.distance_m) else None,
        "bounds": list(gap.bounds_m),
    }


def described_place(floors: Sequence[str], floor: int, xy_m: FloatArray) -> dict[str, Any]:
    """A reference point."""
    return {"floor": floors[floor], "x": float(xy_m[0]), "y": float(xy_m[1])}


def described_risk(error_m: FloatArray, walk: IntArray) -> dict[str, Any]:
    """How many walks there are to calibrate with, the smallest risk that they support, and by risk what a further
    walk's worst scan would stay within.

    Parameters
    ----------
    error_m, walk : (n,) of scans.
    """
    _, of_walk = np.unique(walk, return_inverse=True)
    worst_m = np.zeros(int(of_walk.max(initial=-1)) + 1)
    np.maximum.at(worst_m, of_walk, error_m)
    levels = {str(risk): conformal_level(worst_m, risk) for risk in RISKS}
    return {"walks": len(worst_m), "smallest": smallest_risk(len(worst_m)), "levels": levels}


def described_level(error_m: FloatArray, level_m: FloatArray, risk: float, learnt_from: int) -> dict[str, Any]:
    """Protection levels of single scans, and how many of their errors they hold.

    Parameters
    ----------
    error_m, level_m : (n,).  learnt_from : walks that this version's variances were learnt from, 0: the defaults.
    """
    some = len(error_m) > 0
    return {
        "risk": risk,
        "learnt_from": learnt_from,
        "median": float(np.median(level_m)) if some else None,
        "inside": float(np.mean(error_m <= level_m)) if some else None,
    }


def described_error(error_m: FloatArray, tried: int, placed: int) -> dict[str, Any]:
    """Errors of scans placed on the right floor, and how many of those tried were not."""
    some = len(error_m) > 0
    return {
        "scans": tried,
        "unplaced": tried - placed,
        "wrong_floor": placed - len(error_m),
        "mean": float(error_m.mean()) if some else None,
        "median": float(np.median(error_m)) if some else None,
        "quantile_95": float(np.quantile(error_m, 0.95)) if some else None,
    }


def described_access_points(
    fingerprints: Sequence[Fingerprint], walk: IntArray, xy_m: FloatArray, at_floor: Any, radio_map: RadioMap
) -> dict[str, Any]:
    """Which access points differ most from walk to walk at the same place.

    Parameters
    ----------
    walk, xy_m, at_floor : (n,), (n, 2), (n,) of each fingerprint.
    """
    heard = [len(one.bssid) for one in fingerprints]
    every = np.concatenate([one.bssid for one in fingerprints]) if fingerprints else np.empty(0, np.int64)
    rssi_dbm = np.concatenate([one.rssi_dbm for one in fingerprints]) if fingerprints else np.empty(0)
    square = np.column_stack([np.unique(at_floor, return_inverse=True)[1], np.floor(xy_m / SPREAD_CELL_M)])
    _, cell = np.unique(square, axis=0, return_inverse=True)
    bssid, access_point = np.unique(every, return_inverse=True)
    visits = np.repeat(cell.reshape(-1), heard), np.repeat(walk, heard)
    spread_db, repeats = between_walk_spread(access_point, *visits, rssi_dbm.astype(np.float64))
    judged = np.isfinite(spread_db)
    median_db = float(np.median(spread_db[judged])) if judged.any() else None
    limit_db = np.inf if median_db is None else UNSTEADY * median_db
    unsteady = np.flatnonzero(judged & (spread_db > limit_db))
    unsteady = unsteady[np.argsort(-spread_db[unsteady], kind="stable")]
    return {
        "known": len(radio_map.bssid),
        "judged": int(judged.sum()),
        "median_spread": median_db,
        "limit": None if median_db is None else limit_db,
        "unsteady": len(unsteady),
        "listed": [
            {"bssid": format_bssid(int(bssid[at])), "spread": float(spread_db[at]), "repeats": int(repeats[at])}
            for at in unsteady[:MOST_NAMED].tolist()
        ],
    }


def strongest_places(radio_map: RadioMap) -> dict[str, list[Any]]:
    """Where each access point was heard strongest: floor, x and y."""
    places = {}
    for at, bssid in enumerate(radio_map.bssid.tolist()):
        pairs = slice(radio_map.start[at], radio_map.start[at + 1])
        point = int(radio_map.point[pairs][radio_map.mean_dbm[pairs].argmax()])
        x_m, y_m = radio_map.xy_m[point].round(1).tolist()
        places[format_bssid(bssid)] = [radio_map.floors[radio_map.floor[point]], x_m, y_m]
    return places
