"""What a walker does, from the last few steps: going straight or turning, slowly, normally or fast.

Adaptive filter paper section 4.1: "the accumulated values of the gyroscope data" tell turning, those of the
accelerometer the speed. Each says how far the next step may be trusted.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from app.observations import Step

WINDOW = 3
"""Steps over which turns and speeds are gathered; a corner takes two or three, and the sway of single steps cancels."""
TURNING_RAD = 0.35
"""Turned over the window. On the mall walks of folds 1-4 steps are below 0.05 rad in half of all windows and beyond
this in 13 %, few in between."""
SLOW_MPS, FAST_MPS = 0.9, 1.4
"""By the step-length model. Up to 1.4 m/s it errs by 0.10 m a step on the mall walks of folds 1-4, beyond by 0.18."""
SHORTEST_STEP_S, LONGEST_STEP_S = 0.3, 1.2
"""A longer time since the step before is a pause, not a slow step."""


class Pace(StrEnum):
    """How fast somebody walks."""

    SLOW = "slow"
    NORMAL = "normal"
    FAST = "fast"


@dataclass(frozen=True, slots=True)
class WalkingContext:
    """Of the newest step.

    turns_rad : of the last WINDOW steps, oldest first.  speeds_mps : the same.
    """

    turns_rad: tuple[float, ...] = ()
    speeds_mps: tuple[float, ...] = ()

    @property
    def turning(self) -> bool:
        """Whether the walker goes round a corner rather than straight."""
        return abs(sum(self.turns_rad)) > TURNING_RAD

    @property
    def pace(self) -> Pace:
        """Slow, normal or fast; normal before the first step."""
        if not self.speeds_mps:
            return Pace.NORMAL
        speed_mps = sum(self.speeds_mps) / len(self.speeds_mps)
        return Pace.SLOW if speed_mps < SLOW_MPS else Pace.FAST if speed_mps > FAST_MPS else Pace.NORMAL


def context_after(context: WalkingContext, step: Step) -> WalkingContext:
    """The context after one more step. A step after a pause begins a new one."""
    if step.duration_s > LONGEST_STEP_S:
        context = WalkingContext()
    speed_mps = step.length_m / min(max(step.duration_s, SHORTEST_STEP_S), LONGEST_STEP_S)
    return WalkingContext(
        (*context.turns_rad, step.heading_change_rad)[-WINDOW:], (*context.speeds_mps, speed_mps)[-WINDOW:]
    )
