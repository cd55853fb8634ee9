"""Settings of method B, with where each default comes from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from app.fusion.fix_trial import TrialSettings
from app.pdr.attitude_ekf import PAPER_ATTITUDE, AttitudeNoise
from app.pdr.turn_detection import TURN_RAD
from app.wifi.match import Match
from app.wifi.partition_search import PartitionSettings


@dataclass(frozen=True, slots=True)
class PositionNoise:
    """Variances of the position filter, in the paper's order x and y, step length, heading.

    place_m2, length_m2, heading_rad2 : process noise of a step, Eq. 22.
    fix_m2, fix_scatter : of a WiFi fix in each direction, Eq. 25: the first, and so many times the variance of its
    neighbours.  fix_length_m2 : of a step's length by the accelerometer.  fix_heading_rad2 : of a direction by WiFi.
    start_length_m, start_length_m2 : step length before the first step, Eq. 19 and 20.

    Chosen on folds 1-4 of the mall walks. PAPER_POSITION: the paper's, for its site and its known start.
    """

    place_m2: float = 0.04
    length_m2: float = 0.01
    heading_rad2: float = 0.002
    fix_m2: float = 8.0
    fix_scatter: float = 3.0
    fix_length_m2: float = 0.01
    fix_heading_rad2: float = 3.0
    start_length_m: float = 0.6
    start_length_m2: float = 0.01

    def of_fix_m2(self, match: Match) -> float:
        """Variance of a fix in each direction."""
        return self.fix_m2 + self.fix_scatter * float(match.covariance_m2.trace()) / 2.0


PAPER_POSITION = PositionNoise(0.01, 1e-4, 0.01, 1000.0, 0.0, 10.0, 100.0, 0.6, 0.01)


@dataclass(frozen=True, slots=True)
class TwoStageSettings:
    """Of the method.

    search : how scans are matched; `search.moving` False is the plain WKNN.
    attitude, position : noises of the two filters.
    turn_rad : of one step, from which it is a turn.  least_progress_m : over four fixes, for a direction.
    use_direction : False leaves the direction from WiFi out.
    trial : of the fixes.  error_m2 : variance of a fix in each direction, by which it is tested and a track begins.
    lasting_m2 : variance in each direction that no number of fixes in one place takes away, reported beside the
    filter's own.
    least_known : access points known to the map with which a scan is usable.
    silent_after_s : without a usable scan for so long the track coasts.
    tail : protection level beside a Gaussian's of the same covariance.
    use_steps, use_scans : False for the paper's WiFi alone and MEMS alone; without scans a session takes its start
    from the first.
    """

    search: PartitionSettings = field(default_factory=PartitionSettings)
    attitude: AttitudeNoise = field(default_factory=AttitudeNoise)
    position: PositionNoise = field(default_factory=PositionNoise)
    turn_rad: float = TURN_RAD
    least_progress_m: float = 4.0
    use_direction: bool = True
    trial: TrialSettings = field(default_factory=TrialSettings)
    error_m2: float = 45.0
    lasting_m2: float = 8.0
    least_known: int = 3
    silent_after_s: float = 8.0
    tail: float = 1.9
    use_steps: bool = True
    use_scans: bool = True


_OURS = TwoStageSettings()
_UNTESTED = TrialSettings(tested=False)
_FIVE = replace(_OURS.search, strongest=replace(_OURS.search.strongest, count=5))
_WIFI = replace(
    _OURS,
    use_steps=False,
    trial=_UNTESTED,
    position=replace(_OURS.position, fix_m2=1e-6, fix_scatter=0.0),
    lasting_m2=_OURS.error_m2,
)
TWO_STAGE_ABLATIONS: dict[str, TwoStageSettings] = {
    "two_stage_ekf_full_search": replace(_OURS, search=replace(_OURS.search, moving=False)),
    "two_stage_ekf_noisy_attitude": replace(_OURS, attitude=PAPER_ATTITUDE),
    "two_stage_ekf_paper_noise": replace(_OURS, attitude=PAPER_ATTITUDE, position=PAPER_POSITION, trial=_UNTESTED),
    "two_stage_ekf_no_direction": replace(_OURS, use_direction=False),
    "two_stage_ekf_five_access_points": replace(_OURS, search=_FIVE),
    "two_stage_wifi_alone": _WIFI,
    "two_stage_wifi_full_search": replace(_WIFI, search=replace(_OURS.search, moving=False)),
    "two_stage_mems_alone": replace(_OURS, use_scans=False),
}
"""The rows of the paper's tables, and what each part is worth. WiFi alone is each fix as it is."""
