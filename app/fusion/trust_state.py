"""Trust in a chain of dead reckoning: the trusted area, the three states, and TC, the accumulated mistrust.

After "Trust Chain Positioning Fusion" (Sensors 2015, 15, 29850), section 4.3; docs/methods/trust_chain.md. All its
equations are lost as images in the text that we have. Our reading, wherever it leaves them open:

- Eq. 15: a fix is trusted when, from the last position, its distance differs by no more than 2 m and its bearing by no
  more than 45 degrees from those of the steps. Who has not gone anywhere has no bearing; then the distance decides.
- Eq. 16: fused = (1 - w) steps + w fix, with w = TC / (1 + TC), so that at TC = 1 "the two are balanced equivalently".
- Eq. 17: between fixes TC grows by the distance times the steps' error per metre over the mean error of a fix.
- Eq. 18: after a fix that is not trusted TC becomes TC (1 + TC): it must grow, "rapidly, iteratively".
- A session begins at one fix: its mistrust is the mean error of a fix, TC = 1, and the chain is unlocked.
"""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from app.estimation.angles import wrap_all
from app.estimation.arrays import BoolArray, FloatArray
from app.fusion.state_codec import storable
from app.fusion.trust_chain_settings import TrustChainSettings

AT_START = 1.0
"""TC of a position that is one fix."""
NO_WAY_M = 0.3
"""Less than half a step has no bearing."""


@storable
class Trust(StrEnum):
    """TRUSTED_LOCKED : the newest fix is trusted.  LOCKED : an earlier one is.  UNLOCKED : none for too long."""

    TRUSTED_LOCKED = "trusted_locked"
    LOCKED = "locked"
    UNLOCKED = "unlocked"


def within_trusted_area(
    places_m: FloatArray, last_m: FloatArray, steps_m: FloatArray, settings: TrustChainSettings
) -> BoolArray:
    """Which of (n, 2) places lie in the annular sector that the steps set up, Eq. 15.

    Parameters
    ----------
    last_m : (2,) last position.  steps_m : (2,) where the steps have led from there.
    """
    way_m, ways_m = steps_m - last_m, places_m - last_m
    length_m, lengths_m = float(np.hypot(*way_m)), np.hypot(ways_m[:, 0], ways_m[:, 1])
    near = np.abs(lengths_m - length_m) <= settings.distance_m
    if length_m < NO_WAY_M:
        return near
    bearing_rad = math.atan2(way_m[0], way_m[1])
    apart_rad = np.abs(wrap_all(np.arctan2(ways_m[:, 0], ways_m[:, 1]) - bearing_rad))
    return near & ((apart_rad <= settings.bearing_rad) | (lengths_m < NO_WAY_M))


def weight_of(mistrust: float) -> float:
    """w of Eq. 16: what a fix counts against the steps."""
    return mistrust / (1.0 + mistrust)


def after_way(mistrust: float, way_m: float, settings: TrustChainSettings) -> float:
    """TC after a distance, Eq. 17."""
    grown = mistrust + settings.step_error / settings.fix_error_m * way_m
    return min(grown, settings.most_mistrust)


def after_fix(mistrust: float, trusted: bool, settings: TrustChainSettings) -> float:
    """TC after a fix was fused, Eq. 18."""
    return 0.0 if trusted else min(mistrust * (1.0 + mistrust), settings.most_mistrust)


def state_after(trust: Trust, mistrust: float, trusted: bool, settings: TrustChainSettings) -> Trust:
    """The state machine of figure 8, with the TC that weighs the fix: from 1 on it counts as much as the steps."""
    if trusted:
        return Trust.TRUSTED_LOCKED
    if trust is Trust.UNLOCKED or mistrust >= settings.unlocked_from:
        return Trust.UNLOCKED
    return Trust.LOCKED
