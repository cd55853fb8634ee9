"""Settings of `surefix`, with where each default comes from."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion.access_point_watch import AccessPointWatchSettings
from app.fusion.cloud_place import Place
from app.fusion.cloud_settings import CloudSettings
from app.fusion.facing import FacingSettings
from app.fusion.hearing import HearingSettings
from app.fusion.hypotheses import HypothesisSettings
from app.integrity.protection_level import tail_at
from app.wifi.fix_calibration import DISTANCE_WEIGHT, FixCalibration
from app.wifi.floor_decision import CERTAIN


@dataclass(frozen=True, slots=True)
class SurefixSettings:
    """Measured on folds 1-4 of the mall walks, never on fold 0, unless said otherwise.

    cloud : how steps move the track, and walls stop it.
    hypotheses : when a fix contradicts the track, and a rival takes over.
    access_points : how faulty ones are found and left out.
    hearing : when a phone is deaf to some.
    facing : when it is held otherwise than the walker goes.
    lasting : share of a fix's variance that stays the same for as long as the surroundings do, less where the map's
    errors last less (FixCalibration.persistence).
    distance_weight : as DISTANCE_WEIGHT of app/wifi/fix_calibration.py.
    least_known : access points known to the map with which a scan is usable.
    unlike : signal distance from which a scan is like nothing surveyed: no position begins at it.
    alike : weight beside the best point's from which a track may as well begin at a point.
    corrected_above : squared Mahalanobis distance above which a fix is weighed down (chi-squared, 2 degrees: 1 in 1000
    of a Gaussian; of the mall's scans 1 in 100 exceed 6.5).
    beacon_caution, beacon_caution_alone : by what the variance of a fix by Bluetooth beacons counts more, for what it
    shares with those before and with WiFi; and where there is no WiFi.
    stairs_sigma_m : how far steps on stairs mislead in plan, in each direction.
    silent_after_s : without a usable scan for so long the track coasts.
    least_floor_certainty : probability of the decided floor below which no answer is usable.
    spread, least_radius_68_m : the accuracy is the radius that holds 68 % of the cloud, and beside it the least one, by
    this factor: errors that fixes share over a whole walk make every cloud too sure.
    tails, least_radius_99_m : the same of the protection level and the radius that holds 99 %, by risk in ascending
    order: the rarer, the heavier. What held 1 - risk of all answers of folds 1-4, covered by the survey or not.
    strange_usual_m2 : variance that scans of surveyed places have at most for being unlike the survey. What is beyond
    errs alike until the phone is back where somebody surveyed, which no cloud knows.
    strange_68, strange_99 : standard deviations of that beyond in either radius.
    strange_memory : weight of the newest scan in it.
    """

    cloud: CloudSettings = field(default_factory=CloudSettings)
    hypotheses: HypothesisSettings = field(default_factory=HypothesisSettings)
    access_points: AccessPointWatchSettings = field(default_factory=AccessPointWatchSettings)
    hearing: HearingSettings = field(default_factory=HearingSettings)
    facing: FacingSettings = field(default_factory=FacingSettings)
    lasting: float = 0.5
    distance_weight: float = DISTANCE_WEIGHT
    least_known: int = 3
    unlike: float = 0.75
    alike: float = 1e-3
    corrected_above: float = 6.0
    beacon_caution: float = 8.0
    beacon_caution_alone: float = 4.0
    stairs_sigma_m: float = 2.0
    silent_after_s: float = 8.0
    least_floor_certainty: float = CERTAIN
    spread: float = 1.2
    least_radius_68_m: float = 1.0
    least_radius_99_m: float = 7.0
    strange_usual_m2: float = 50.0
    strange_68: float = 1.0
    strange_99: float = 3.0
    strange_memory: float = 0.25
    tails: tuple[tuple[float, float], ...] = ((0.001, 2.0), (0.002, 1.6), (0.01, 1.04), (0.05, 0.81))

    def tail_at(self, risk: float) -> float:
        """Of the protection level at a risk."""
        return tail_at(risk, self.tails)

    def strange_m2(self, before_m2: float | None, newest_m2: float) -> float:
        """Variance that scans have lately for being unlike the survey. before_m2 : before the newest, None at first."""
        return newest_m2 if before_m2 is None else before_m2 + self.strange_memory * (newest_m2 - before_m2)

    def accuracy_m(self, here: Place, strange_m2: float, learnt: FixCalibration) -> float:
        """Radius that holds the truth in 68 of 100 answers. strange_m2 : of the last scans.  learnt : of the map."""
        least_m = math.hypot(self.least_radius_68_m, self.strange_68 * self._beyond_m(strange_m2))
        return learnt.reach_68 * self.spread * math.hypot(here.radius_68_m, least_m)

    def level_m(self, here: Place, strange_m2: float, risk: float, learnt: FixCalibration) -> float:
        """Radius that the truth leaves with no more than this probability. strange_m2, learnt : likewise."""
        least_m = math.hypot(learnt.fineness * self.least_radius_99_m, self.strange_99 * self._beyond_m(strange_m2))
        return learnt.reach * self.tail_at(risk) * math.hypot(here.radius_99_m, least_m)

    def covariance_m2(self, here: Place, strange_m2: float, learnt: FixCalibration) -> FloatArray:
        """(2, 2) of the position, as much larger than the cloud's as the accuracy is than the cloud's radius."""
        least_m2 = self.least_radius_68_m**2 + (self.strange_68 * self._beyond_m(strange_m2)) ** 2
        return (learnt.reach_68 * self.spread) ** 2 * (here.covariance_m2 + least_m2 / 2.28 * np.eye(2))

    def beyond_m2(self, strange_m2: float) -> float:
        """What of that variance scans of surveyed places do not have."""
        return max(strange_m2 - self.strange_usual_m2, 0.0)

    def _beyond_m(self, strange_m2: float) -> float:
        return math.sqrt(self.beyond_m2(strange_m2))
