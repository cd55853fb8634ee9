"""Where the phone is carried: a random forest over what a walk feels like whatever way the phone is turned.

Unconstrained-smartphones paper section 4: norm, horizontal part and part along gravity of the acceleration, each by
its variance, mean, median, maximum and minimum, in windows of 2 s that overlap by half. The forest is trained by
`surefix train-carrying` on simulated people, phones and positions; carrying_model.npz holds its trees as arrays.

Differs from the paper: windows without movement say nothing and are skipped; the answers of the last windows are
averaged, since nobody moves a phone to and fro every second; the forest, grown on as much of each position, gets a
prior, in which alone counts whether the screen faces up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from app.estimation.arrays import FloatArray
from app.observations import Carrying
from app.pdr.carried_state import EAST, FACES, NORM, NORTH, UP
from app.pdr.gravity import GRAVITY_MPS2

WINDOW_S, APART_S = 2.0, 1.0
LEAST_CELLS = 30
"""In a window that has 50: a phone that reports less often tells too little of the movement."""
MOVING_MPS2 = 0.8
"""Standard deviation of the norm in a window that says something; the slowest walk has 0.9."""
CLASSES = (Carrying.HANDHELD, Carrying.POCKET, Carrying.CALL, Carrying.SWINGING)
FACES_UP = 0.4
"""Of a screen that is looked at on the way: it lies within 66 degrees of flat."""
PRIOR_LOOKED_AT, PRIOR_ELSE = np.array([0.6, 0.15, 0.02, 0.23]), np.array([0.15, 0.35, 0.2, 0.3])
"""How often a phone that asks for its position is carried so: mostly looked at, seldom called with. Guesses."""
SIGNALS, STATISTICS = ("norm", "horizontal", "vertical"), ("variance", "mean", "median", "max", "min")
FEATURES = tuple(f"{signal}_{statistic}" for signal in SIGNALS for statistic in STATISTICS)
MODEL_VERSION = 1
REMEMBERED = 6
"""Windows whose answers are kept: steps are told up to 4.5 s late."""
FORGET = 0.7
"""Share of the average that stays when another window comes in."""


@dataclass(frozen=True, slots=True, eq=False)
class Forest:
    """Trees as arrays over all n nodes, each tree's root first.

    root : (t,) node of each tree's root.  feature : (n,) index into FEATURES, negative at a leaf.  threshold : (n,) to
    the left when not above.  left, right : (n,).  share : (n, 4) of CLASSES at a leaf.
    """

    root: NDArray[np.int32]
    feature: NDArray[np.int8]
    threshold: NDArray[np.float32]
    left: NDArray[np.int32]
    right: NDArray[np.int32]
    share: NDArray[np.float32]

    def probabilities(self, features: FloatArray) -> FloatArray:
        """(4,) of CLASSES for the features (15,) of a window."""
        return _vote(self.root, self.feature, self.threshold, self.left, self.right, self.share, features)


@lru_cache(1)
def carrying_forest() -> Forest:
    """The forest that comes with the service.

    Raises
    ------
    RuntimeError : its file was made for other features or classes than this code has.
    """
    path = Path(__file__).with_name("carrying_model.npz")
    with np.load(path, allow_pickle=False) as arrays:
        described = (int(arrays["version"]), tuple(arrays["features"].tolist()), tuple(arrays["classes"].tolist()))
        if described != (MODEL_VERSION, FEATURES, tuple(one.value for one in CLASSES)):
            raise RuntimeError(f"{path.name} does not fit this version; make it anew with surefix train-carrying")
        return Forest(*(arrays[name] for name in ("root", "feature", "threshold", "left", "right", "share")))


def window_features(cells: FloatArray) -> FloatArray:
    """(15,) FEATURES of a window's cells (n, 8), in m/s^2 and its square."""
    norm = cells[:, NORM]
    horizontal = np.hypot(cells[:, EAST], cells[:, NORTH])
    vertical = cells[:, UP] + GRAVITY_MPS2
    found = [
        statistic(signal)
        for signal in (norm, horizontal, vertical)
        for statistic in (np.var, np.mean, np.median, np.max, np.min)
    ]
    return np.array(found, dtype=np.float64)


def says_something(cells: FloatArray) -> bool:
    """Whether a window's cells (n, 8) are of a phone that is carried about."""
    return len(cells) >= LEAST_CELLS and float(np.std(cells[:, NORM])) > MOVING_MPS2


@dataclass(frozen=True, slots=True, eq=False)
class Recognised:
    """next_s : end of the next window, NaN before the first.  answers : (REMEMBERED, 5) newest last: end of a window,
    averaged probabilities of CLASSES from then on; end -inf where there was none."""

    next_s: float = math.nan
    answers: FloatArray = field(default_factory=lambda: np.tile([-math.inf, 0.25, 0.25, 0.25, 0.25], (REMEMBERED, 1)))

    def at(self, time_s: float) -> Carrying:
        """The position at a time, as it was known then."""
        known = self.answers[(self.answers[:, 0] <= time_s) & np.isfinite(self.answers[:, 0])]
        return CLASSES[int(known[-1, 1:].argmax())] if len(known) else Carrying.UNKNOWN


def after_window(recognised: Recognised, end_s: float, cells: FloatArray) -> Recognised:
    """What is known after the window (n, 8) that ends at end_s."""
    if not says_something(cells):
        return recognised
    prior = PRIOR_LOOKED_AT if float(np.mean(cells[:, FACES])) > FACES_UP else PRIOR_ELSE
    found = prior * carrying_forest().probabilities(window_features(cells))
    found = found / found.sum()
    before = recognised.answers[-1]
    average = found if not math.isfinite(before[0]) else FORGET * before[1:] + (1.0 - FORGET) * found
    answers = np.vstack([recognised.answers[1:], np.concatenate([[end_s], average])])
    return Recognised(recognised.next_s, answers)


@njit(cache=True)
def _vote(
    root: NDArray[np.int32],
    feature: NDArray[np.int8],
    threshold: NDArray[np.float32],
    left: NDArray[np.int32],
    right: NDArray[np.int32],
    share: NDArray[np.float32],
    features: FloatArray,
) -> FloatArray:
    votes = np.zeros(share.shape[1])
    for tree in range(len(root)):
        node = root[tree]
        while feature[node] >= 0:
            # trees are grown on single precision
            below = np.float32(features[feature[node]]) <= threshold[node]
            node = left[node] if below else right[node]
        for k in range(share.shape[1]):
            votes[k] += share[node, k]
    return votes / len(root)
