"""Levels of single WiFi fixes, before steps or other scans have helped: how good a radio map is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion.cloud_place import round_place
from app.fusion.surefix_settings import SurefixSettings
from app.wifi.fix_calibration import calibration_of
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap


def single_fix_levels_m(
    radio_map: RadioMap, matches: Sequence[Match], risk: float, settings: SurefixSettings | None = None
) -> FloatArray:
    """Protection level (n,) of each of n matches by itself: what `surefix` promises a session whose first scan it is,
    where no wall cuts off a part of the places it may be at."""
    settings, learnt = settings or SurefixSettings(), calibration_of(radio_map)
    weight = settings.distance_weight

    def level_m(match: Match) -> float:
        here = round_place(learnt.place_m(match), learnt.variance_m2(match, weight))
        return settings.level_m(here, weight * learnt.strange_m2(match), risk, learnt)

    return np.array([level_m(match) for match in matches], np.float64)
