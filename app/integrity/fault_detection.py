"""The three phases of integrity monitoring of one measurement, and when failed tests become a fault.

Integrity paper section 4.4. Phase 1 tests the whole innovation (IF1); phase 2 repeats the update with R inflated by
IGG III weights; phase 3 tests each component (IF2), takes out those that fail, and calls it a fault when one source
fails again and again (IF3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import BoolArray, FloatArray
from app.estimation.innovation import chi2_threshold, normalised_square
from app.estimation.robust_weights import igg3, inflated
from app.estimation.unscented_kalman import correct, gain_of


@dataclass(frozen=True, slots=True)
class MonitorSettings:
    """Constants of the paper; where it leaves one open, ours.

    monitored : False leaves the plain filter: every finite measurement is fused, nothing is ever flagged.
    false_alarm : of phase 1, section 4.4.1, from aviation.  outlier_sigmas : C of Eq. 42.
    outlier_gain : m of Eq. 43, in (0, 1); the paper gives no value, ours leaves a hundredth.
    fault_after : failed tests of one source in a row that make a fault; the paper only says "successively".
    literal_phase3 : Pzz of phase 3 from the inflated R, as Eq. 42 is written. Then no component can ever fail.
    """

    monitored: bool = True
    false_alarm: float = 0.333e-6
    outlier_sigmas: float = 3.0
    outlier_gain: float = 0.01
    fault_after: int = 3
    literal_phase3: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Monitored:
    """State and covariance after a monitored measurement, and what was found.

    if1, if2 : flags of phases 1 and 3.  sigma : (m,) nominal, of the innovation.  statistic, threshold : of phase 1.
    """

    mean: FloatArray
    covariance: FloatArray
    if1: int
    if2: int
    sigma: FloatArray
    statistic: float
    threshold: float


def monitored_update(
    prior: tuple[FloatArray, FloatArray],
    expectation: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    noise: FloatArray,
    is_angle: BoolArray,
    settings: MonitorSettings,
) -> Monitored:
    """Update the prior with a measurement, through the phases that it needs.

    Parameters
    ----------
    prior : mean (n,) and covariance (n, n).
    expectation : innovation (m,), its covariance (m, m), cross covariance (n, m), optimal gain (n, m).
    noise : (m, m) nominal measurement noise, part of the innovation's covariance.
    is_angle : (n,) components of the state that are angles.

    Notes
    -----
    A measurement that is not finite changes nothing and fails.

    Differs from the paper: phase 3 takes Pzz of the nominal R (see `literal_phase3`), and Eq. 43 shrinks the gain's
    columns of the failing components, not all of it. The residuals of phase 2 are standardised with nominal Pzz too.
    """
    mean, covariance = prior
    innovation, spread, cross, gain = expectation
    threshold = chi2_threshold(len(innovation), settings.false_alarm)
    sigma = np.sqrt(np.maximum(np.diag(spread), 0.0))
    if not (np.isfinite(innovation).all() and np.isfinite(spread).all() and np.isfinite(gain).all()):
        return Monitored(mean, covariance, 1, 1, sigma, math.inf, threshold)
    statistic = normalised_square(innovation, spread)
    if not settings.monitored or statistic <= threshold:
        after, spread_after = correct(mean, covariance, innovation, spread, cross, gain, is_angle)
        return Monitored(after, spread_after, 0, 0, sigma, statistic, threshold)

    robust = spread - noise + inflated(noise, igg3(innovation / sigma))
    gain = gain_of(cross, robust)
    tested = np.sqrt(np.diag(robust)) if settings.literal_phase3 else sigma
    failed = np.abs(innovation) > settings.outlier_sigmas * tested
    if failed.any():
        gain = gain * np.where(failed, settings.outlier_gain, 1.0)
    after, spread_after = correct(mean, covariance, innovation, robust, cross, gain, is_angle)
    return Monitored(after, spread_after, 1, int(failed.any()), sigma, statistic, threshold)


def streak_after(streak: int, if2: int) -> int:
    """Failed tests of a source in a row, after one more test of it."""
    return streak + 1 if if2 else 0


def is_fault(streak: int, settings: MonitorSettings) -> bool:
    """Whether so many failed tests in a row are a fault rather than outliers (IF3)."""
    return streak >= settings.fault_after


def same_place(one_m: FloatArray | None, other_m: FloatArray | None, variance_m2: float, agree_sigmas: float) -> bool:
    """Whether two fixes that failed lie equally far from where the steps led: then it is the track that is wrong.

    Parameters
    ----------
    one_m, other_m : (2,) innovations, None where there was none.  variance_m2 : of a fix, in each direction.
    agree_sigmas : standard deviations of their difference within which they agree.
    """
    if one_m is None or other_m is None:
        return False
    return float(np.hypot(*(one_m - other_m))) <= agree_sigmas * math.sqrt(2.0 * variance_m2)
