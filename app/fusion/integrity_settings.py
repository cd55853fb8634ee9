"""Settings of method A, with where each default comes from."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.fusion.scan_matching import FixError, Matcher
from app.fusion.walking_track import TrackSettings
from app.integrity.fault_detection import MonitorSettings

WEIBULL_ERROR = FixError(2.0, 0.6, 3.4)


@dataclass(frozen=True, slots=True)
class IntegritySettings:
    """Of the method. Measured on folds 1-4 of the mall walks unless said otherwise.

    matcher : the paper's is Weibull-Bayes; see docs/methods/integrity_ukf.md for what each measured.
    least_known : access points known to the map with which a scan is usable.
    error : of the matcher's fixes.
    control_twice : step length and turn as observations too, after the paper; see "Double use" in the method's page.
    length_sigma_m, turn_sigma_rad : of those observations.
    agree_sigmas : of the difference of two fixes, within which two that failed say the same: after a fault the track
    then begins anew at the fix; else the fixes are wrong, each in its own way, and the track goes on.
    silent_after_s : without a usable scan for so long the track coasts.
    tail : protection level beside a Gaussian's of the same covariance.
    use_steps, use_scans : False for the ablations; without scans a session takes its start from the first.
    """

    track: TrackSettings = field(default_factory=TrackSettings)
    monitor: MonitorSettings = field(default_factory=MonitorSettings)
    matcher: Matcher = Matcher.WKNN
    least_known: int = 3
    error: FixError = field(default_factory=FixError)
    control_twice: bool = False
    length_sigma_m: float = 0.12
    turn_sigma_rad: float = 0.05
    agree_sigmas: float = 2.0
    silent_after_s: float = 8.0
    tail: float = 1.35
    use_steps: bool = True
    use_scans: bool = True
