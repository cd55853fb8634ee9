"""Settings of `surefix`, with where each default comes from."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from app.fusion.hypotheses import HypothesisSettings
from app.fusion.integrity_settings import IntegritySettings
from app.fusion.walking_track import TrackSettings


@dataclass(frozen=True, slots=True)
class SurefixSettings:
    """Measured on folds 1-4 of the mall walks, never on fold 0, unless said otherwise.

    steps : how steps move the track, as in method A.
    lasting : share of a fix's variance that stays the same for as long as the surroundings do.
    distance_weight : by what the signal distance counts more than the mean square of errors asks for. Where nobody
    surveyed errors are seldom, but large and the same for a whole walk: 1.6 trades 0.02 m of mean error for levels
    that know it.
    least_known : access points known to the map with which a scan is usable.
    unlike : signal distance from which a scan is like nothing surveyed: no position begins at it.
    corrected_above : squared Mahalanobis distance above which a fix is weighed down (chi-squared, 2 degrees: 1 in 1000
    of a Gaussian; of the mall's scans 1 in 100 exceed 6.5).
    silent_after_s : without a usable scan for so long the track coasts.
    least_floor_certainty : probability of the decided floor below which no answer is usable.
    tails : protection level beside a Gaussian's of the same covariance, by risk in ascending order: the rarer, the
    heavier. What held 1 - risk of all answers of folds 1-4, covered by the survey or not.
    """

    steps: IntegritySettings = field(
        default_factory=lambda: IntegritySettings(track=TrackSettings(heading_noise_rad=1.0, step_sigma_m=0.3))
    )
    hypotheses: HypothesisSettings = field(default_factory=HypothesisSettings)
    lasting: float = 0.6
    distance_weight: float = 1.6
    least_known: int = 3
    unlike: float = 0.75
    corrected_above: float = 6.0
    silent_after_s: float = 8.0
    least_floor_certainty: float = 0.6
    tails: tuple[tuple[float, float], ...] = ((0.001, 1.36), (0.002, 1.32), (0.01, 1.22), (0.05, 1.13))

    @property
    def track(self) -> TrackSettings:
        """Of the walking model."""
        return self.steps.track

    def tail_at(self, risk: float) -> float:
        """The factor at a risk, between the tabled ones along its logarithm."""
        risks, factors = zip(*self.tails, strict=True)
        return float(np.interp(math.log(risk), [math.log(one) for one in risks], factors))
