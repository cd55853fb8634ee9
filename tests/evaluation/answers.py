"""Answers made by hand for the tests of figures."""

from __future__ import annotations

from typing import Any

from app.evaluation.replay import Answer
from app.observations import Flag


def answer(error_m: float | None = 1.0, **changes: Any) -> Answer:
    """A usable answer at a covered waypoint, this far east of the truth; changes : other fields."""
    fields: dict[str, Any] = {
        "fold": 0,
        "floor": "F1",
        "walk": "one",
        "time_s": 0.0,
        "truth_xy_m": (10.0, 20.0),
        "waypoint": True,
        "covered": True,
        "scanned": True,
        "xy_m": None if error_m is None else (10.0 + error_m, 20.0),
        "error_m": error_m,
        "floor_right": error_m is not None,
        "accuracy_m": None if error_m is None else 2.0,
        "covariance_m2": None if error_m is None else ((4.0, 0.0), (0.0, 4.0)),
        "flag": Flag.INITIALISING if error_m is None else Flag.NOMINAL,
        "usable": error_m is not None,
        "protection_level_m": None if error_m is None else 6.0,
        "alert_limit_m": 10.0,
        "spent_s": 0.001,
    }
    return Answer(**fields | changes)
