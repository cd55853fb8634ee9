"""Where north is, for a phone that does not know: its own track turned until it lies along the WiFi fixes.

A phone without compass and rotation vector knows its turns, not its heading. Its steps, added up in its own frame,
differ from the way it went by one rotation, which two places far enough apart give away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.fusion.state_codec import storable
from app.observations import Step

LEAST_WALKED_M = 12.0
LEAST_SHARE = 0.5
"""Of the own track's length from end to end that the fixes must show: less is their error, not the way."""


@storable
@dataclass(frozen=True, slots=True, eq=False)
class HeadingSearch:
    """walked_m : (2,) sum of the steps in the phone's own frame since the search began.  heading_rad : of the newest
    step there.  from_m : (2,) where it began, None before the first fix."""

    walked_m: FloatArray = field(default_factory=lambda: np.zeros(2))
    heading_rad: float = 0.0
    from_m: FloatArray | None = None


def walked(search: HeadingSearch, step: Step) -> HeadingSearch:
    """The search after a step."""
    heading_rad = step.heading_rad
    move_m = step.length_m * np.array([math.sin(heading_rad), math.cos(heading_rad)])
    return HeadingSearch(search.walked_m + move_m, heading_rad, search.from_m)


def sought(search: HeadingSearch, at_m: FloatArray, sigma_m: float) -> tuple[HeadingSearch, tuple[float, float] | None]:
    """The search after a fix, which begins it if none did before; true heading of the newest step and its standard
    deviation (rad), or None while they cannot be told.

    Parameters
    ----------
    at_m : (2,) estimate of the place now that does not use any heading.  sigma_m : of it, in each direction.
    """
    if search.from_m is None:
        return HeadingSearch(from_m=at_m.copy()), None
    own_m, way = float(np.hypot(*search.walked_m)), at_m - search.from_m
    way_m = float(np.hypot(*way))
    if own_m < LEAST_WALKED_M or way_m < LEAST_SHARE * own_m:
        return search, None
    turned = math.atan2(way[0], way[1]) - math.atan2(search.walked_m[0], search.walked_m[1])
    return search, (wrap(search.heading_rad + turned), min(math.sqrt(2.0) * sigma_m / way_m, 1.0))


def sigma_of(covariance_m2: FloatArray) -> float:
    """Standard deviation in each direction of a place, from a covariance (n, n) whose first components are x and y."""
    return math.sqrt(float(np.trace(covariance_m2[:2, :2])) / 2.0)
