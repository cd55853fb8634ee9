from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.integrity.access_point_faults import FaultEvidenceSettings, ScanBesideMap, ScanEvidence, scan_evidence

SETTINGS = FaultEvidenceSettings()
COUNT = 30


def _as_surveyed(seed: int = 1, offset_db: float = 0.0) -> ScanBesideMap:
    """Thirty access points, each heard by all of ten survey scans around, and now as it was then."""
    rng = np.random.default_rng(seed)
    mean_dbm = rng.uniform(-75.0, -45.0, COUNT)
    return ScanBesideMap(
        bssid=np.arange(COUNT),
        rssi_dbm=mean_dbm + rng.normal(0.0, 3.0, COUNT) + offset_db,
        held=np.ones(COUNT, np.bool_),
        scans=10.0,
        heard=np.full(COUNT, 10.0),
        mean_dbm=mean_dbm,
        spread_db=np.full(COUNT, 4.0),
    )


def _weighed(scan: ScanBesideMap) -> ScanEvidence:
    found = scan_evidence(scan, SETTINGS)
    assert found is not None
    return found


def _with(scan: ScanBesideMap, at: int, rssi_dbm: float) -> ScanBesideMap:
    readings, held = scan.rssi_dbm.copy(), scan.held.copy()
    readings[at], held[at] = rssi_dbm, np.isfinite(rssi_dbm)
    return replace(scan, rssi_dbm=readings, held=held)


@given(st.integers(0, 1000), st.floats(-15.0, 15.0))
def test_a_scan_as_surveyed_speaks_for_every_access_point_whatever_the_phone_adds(seed: int, offset_db: float) -> None:
    evidence = _weighed(_as_surveyed(seed, offset_db)).evidence
    assert np.median(evidence) < -1.0
    assert np.count_nonzero(evidence > SETTINGS.suspicious) <= 1


@given(st.integers(0, 1000), st.integers(0, COUNT - 1), st.sampled_from([-35.0, 35.0]))
def test_a_level_that_is_far_off_speaks_against_the_access_point_that_has_it(seed: int, at: int, off_db: float) -> None:
    scan = _as_surveyed(seed)
    evidence = _weighed(_with(scan, at, scan.mean_dbm[at] + off_db)).evidence
    assert evidence[at] > SETTINGS.suspicious
    assert evidence.argmax() == at


def test_one_heard_loud_where_the_survey_never_heard_it_is_suspicious_and_a_faint_one_less() -> None:
    scan = _as_surveyed()
    heard, mean_dbm, spread_db = scan.heard.copy(), scan.mean_dbm.copy(), scan.spread_db.copy()
    heard[4] = mean_dbm[4] = spread_db[4] = 0.0
    unheard = replace(scan, heard=heard, mean_dbm=mean_dbm, spread_db=spread_db)
    loud, faint = (_weighed(_with(unheard, 4, level_dbm)).evidence[4] for level_dbm in (-50.0, -88.0))
    assert loud == SETTINGS.most_evidence
    assert faint < loud
    assert np.isnan(_weighed(_with(unheard, 4, -50.0)).expected_db[4])


def test_one_that_is_missing_where_it_was_always_heard_is_suspicious_and_one_at_the_edge_of_hearing_is_not() -> None:
    scan = _as_surveyed()
    mean_dbm = scan.mean_dbm.copy()
    mean_dbm[[2, 3]] = -55.0, -92.0
    silent = _with(_with(replace(scan, mean_dbm=mean_dbm), 2, np.nan), 3, np.nan)
    found = _weighed(silent)
    assert found.evidence[2] > SETTINGS.suspicious and found.judged[2]
    assert found.evidence[3] < SETTINGS.suspicious and not found.judged[3]


def test_an_old_reading_says_nothing() -> None:
    scan = _as_surveyed()
    readings = scan.rssi_dbm.copy()
    readings[5] = np.nan
    assert _weighed(replace(scan, rssi_dbm=readings)).evidence[5] == 0.0


def test_a_phone_that_hears_half_of_all_makes_none_of_them_missing() -> None:
    scan = _as_surveyed()
    for at in range(0, COUNT, 2):
        scan = _with(scan, at, np.nan)
    assert not (_weighed(scan).evidence[::2] > SETTINGS.suspicious).any()


def test_a_scan_of_another_place_is_suspicious_as_a_whole() -> None:
    scan = _as_surveyed()
    elsewhere = replace(scan, heard=np.roll(np.repeat([0.0, 10.0], COUNT // 2), 3))
    assert _weighed(elsewhere).suspicious > SETTINGS.position_wrong
    assert _weighed(scan).suspicious < 0.1


def test_where_little_is_surveyed_or_heard_nothing_is_said() -> None:
    scan = _as_surveyed()
    assert scan_evidence(replace(scan, scans=2.0), SETTINGS) is None
    deaf = replace(scan, rssi_dbm=np.full(COUNT, np.nan), held=np.zeros(COUNT, np.bool_))
    assert scan_evidence(deaf, SETTINGS) is None


@given(st.lists(st.one_of(st.just(float("nan")), st.floats(-110.0, -7.0)), min_size=COUNT, max_size=COUNT))
def test_evidence_is_finite_and_bounded_whatever_is_heard(levels: list[float]) -> None:
    readings = np.array(levels)
    found = scan_evidence(replace(_as_surveyed(), rssi_dbm=readings, held=np.isfinite(readings)), SETTINGS)
    if found is not None:
        assert np.all(np.abs(found.evidence) <= SETTINGS.most_evidence)
        assert 0.0 <= found.suspicious <= 1.0


def test_what_is_heard_as_surveyed_is_confirmed_and_what_is_off_or_silent_is_not() -> None:
    scan = _as_surveyed()
    found = _weighed(_with(_with(scan, 3, scan.mean_dbm[3] + 35.0), 5, np.nan))
    assert np.flatnonzero(~found.confirmed).tolist()[:1] == [3]
    assert not found.confirmed[5] and found.confirmed.sum() >= COUNT - 4
