"""What errors of left-out survey scans say of a building, walks counting alike: the scans of one err alike."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from app.estimation.arrays import FloatArray, IntArray

APART_M = (4.0, 16.0)
"""Places so far apart are not one place any more, and still near enough for what a radio map gets wrong in both."""
OUTLYING = 3.0
"""Standard deviations that an error counts for at most."""


def conformal_reach(score: FloatArray, walk: IntArray, share: float) -> float:
    """The score that a scan of a new walk stays below in this share of cases, were walks drawn alike.

    Parameters
    ----------
    score : (n,) larger is worse.  walk : (n,) whose; the scans of one err alike, so each walk counts once.

    Notes
    -----
    Split conformal prediction (Vovk et al. 2005) over walks: of w walks the share is raised by 1 / w of itself; where
    that passes 1 the largest score is taken.
    """
    _, which, count = np.unique(walk, return_inverse=True, return_counts=True)
    order = np.argsort(score)
    reached = np.cumsum((1.0 / count)[which.reshape(-1)][order]) / len(count)
    wanted = share * (1.0 + 1.0 / len(count))
    return float(score[order[min(int(np.searchsorted(reached, wanted)), len(order) - 1)]])


def persistence(error: FloatArray, xy_m: FloatArray, walk: IntArray) -> float:
    """How errors last along a walk: the correlation of those APART_M; 1 of walks too short to say.

    Parameters
    ----------
    error : (n, 2) in standard deviations.  xy_m : (n, 2) where.  walk : (n,) whose.

    Notes
    -----
    Pairs of one walk are no independent witnesses: a walk of k pairs counts as its mean over the root of k.
    """
    error = error / np.maximum(np.hypot(*error.T) / OUTLYING, 1.0)[:, None]
    alike, whole = 0.0, 0.0
    for one in np.unique(walk):
        of_walk, at_m = error[walk == one], xy_m[walk == one]
        first, second = cKDTree(at_m).query_pairs(APART_M[1], output_type="ndarray").T
        apart_m = np.hypot(*(at_m[first] - at_m[second]).T)
        counted = (apart_m >= APART_M[0]) & (apart_m < APART_M[1])
        pairs = of_walk[first[counted]], of_walk[second[counted]]
        if len(pairs[0]):
            weight = len(pairs[0]) ** -0.5
            alike += weight * float((pairs[0] * pairs[1]).sum())
            whole += weight * float((pairs[0] ** 2 + pairs[1] ** 2).sum()) / 2.0
    return alike / whole if whole > 0.0 else 1.0
