"""Radii that hold the truth with a stated probability."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.special import chdtri

from app.estimation.arrays import FloatArray

ACCURACY_SHARE = 0.68
LEAST_RADIUS_M = 0.1
WIFI_TAILS = ((0.001, 1.36), (0.002, 1.32), (0.01, 1.22), (0.05, 1.13))
"""By risk in ascending order: how much heavier than a Gaussian's the tails of WiFi errors are that a calibrated
covariance describes. What held 1 - risk of the mall's answers, folds 1-4; the rarer, the heavier."""

NOWHERE_SAFE = 3.0
"""Of the alert limit: what is told while the floor is uncertain. A wrong floor is outside of every radius."""


@lru_cache(32)
def _quantiles(share: float) -> tuple[FloatArray, FloatArray]:
    """Degrees of freedom from 1 to 2, and the chi-squared quantile of each."""
    freedom = np.linspace(1.0, 2.0, 41)
    return freedom, np.asarray(chdtri(freedom, 1.0 - share))


def radius_holding(covariance_m2: FloatArray, share: float) -> float:
    """Radius about the mean that holds this share of a two-dimensional Gaussian, metres.

    Parameters
    ----------
    covariance_m2 : (2, 2) positive semidefinite.  share : in (0, 1).

    Notes
    -----
    The squared distance is taken as a scaled chi-squared variable of the same mean and variance (Satterthwaite): exact
    for a circle and for a line, within 2 % between.  Never less than LEAST_RADIUS_M.
    """
    xx, xy, yy = float(covariance_m2[0, 0]), float(covariance_m2[0, 1]), float(covariance_m2[1, 1])
    total = xx + yy
    square = xx * xx + yy * yy + 2.0 * xy * xy
    if not total > 0.0:
        return LEAST_RADIUS_M
    freedom, quantile = _quantiles(share)
    radius_m = math.sqrt(square / total * float(np.interp(total * total / square, freedom, quantile)))
    return max(radius_m, LEAST_RADIUS_M)


def protection_level_m(covariance_m2: FloatArray, risk: float, tail: float, disagreement_m: float = 0.0) -> float:
    """Radius that the truth leaves with no more than this probability.

    Parameters
    ----------
    covariance_m2 : (2, 2) of the position.  risk : in (0, 1).
    tail : how much heavier than a Gaussian's the tails of the errors are; measured.
    disagreement_m : distance by which two sources contradict each other; either may be right, so it is added.
    """
    return tail * radius_holding(covariance_m2, 1.0 - risk) + disagreement_m


def tail_at(risk: float, tails: tuple[tuple[float, float], ...] = WIFI_TAILS) -> float:
    """The factor at a risk, between the tabled ones along its logarithm. tails : pairs by risk in ascending order."""
    risks, factors = zip(*tails, strict=True)
    return float(np.interp(math.log(risk), [math.log(one) for one in risks], factors))
