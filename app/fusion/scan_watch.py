"""Watching WiFi fixes in a method whose paper has no integrity layer: is this one an outlier, are several a fault?

One chi-squared test of each fix against where the steps lead, and a count of those that fail in a row. A fix that fails
is not fused; when several fail, the track is given up for the newest. Neither changes how a method fuses what passes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray
from app.estimation.innovation import chi2_threshold, normalised_square
from app.fusion.fix_assembly import Phases
from app.integrity.fault_detection import streak_after
from app.observations import Excluded, InnovationCheck

BEYOND_M = 1e6
"""Stands for a disagreement that is not finite."""


@dataclass(frozen=True, slots=True)
class WatchSettings:
    """watched : False fuses everything, after the papers.  false_alarm : of one test, for errors that are Gaussian;
    those of WiFi fixes are not, so it is rarer than it looks.  fault_after : failed tests in a row."""

    watched: bool = True
    false_alarm: float = 1e-3
    fault_after: int = 3


@dataclass(frozen=True, slots=True, eq=False)
class Watched:
    """What one fix's test found. streak : failed tests in a row, with this one."""

    check: InnovationCheck
    phases: Phases
    streak: int

    @property
    def passed(self) -> bool:
        """Whether the fix may be fused."""
        return not self.check.rejected

    @property
    def fault(self) -> bool:
        """Whether the track is to be given up."""
        return bool(self.phases.if3)


def watched(
    time_s: float, innovation_m: FloatArray, spread_m2: FloatArray, streak: int, settings: WatchSettings
) -> Watched:
    """Test one fix.

    Parameters
    ----------
    innovation_m, spread_m2 : (2,) and (2, 2) fix minus prediction, and its covariance.
    streak : failed tests in a row before this one.

    Notes
    -----
    What is not finite fails.
    """
    threshold, statistic = chi2_threshold(2, settings.false_alarm), math.inf
    if np.isfinite(innovation_m).all() and np.isfinite(spread_m2).all():
        statistic = float(normalised_square(innovation_m, spread_m2))
    rejected = not statistic <= threshold and (settings.watched or not math.isfinite(statistic))
    sigma_m = np.sqrt(np.maximum(np.diag(spread_m2), 0.0))
    check = InnovationCheck("wifi", time_s, innovation_m, sigma_m, statistic, threshold, rejected, not rejected)
    told = statistic if math.isfinite(statistic) else None
    streak = streak_after(streak, int(rejected))
    if not rejected:
        return Watched(check, Phases(statistic=told, threshold=threshold), streak)
    fault = streak >= settings.fault_after
    apart_m = float(np.hypot(*innovation_m))
    apart_m = apart_m if math.isfinite(apart_m) else BEYOND_M
    times = "again and again" if fault else "this once"
    excluded = (Excluded(f"{apart_m:.0f} m from where the steps lead, {times}", observation="wifi"),)
    return Watched(check, Phases(1, 1, int(fault), told, threshold, apart_m, excluded), streak)
