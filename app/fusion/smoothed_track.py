"""What a smoothed track answers at each moment, beside what was answered at the time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray
from app.integrity.protection_level import ACCURACY_SHARE, protection_level_m, radius_holding, tail_at

SHARE_THEN = 0.4
"""Of an answer that walls had a part in, in the smoothed place. Mall, folds 1-4: 0.3 to 0.5 are best."""


@dataclass(frozen=True, slots=True)
class KnownThen:
    """What a Fix said at the time.

    x_m, y_m, level_m : its place and protection level.  alert_limit_m : of the session.
    if2, if3 : whether a scan had just been left out, and whether there was a fault.
    floor_certain, unsurveyed_m2 : as of the Fix.
    walls : whether it kept to where a floor plan lets one walk.
    """

    x_m: float
    y_m: float
    level_m: float
    alert_limit_m: float
    if2: int = 0
    if3: int = 0
    floor_certain: bool = True
    unsurveyed_m2: float = 0.0
    walls: bool = False

    @property
    def contradicted(self) -> bool:
        """Whether scans spoke against it."""
        return bool(self.if2 or self.if3)


@dataclass(frozen=True, slots=True, eq=False)
class SmoothedAnswer:
    """xy_m : (2,).  covariance_m2 : (2, 2).  accuracy_m, level_m : the 68 % radius and the protection level."""

    xy_m: FloatArray
    covariance_m2: FloatArray
    accuracy_m: float
    level_m: float
    usable: bool


@dataclass(frozen=True, slots=True, eq=False)
class SmoothedTrack:
    """At each of n moments. time_s : (n,).  floor : names.  xy_m : (n, 2).  covariance_m2 : (n, 2, 2).
    heading_rad : (n,) walking direction, NaN where nothing tells it.

    contested_s : since when every fix up to the end has been at another place; None where the last word is agreed.
    contested_xy_m : (k, 2) those fixes.  contested_m2 : (k,) their variance in each direction.
    """

    time_s: FloatArray
    floor: list[str]
    xy_m: FloatArray
    covariance_m2: FloatArray
    heading_rad: FloatArray
    contested_s: float | None
    contested_xy_m: FloatArray
    contested_m2: FloatArray

    def answer(self, index: int, risk: float, known: KnownThen) -> SmoothedAnswer:
        """What is told of a moment in place of what was known then.

        Scans that are unlike the survey err alike, which the track knows as little as the cloud did (decision 0010).
        Where scans contradicted each other, or the track lies beyond what was promised at the time, one of two accounts
        of the walk is wrong: the level then reaches as far as the other's did. It also reaches contested fixes. Where
        the floor was uncertain the level stays what it was.
        """
        spread_m2, tail = self.covariance_m2[index] + known.unsurveyed_m2 * np.eye(2), tail_at(risk)
        accuracy_m = radius_holding(spread_m2, ACCURACY_SHARE)
        level_m = max(protection_level_m(spread_m2, risk, tail), accuracy_m)
        moved_m = math.hypot(known.x_m - self.xy_m[index, 0], known.y_m - self.xy_m[index, 1])
        if known.contradicted or moved_m > known.level_m:
            level_m = max(level_m, moved_m + known.level_m)
        if not known.floor_certain:
            level_m = max(level_m, known.level_m)
        if self.contested_s is not None and self.time_s[index] >= self.contested_s:
            apart_m = np.hypot(*(self.contested_xy_m - self.xy_m[index]).T)
            around_m = [protection_level_m(float(m2) * np.eye(2), risk, tail) for m2 in self.contested_m2]
            level_m = max(level_m, float(np.max(apart_m + around_m)))
        usable = not known.if3 and level_m <= known.alert_limit_m
        return SmoothedAnswer(self._place_m(index, known), spread_m2, accuracy_m, level_m, usable)

    def _place_m(self, index: int, known: KnownThen) -> FloatArray:
        """(2,) of the walker. The answer at the time knew of walls, the track knows what came after, and they err
        apart: what lies between errs less than either. Where they contradict each other the track is right."""
        then_m = np.array([known.x_m, known.y_m])
        apart_m = math.hypot(*(then_m - self.xy_m[index]))
        if not known.walls or known.contradicted or apart_m > known.level_m:
            return np.asarray(self.xy_m[index], np.float64)
        return np.asarray((1.0 - SHARE_THEN) * self.xy_m[index] + SHARE_THEN * then_m, np.float64)
