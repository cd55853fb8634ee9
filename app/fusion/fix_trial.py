"""Testing WiFi fixes in a method whose paper has no integrity layer: is this one an outlier, are several a fault?

One chi-squared test of each fix against where the steps lead, and a count of those that fail in a row. A fix that fails
is not fused; when several fail, the track is given up for the newest. Neither changes how a method fuses what passes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray
from app.estimation.innovation import chi2_threshold, normalised_square
from app.fusion.fix_assembly import Phases, length_of_m, taken_out
from app.integrity.fault_detection import streak_after
from app.observations import InnovationCheck


@dataclass(frozen=True, slots=True)
class TrialSettings:
    """tested : False fuses everything, after the papers.  false_alarm : of one test, for errors that are Gaussian;
    those of WiFi fixes are not, so it is rarer than it looks.  fault_after : failed tests in a row."""

    tested: bool = True
    false_alarm: float = 1e-3
    fault_after: int = 3


@dataclass(frozen=True, slots=True, eq=False)
class Tried:
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


def tried(
    time_s: float, innovation_m: FloatArray, spread_m2: FloatArray, streak: int, settings: TrialSettings
) -> Tried:
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
    rejected = not statistic <= threshold and (settings.tested or not math.isfinite(statistic))
    sigma_m = np.sqrt(np.maximum(np.diag(spread_m2), 0.0))
    check = InnovationCheck("wifi", time_s, innovation_m, sigma_m, statistic, threshold, rejected, not rejected)
    told = statistic if math.isfinite(statistic) else None
    streak = streak_after(streak, int(rejected))
    if not rejected:
        return Tried(check, Phases(statistic=told, threshold=threshold), streak)
    fault = streak >= settings.fault_after
    apart_m = length_of_m(innovation_m)
    phases = Phases(1, 1, int(fault), told, threshold, apart_m, (taken_out(apart_m, fault),))
    return Tried(check, phases, streak)
