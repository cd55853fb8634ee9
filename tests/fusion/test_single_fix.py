"""What a radio map's quality report promises is what a phone is promised."""

from __future__ import annotations

import numpy as np
import pytest

from app.fusion.interface import SessionStart
from app.fusion.single_fix import single_fix_levels_m
from app.fusion.surefix import SUREFIX
from app.observations import Batch
from app.wifi.readings import fresh_readings
from app.wifi.soft_match import soft_match
from tests.fusion.walks import site, walked


@pytest.mark.parametrize("risk", [0.01, 0.05])
def test_the_level_of_a_match_is_that_of_a_session_whose_first_scan_it_is(risk: float) -> None:
    radio_map = site().radio_map
    assert radio_map is not None
    told, expected = [], []
    for scan in [scan for batch in walked(5).batches for scan in batch.wifi][::5]:
        fresh = fresh_readings(scan)
        match = soft_match(radio_map, fresh.bssid, fresh.rssi_dbm)
        assert match is not None
        only = Batch(0, scan.time_s, wifi=(scan,))
        _, fix = SUREFIX.advance(SUREFIX.start(SessionStart(alert_limit_m=50.0, risk=risk)), only, site())
        told.append(fix.integrity.protection_level_m)
        expected.append(single_fix_levels_m(radio_map, [match], risk)[0])
    # a cloud of 1,500 particles, a tenth of which begin at other places that the scan is like
    ratio = np.array(told) / np.array(expected)
    assert len(ratio) > 5
    assert np.median(ratio) == pytest.approx(1.0, abs=0.05)
