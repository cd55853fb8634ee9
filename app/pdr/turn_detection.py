"""Turn detection of the two-stage paper: a step during which the gyroscope turned far about the vertical.

Two-stage WiFi/MEMS integration, Micromachines 2019, 10, 198, section 4.2 (docs/methods/two_stage_ekf.md).
Differs from the paper, which holds the phone level and adds up its z axis: the turn about the vertical comes from the
attitude, so that a phone may be held at a slant. The paper shows its threshold in a figure only.
"""

from __future__ import annotations

import math

from app.observations import Step

TURN_RAD = 0.35
"""Walking straight sways by less than 0.2 rad a step; a corner is taken in two or three steps."""


def is_turn(step: Step, threshold_rad: float = TURN_RAD) -> bool:
    """Whether the walker turned during this step."""
    return abs(step.heading_change_rad) > threshold_rad


def last_turn_s(before_s: float, steps: tuple[Step, ...], threshold_rad: float = TURN_RAD) -> float:
    """Time of the newest step during which the walker turned. before_s : as known before these steps, -inf: never."""
    return max([before_s, *(step.time_s for step in steps if is_turn(step, threshold_rad))])


def straight_since(turned_s: float, since_s: float) -> bool:
    """Whether no step has turned after a time. turned_s : newest one that did."""
    return math.isfinite(since_s) and turned_s < since_s
