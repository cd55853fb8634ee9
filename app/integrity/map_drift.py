"""Whether a radio map still sounds as when it was surveyed: a test of each square that phones walk through.

Compared are logarithms of signal distances: the mean over the visits of a square in use with what the survey's own
left-out walks expect there. The evidence is a ratio of likelihoods, which may be looked at after every visit: in a
place that has not changed, the chance that it ever exceeds 1 / alpha is at most alpha (Ville's inequality), and the
squares that `drifted` names out of many are false in a share of at most alpha, however the squares depend on one
another (Wang and Ramdas 2022, doi:10.1111/rssb.12489, e-BH).
"""

from __future__ import annotations

import math

import numpy as np

from app.estimation.arrays import FloatArray, IntArray

ALPHA = 0.05
"""Of all squares of a version together, for as long as its use is counted as one. A bound: of 1,000 drawn versions
that had not changed it named a square of one."""
TOLERATED = math.log(1.1)
"""A shift that is no drift: other phones, other crowds, and a fix that is a square off."""
DRIFT = 1.0
"""Standard deviation of the shift that is looked for: a change of access points multiplies distances by 2 to 5."""


def log_evidence(shift: FloatArray, noise: FloatArray, known_to: FloatArray) -> FloatArray:
    """Evidence that squares have become unlike their survey.

    Parameters
    ----------
    shift : (c,) mean logarithm over visits, minus what is expected.
    noise : (c,) variance of that mean.  known_to : (c,) variance of what is expected.

    Returns
    -------
    (c,) logarithm of the likelihood of `shift - TOLERATED` under N(0, noise + known_to + DRIFT^2), over that under
    N(0, noise + known_to); 0 at most where the shift is tolerated.
    """
    beyond = np.maximum(np.asarray(shift) - TOLERATED, 0.0)
    unchanged = np.asarray(noise) + np.asarray(known_to)
    changed = unchanged + DRIFT**2
    gained = 0.5 * beyond**2 * (1.0 / unchanged - 1.0 / changed)
    return np.asarray(gained - 0.5 * np.log(changed / unchanged), np.float64)


def drifted(log_e: FloatArray, alpha: float = ALPHA) -> IntArray:
    """Indices of the squares that have drifted, the most evident first.

    Parameters
    ----------
    log_e : (c,) evidence of every square that was looked at, flagged or not: leaving some out makes false alarms.
    """
    order = np.argsort(-np.asarray(log_e), kind="stable")
    needed = math.log(max(len(order), 1) / alpha) - np.log(np.arange(1, len(order) + 1))
    enough = np.flatnonzero(np.asarray(log_e)[order] >= needed)
    return np.asarray(order[: enough[-1] + 1] if len(enough) else order[:0], np.int64)
