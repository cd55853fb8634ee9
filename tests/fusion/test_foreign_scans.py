"""Sessions whose scans hold access points of elsewhere."""

from __future__ import annotations

import numpy as np

from app.fusion.interface import Floor, SessionStart, Site
from app.fusion.surefix import SUREFIX
from app.observations import Batch, Fix, WifiScan
from tests.wifi.corridor import MAP, heard, mixed

SITE = Site({"F1": Floor("F1", 0, 200.0, 10.0)}, MAP)


def standing(count: int) -> list[Fix]:
    """A phone that stands at 50 m and hears, from its sixth scan on, so many loud access points of 150 m."""
    state, fixes = SUREFIX.start(SessionStart(alert_limit_m=20.0)), []
    for second in range(12):
        bssid, rssi_dbm = heard(50.0, seed=second) if second < 6 else mixed(50.0, 150.0, count)
        order, now_s = np.argsort(bssid), 2.0 * second
        scan = WifiScan(now_s, bssid[order], rssi_dbm[order], np.full(len(bssid), now_s))
        state, fix = SUREFIX.advance(state, Batch(second, end_s=now_s, wifi=(scan,)), SITE)
        fixes.append(fix)
    return fixes


def test_a_few_are_left_out_by_name_and_the_answer_stays_and_stays_usable() -> None:
    fixes = standing(8)
    for fix in fixes[6:]:
        assert fix.position is not None and abs(fix.position.x_m - 50.0) < 5.0 and fix.integrity.usable
        told = [one.bssid or 0 for one in fix.integrity.excluded]
        assert sorted(told) == sorted(mixed(50.0, 150.0, 8)[0][-8:].tolist())
    reasons = [{one.reason.split(":")[0] for one in fix.integrity.excluded} for fix in fixes]
    assert reasons[5] == set() and reasons[6] == {"foreign"} and reasons[-1] == {"moved"}


def test_many_that_belong_together_elsewhere_are_covered_by_the_level() -> None:
    fixes = standing(16)
    assert fixes[5].integrity.usable and not any(fix.integrity.usable for fix in fixes[6:])
    for fix in fixes[6:]:
        assert fix.position is not None and abs(fix.position.x_m - 50.0) < 5.0
        assert (fix.integrity.protection_level_m or 0.0) > 100.0


def test_scans_that_are_of_two_places_in_equal_parts_are_not_believed() -> None:
    fixes = standing(40)
    assert all(fix.position is not None and abs(fix.position.x_m - 50.0) < 5.0 for fix in fixes[5:])
