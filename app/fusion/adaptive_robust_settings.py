"""Settings of method D, with where each default comes from."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from app.fusion.scan_matching import FixError, Matcher


@dataclass(frozen=True, slots=True)
class ContextNoise:
    """Standard deviations of one step's process noise, by context.

    straight_rad, turning_rad : of the heading.  corridor_m, open_m : of the position in each direction.
    normal_m, unusual_m : of the step length at normal, and at slow or fast pace.
    """

    straight_rad: float
    turning_rad: float
    corridor_m: float
    open_m: float
    normal_m: float
    unusual_m: float


STEPS_A_SCAN = 4.0
"""The paper predicts once a WiFi fix, every 2 s; here every step is a prediction, and four share its variance."""
PAPER_NOISE = ContextNoise(
    straight_rad=math.radians(2.0) / math.sqrt(STEPS_A_SCAN),
    turning_rad=math.radians(10.0) / math.sqrt(STEPS_A_SCAN),
    corridor_m=2.5 / math.sqrt(STEPS_A_SCAN),
    open_m=5.0 / math.sqrt(STEPS_A_SCAN),
    normal_m=1.0 / math.sqrt(STEPS_A_SCAN),
    unusual_m=2.0 / math.sqrt(STEPS_A_SCAN),
)
"""Section 4.1. It prints 2 degrees for turning and 10 for straight, against its own sentence that turning is larger."""
OUR_NOISE = ContextNoise(
    straight_rad=0.01, turning_rad=0.05, corridor_m=0.2, open_m=0.4, normal_m=0.003, unusual_m=0.006
)
"""The paper's proportions at the size that a step's errors have; folds 1-4 of the mall walks. With the paper's sizes
the filter forgets the steps and follows the scans: see the method's page."""
OUR_FIXED = ContextNoise(
    straight_rad=0.02, turning_rad=0.02, corridor_m=0.3, open_m=0.3, normal_m=0.004, unusual_m=0.004
)
"""Of the standard filter, in between."""


@dataclass(frozen=True, slots=True)
class AdaptiveRobustSettings:
    """Of the method. Measured on folds 1-4 of the mall walks unless said otherwise.

    adaptive : False for the standard filter, whose noise is `fixed` whatever the context.
    robust : False leaves R as it is; failed tests then show in no flag.
    significance : of the F test; 0.01 in the paper.
    error : of the matcher's fixes.
    outlier_sigmas : of a component, beyond which a fix is called an outlier.  fault_after : so many in a row are a
    fault.  agree_sigmas : of the difference of two outliers, within which they say the same: the track is then wrong.
    length_sigma_m, askew_sigma_rad : of the step-length and heading errors at first.
    lost_share : variance of a step in an unknown direction, in squared step lengths.
    inflation : by what the covariance told to the phone is larger than the filter's, which takes fixes in a row for
    independent witnesses though they err alike.
    tail : protection level beside a Gaussian's of that covariance.
    """

    adaptive: bool = True
    robust: bool = True
    noise: ContextNoise = OUR_NOISE
    fixed: ContextNoise = OUR_FIXED
    significance: float = 0.01
    matcher: Matcher = Matcher.WKNN
    least_known: int = 3
    error: FixError = field(default_factory=FixError)
    outlier_sigmas: float = 3.0
    fault_after: int = 3
    agree_sigmas: float = 2.0
    length_sigma_m: float = 0.07
    askew_sigma_rad: float = 0.2
    lost_share: float = 5.0
    silent_after_s: float = 8.0
    inflation: float = 2.7
    tail: float = 1.35
