"""Settings of method C, with where each default comes from."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

from app.fusion.walking_track import TrackSettings
from app.integrity.fault_detection import MonitorSettings
from app.pdr.quaternion_ukf import QuaternionNoise
from app.pdr.rmpca import DirectionSettings
from app.wifi.kernel_matching import PAPER, KernelSettings


class Filter(StrEnum):
    """Which filter moves the position: the paper's, or one of those that it is compared with."""

    UNSCENTED = "unscented"
    EXTENDED = "extended"
    LINEAR = "linear"


@dataclass(frozen=True, slots=True)
class TrustedArea:
    """Radius in which reference points take part: least_m + sigmas * standard deviation of the position.

    elsewhere : how much better a point outside must match, root mean square dB of the best inside over that of the best
    anywhere, for the fix to be taken from everywhere; infinite is the paper, which then never notices that it is lost.
    """

    least_m: float = 8.0
    sigmas: float = 3.0
    elsewhere: float = 1.25


@dataclass(frozen=True, slots=True)
class Empirical:
    """Constant noises, in place of those that the method finds for each step and scan.

    heading_rad, length_m : of a step.  fix_m : of a WiFi fix in each direction.
    """

    heading_rad: float = 0.3
    length_m: float = 0.15
    fix_m: float = 4.5


@dataclass(frozen=True, slots=True)
class DualSettings:
    """Of the method. Measured on folds 1-4 of the mall walks unless said otherwise.

    position_filter : UNSCENTED is the method.  empirical : None is the method, else the paper's comparisons.
    track : `learning` False is the paper's state, the position alone.
    heading_rad : of a step beside what attitude and axis account for.
    fix_scale : of the kernel density's covariance.  misfit_m2 : variance of a fix in each direction for every dB^2 by
    which the scan departs from the best point. 1 and 0 are the paper, whose radii are then too small.
    lasting : share of it that stays the same for as long as the surroundings do; 0 is the paper.
    least_known : access points known to the map with which a scan is usable.
    silent_after_s : without a usable scan for so long the track coasts.
    tail : protection level beside a Gaussian's of the same covariance.
    use_steps, use_scans : False for the ablations; without scans a session takes its start from the first.
    """

    position_filter: Filter = Filter.UNSCENTED
    empirical: Empirical | None = None
    quaternion: QuaternionNoise = field(default_factory=QuaternionNoise)
    direction: DirectionSettings = field(default_factory=DirectionSettings)
    track: TrackSettings = field(default_factory=lambda: TrackSettings(askew_sigma_rad=0.15, askew_drift_rad=0.01))
    monitor: MonitorSettings = field(default_factory=lambda: MonitorSettings(false_alarm=1e-3))
    kernel: KernelSettings = field(default_factory=KernelSettings)
    area: TrustedArea = field(default_factory=TrustedArea)
    heading_rad: float = 0.1
    fix_scale: float = 1.0
    misfit_m2: float = 0.5
    lasting: float = 0.3
    least_known: int = 3
    silent_after_s: float = 8.0
    tail: float = 1.4
    use_steps: bool = True
    use_scans: bool = True


PAPER_DIRECTION = DirectionSettings(keep=0.0, axis_rad=0.0, axis_samples=math.inf, pointed_rad=math.inf)
"""Each step by its own axis, the attitude's covariance the only doubt."""
AS_PRINTED = DualSettings(
    direction=PAPER_DIRECTION,
    heading_rad=0.0,
    track=TrackSettings(learning=False),
    kernel=PAPER,
    area=TrustedArea(elsewhere=math.inf),
    misfit_m2=0.0,
    lasting=0.0,
)
"""Everything as the paper writes it."""
