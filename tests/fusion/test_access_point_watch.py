"""Access points that are not as surveyed: found on a walk, left out, reported, and used again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from app.fusion.access_point_watch import AccessPointWatch, AccessPointWatchSettings, excluded, trusted
from app.fusion.interface import SessionStart, Site
from app.fusion.methods import METHODS
from app.fusion.state_codec import decode_state, encode_state
from app.integrity.access_point_record import nothing_recorded
from app.observations import Batch, Excluded, Fix, WifiScan
from app.services.watch_lists import REASONS
from tests.fusion.walks import Walked, errors_m, run, site, walked

SUREFIX = METHODS["surefix"]
WALK = walked(5, length_m=120.0)
SETTINGS = AccessPointWatchSettings()
Change = Callable[[WifiScan], WifiScan]


def _changed(change: Change, begin: float = 0.0, end: float = 1.0) -> list[Batch]:
    """The walk whose scans from one share of it to another are changed."""
    first, last = (int(share * len(WALK.batches)) for share in (begin, end))
    return [
        replace(batch, wifi=tuple(map(change, batch.wifi))) if first <= number < last else batch
        for number, batch in enumerate(WALK.batches)
    ]


def _by_loudness() -> list[int]:
    """Access points that the walk hears, those of the most and loudest readings first."""
    heard: dict[int, float] = {}
    for batch in WALK.batches:
        for scan in batch.wifi:
            for one, level_dbm in zip(scan.bssid.tolist(), scan.rssi_dbm.tolist(), strict=True):
                heard[one] = heard.get(one, 0.0) + level_dbm + 100.0
    return sorted(heard, key=lambda one: -heard[one])


def _silenced(*gone: int) -> Change:
    def change(scan: WifiScan) -> WifiScan:
        kept = ~np.isin(scan.bssid, gone)
        return WifiScan(scan.time_s, scan.bssid[kept], scan.rssi_dbm[kept], scan.seen_s[kept])

    return change


def _imitated(*loud: int) -> Change:
    def change(scan: WifiScan) -> WifiScan:
        others = _silenced(*loud)(scan)
        return WifiScan(
            scan.time_s,
            np.concatenate([others.bssid, np.array(loud, np.int64)]),
            np.concatenate([others.rssi_dbm, np.full(len(loud), -42.0)]),
            np.concatenate([others.seen_s, np.full(len(loud), scan.time_s)]),
        )

    return change


def _reported(fix: Fix) -> dict[int, str]:
    return {one.bssid: one.reason.split(":")[0] for one in fix.integrity.excluded if one.bssid is not None}


def _ever(fixes: list[Fix], walk: Walked = WALK) -> dict[int, str]:
    """What was ever left out, without what was off the air during the simulated walk: that is rightly `vanished`."""
    heard = {one for batch in walk.batches for scan in batch.wifi for one in scan.bssid.tolist()}
    told = {bssid: reason for fix in fixes for bssid, reason in _reported(fix).items()}
    assert all(told[one] == "vanished" for one in told.keys() - heard)
    return {bssid: reason for bssid, reason in told.items() if bssid in heard}


@pytest.mark.parametrize("seed", [5, 6, 7, 8])
def test_in_a_building_as_surveyed_next_to_nothing_that_can_be_heard_is_left_out(seed: int) -> None:
    heard = {one for batch in walked(seed).batches for scan in batch.wifi for one in scan.bssid.tolist()}
    assert len(_ever(run(SUREFIX, walked(seed).batches), walked(seed))) < 0.02 * len(heard)


def test_one_that_is_gone_is_reported_as_vanished_and_no_other_is() -> None:
    gone = _by_loudness()[0]
    assert _ever(run(SUREFIX, _changed(_silenced(gone)))) == {gone: "vanished"}


def test_one_that_is_imitated_is_reported_left_out_and_costs_no_accuracy() -> None:
    loud = _by_loudness()[-1]
    fixes = run(SUREFIX, _changed(_imitated(loud)))
    assert set(_ever(fixes)) == {loud}
    assert _reported(fixes[-1])[loud] in REASONS
    clean = run(SUREFIX, WALK.batches)
    half = len(fixes) // 2
    assert np.mean(errors_m(WALK, fixes[half:])) < np.mean(errors_m(WALK, clean[half:])) + 0.5


def test_one_that_is_as_surveyed_again_is_used_again() -> None:
    gone = _by_loudness()[0]
    fixes = run(SUREFIX, _changed(_silenced(gone), end=0.5))
    assert gone in _ever(fixes)
    assert gone not in _reported(fixes[-1])


def test_what_is_left_out_is_gone_from_the_scan_that_is_matched() -> None:
    batches = _changed(_imitated(_by_loudness()[-1]))
    state = SUREFIX.start(SessionStart())
    for batch in batches:
        state, _ = SUREFIX.advance(state, batch, site())
    scan = next(scan for batch in reversed(batches) for scan in batch.wifi)
    _, kept = trusted(state.watch, scan, site(), SETTINGS)
    assert set(scan.bssid.tolist()) - set(kept.bssid.tolist()) == {_by_loudness()[-1]}
    assert len(kept.bssid) == len(kept.rssi_dbm) == len(kept.seen_s)


def test_never_more_than_a_third_of_a_scan_is_left_out() -> None:
    scan = next(scan for batch in WALK.batches for scan in batch.wifi)
    bssid = np.sort(scan.bssid)
    nothing = nothing_recorded()
    counts, levels = np.ones(len(bssid), np.int64), np.linspace(12.0, 18.0, len(bssid))
    all_wrong = replace(
        nothing,
        bssid=bssid,
        score=levels,
        excluded=np.ones(len(bssid), np.bool_),
        misfits=counts,
        misses=counts,
        fits=counts,
        readings=counts,
        partner=counts,
        votes=counts,
        level_dbm=levels,
        level_square_db2=levels,
        reach_m=levels,
        begun_xy_m=np.zeros((len(bssid), 2)),
    )
    _, kept = trusted(AccessPointWatch(all_wrong), scan, site(), SETTINGS)
    known = site().radio_map
    assert known is not None
    assert len(scan.bssid) - len(kept.bssid) == int(np.isin(scan.bssid, known.bssid).sum() / 3)
    assert set(scan.bssid.tolist()) - set(kept.bssid.tolist()) == set(bssid[-(len(scan.bssid) - len(kept.bssid)) :])


def test_scans_of_another_place_leave_no_access_point_out() -> None:
    far = [scan for batch in walked(7).batches for scan in batch.wifi][::-1]
    at = iter(range(10**6))

    def relayed(scan: WifiScan) -> WifiScan:
        other = far[next(at) % len(far)]
        return WifiScan(scan.time_s, other.bssid, other.rssi_dbm, np.full(len(other.bssid), scan.time_s))

    fixes = run(SUREFIX, _changed(relayed, begin=0.5))
    most = max(len(_reported(fix)) for fix in fixes)
    heard = min(len(scan.bssid) for scan in far)
    assert most <= heard / 3


def test_listed_ones_are_reported_as_watched_which_no_watch_list_takes_up() -> None:
    scan = next(scan for batch in WALK.batches for scan in batch.wifi)
    listed = frozenset(scan.bssid[:2].tolist())
    watching = Site(site().floors, site().radio_map, listed)
    watch, kept = trusted(AccessPointWatch(), scan, watching, SETTINGS)
    assert not listed & set(kept.bssid.tolist())
    told = excluded(watch, SETTINGS)
    assert {one.bssid for one in told} == listed
    assert {one.reason.split()[0].rstrip(":,;") for one in told} == {"watched"}
    assert "watched" not in REASONS
    fixes = run(SUREFIX, WALK.batches, watching)
    assert all(one.reason.startswith("watched") for fix in fixes for one in _points(fix) if one.bssid in listed)


def test_reports_of_scans_and_of_access_points_stand_side_by_side() -> None:
    scan = next(scan for batch in WALK.batches for scan in batch.wifi)
    watching = Site(site().floors, site().radio_map, frozenset(scan.bssid[:1].tolist()))
    shifted = WALK.batches[-1]
    far = [scan for batch in walked(7).batches for scan in batch.wifi]
    batches = list(WALK.batches[:30])
    fixes = run(SUREFIX, batches, watching)
    assert any(_points(fix) for fix in fixes)
    jump = replace(
        shifted,
        wifi=(
            WifiScan(
                shifted.end_s or 0.0,
                far[-1].bssid,
                far[-1].rssi_dbm,
                np.full(len(far[-1].bssid), shifted.end_s or 0.0),
            ),
        ),
    )
    state = SUREFIX.start(SessionStart())
    for batch in (*batches, jump):
        state, fix = SUREFIX.advance(state, batch, watching)
    told = fix.integrity.excluded
    outlier = [one for one in told if one.observation == "wifi"]
    assert told[: len(outlier)] == tuple(outlier)


def test_what_is_known_survives_the_store_and_goes_on_as_if_it_had_not_been_stored() -> None:
    batches = _changed(_silenced(*_by_loudness()[:2]))
    straight = stored = SUREFIX.start(SessionStart())
    for batch in batches:
        straight, one = SUREFIX.advance(straight, batch, site())
        stored, other = SUREFIX.advance(decode_state(encode_state(stored)), batch, site())
        assert one.integrity.excluded == other.integrity.excluded
    assert len(straight.watch.record.bssid) > 0


def _points(fix: Fix) -> list[Excluded]:
    return [one for one in fix.integrity.excluded if one.bssid is not None]
