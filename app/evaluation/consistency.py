"""Whether a covariance is as large as the errors it stands for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.stats import chi2

from app.estimation.arrays import FloatArray
from app.evaluation.replay import Answer

DIMENSION = 2


@dataclass(frozen=True, slots=True)
class Consistency:
    """NEES of horizontal positions on the right floor.

    nees_mean : 2 where the covariance is right, more where it is too small.  inside_95_ellipse : share of truth inside
    the 95 % ellipse.  lag1_correlation : of the error between an answer and the next of the same walk, by component:
    near 1, n answers are far from n independent witnesses, and the interval is not that of n.
    """

    n: int
    nees_mean: float
    nees_median: float
    inside_95_ellipse: float
    lag1_correlation: float


def nees(error_m: FloatArray, covariance_m2: FloatArray) -> FloatArray:
    """Normalised estimation error squared, `e' P^-1 e`.

    Parameters
    ----------
    error_m : (n, d).
    covariance_m2 : (n, d, d).

    Returns
    -------
    (n,) ; infinite where the covariance is not positive definite: an error without any claim is beyond every bound.
    """
    values = np.full(len(error_m), np.inf)
    for index, (error, covariance) in enumerate(zip(error_m, covariance_m2, strict=True)):
        try:
            whitened = np.linalg.solve(np.linalg.cholesky(covariance), error)
        except np.linalg.LinAlgError:
            continue
        values[index] = whitened @ whitened
    return values


def consistency(answers: Sequence[Answer]) -> Consistency:
    """Consistency of the positions among the answers; a position on a wrong floor has no horizontal error to judge."""
    judged = [a for a in answers if a.xy_m is not None and a.covariance_m2 is not None and a.floor_right]
    if not judged:
        return Consistency(0, math.nan, math.nan, math.nan, math.nan)
    error_m = np.array([a.xy_m for a in judged], dtype=np.float64) - np.array([a.truth_xy_m for a in judged])
    values = nees(error_m, np.array([a.covariance_m2 for a in judged], dtype=np.float64))
    return Consistency(
        n=len(judged),
        nees_mean=float(values.mean()),
        nees_median=float(np.median(values)),
        inside_95_ellipse=float(np.mean(values <= chi2.ppf(0.95, DIMENSION))),
        lag1_correlation=_lag1(judged, error_m),
    )


def _lag1(judged: Sequence[Answer], error_m: FloatArray) -> float:
    walk = [a.walk_key for a in judged]
    follows = np.array([one == next_one for one, next_one in pairwise(walk)], dtype=np.bool_)
    earlier, later = error_m[:-1][follows], error_m[1:][follows]
    power = math.sqrt(float((earlier**2).sum() * (later**2).sum()))
    return float((earlier * later).sum()) / power if power > 0.0 else math.nan
