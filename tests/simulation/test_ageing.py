from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from app.estimation.arrays import BoolArray
from app.simulation.access_points import AccessPoints
from app.simulation.ageing import MOVED_A_MONTH, POWER_A_MONTH, REPLACED_A_MONTH, aged
from app.simulation.recording import World, make_world


@pytest.fixture(scope="module")
def mall() -> World:
    return make_world("ageing", "mall", 2, seed=4)


def _differs(now: AccessPoints, then: AccessPoints) -> BoolArray:
    """(r,) radios that are elsewhere, louder or fainter, or announce other addresses."""
    other_name = np.bincount(now.radio, now.bssid != then.bssid, len(now.level)) > 0
    moved = np.any(now.place_m != then.place_m, axis=1)
    return np.asarray(moved | other_name | (now.level_at_1m_dbm != then.level_at_1m_dbm))


def test_on_the_day_of_the_survey_nothing_has_changed(mall: World) -> None:
    now = aged(mall.access_points, 0.0, 1)
    assert now.changed == 0.0
    assert not _differs(now.access_points, mall.access_points).any()


def test_what_has_changed_stays_changed_as_months_go_by(mall: World) -> None:
    then = mall.access_points
    after = [aged(then, months, 1).access_points for months in (3.0, 12.0, 25.0)]
    changed = [_differs(now, then) for now in after]
    assert [int(one.sum()) for one in changed] == sorted(int(one.sum()) for one in changed)
    assert 0 < changed[0].sum() < changed[2].sum() < len(then.level)
    for sooner, later in pairwise(changed):
        assert not np.any(sooner & ~later)
    moved = np.any(after[0].place_m != then.place_m, axis=1)
    assert np.array_equal(after[0].place_m[moved], after[2].place_m[moved])


def test_the_share_that_changes_follows_from_the_monthly_rates(mall: World) -> None:
    shares = [aged(mall.access_points, 12.0, seed).changed for seed in range(20)]
    left = ((1.0 - REPLACED_A_MONTH) * (1.0 - MOVED_A_MONTH) * (1.0 - POWER_A_MONTH)) ** 12
    assert np.mean(shares) == pytest.approx(1.0 - left, abs=0.02)


def test_both_bands_of_an_access_point_change_together(mall: World) -> None:
    now = aged(mall.access_points, 12.0, 1).access_points
    assert np.array_equal(now.place_m[::2], now.place_m[1::2])
    differs = _differs(now, mall.access_points)
    assert np.array_equal(differs[::2], differs[1::2])


def test_a_radio_that_was_moved_sounds_otherwise_and_one_that_stayed_does_not(mall: World) -> None:
    then, floor = mall.access_points, mall.building.floors[0]
    now = aged(then, 12.0, 1).access_points
    here = np.tile([floor.width_m / 2, floor.height_m / 2], (len(then.level), 1))
    (near_then, dbm_then), (near_now, dbm_now) = (one.mean_dbm(floor, here) for one in (then, now))
    same = ~_differs(now, then) | (
        np.all(now.place_m == then.place_m, axis=1) & (now.level_at_1m_dbm == then.level_at_1m_dbm)
    )
    before, after = (
        dict(zip(near.tolist(), dbm.tolist(), strict=True))
        for near, dbm in ((near_then, dbm_then), (near_now, dbm_now))
    )
    for radio in set(before) & set(after):
        assert (before[radio] == after[radio]) == bool(same[radio])
