"""Levels of single WiFi fixes, before steps or other scans have helped: how good a radio map is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion.surefix_settings import SurefixSettings
from app.integrity.protection_level import protection_level_m, tail_at
from app.wifi.fix_calibration import calibration_of
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap


def single_fix_levels_m(
    radio_map: RadioMap, matches: Sequence[Match], risk: float, settings: SurefixSettings | None = None
) -> FloatArray:
    """Protection level (n,) of each of n matches by itself: the variance that `surefix` gives it, with WIFI_TAILS.

    A session's first answer promises about as much, by tails and a least radius of its own.
    """
    settings = settings or SurefixSettings()
    calibration, tail = calibration_of(radio_map), tail_at(risk)
    variances_m2 = (calibration.variance_m2(match, settings.distance_weight) for match in matches)
    levels_m = [protection_level_m(one * np.eye(2), risk, tail) for one in variances_m2]
    return np.array(levels_m, np.float64)
