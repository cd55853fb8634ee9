"""How far a share can be trusted when the answers of one walk err together: bounds from resampled walks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import beta

CONFIDENCE = 0.95
"""Of every one-sided bound."""
RESAMPLES = 4000
_SEED = 18305


def share_bounds(part: ArrayLike, whole: ArrayLike, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """One-sided bounds, lower and upper, of sum(part) / sum(whole), by bootstrap with the walk as the unit.

    Walks are drawn with replacement, all their answers together: errors last for many seconds, so that the answers
    of a walk are far from independent. The draws are seeded: the same figures give the same bounds.

    Parameters
    ----------
    part : (w,) answers of each walk that count.
    whole : (w,) answers of each walk.

    Returns
    -------
    (lower, upper), each with this confidence alone. NaN where the bootstrap is blind: of no walk at all, an upper bound
    of what never happened (it would be 0) and a lower bound of what always did.
    """
    parts, wholes = np.asarray(part, dtype=np.float64), np.asarray(whole, dtype=np.float64)
    parts, wholes = parts[wholes > 0.0], wholes[wholes > 0.0]
    count = len(wholes)
    if not count:
        return math.nan, math.nan
    drawn = np.random.default_rng(_SEED).multinomial(count, np.full(count, 1.0 / count), RESAMPLES)
    lower, upper = np.quantile(drawn @ parts / (drawn @ wholes), (1.0 - confidence, confidence))
    never, always = not parts.any(), bool(np.all(parts == wholes))
    return math.nan if always else float(lower), math.nan if never else float(upper)


def most_walks(events: int, walks: int, confidence: float = CONFIDENCE) -> float:
    """Upper bound (Clopper-Pearson) of the share of walks with an event, seen in some of so many; NaN of none."""
    if not walks:
        return math.nan
    return 1.0 if events == walks else float(beta.ppf(confidence, events + 1, walks - events))
