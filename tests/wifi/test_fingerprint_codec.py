from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.beacons import beacon_key
from app.wifi.fingerprint_codec import pack_readings, unpack_readings

READINGS = st.lists(st.tuples(st.integers(0, 2**48 - 1), st.floats(-127.0, 20.0)), max_size=50)


@given(READINGS)
def test_readings_come_back_in_their_order_to_a_hundredth_of_a_decibel(readings: list[tuple[int, float]]) -> None:
    bssid = np.array([one for one, _ in readings], np.int64)
    rssi_dbm = np.array([one for _, one in readings], np.float64)
    packed = pack_readings(bssid, rssi_dbm)
    assert len(packed) == 6 + 8 * len(readings)
    unpacked_bssid, unpacked_dbm = unpack_readings(packed)
    assert unpacked_bssid.tolist() == bssid.tolist()
    assert unpacked_dbm == pytest.approx(rssi_dbm, abs=0.00501)


@given(READINGS, st.lists(st.text(max_size=40), max_size=20))
def test_readings_of_beacons_come_back_beside_those_of_access_points(
    readings: list[tuple[int, float]], beacons: list[str]
) -> None:
    bssid = np.array([one for one, _ in readings] + [beacon_key(one) for one in beacons], np.int64)
    rssi_dbm = np.array([one for _, one in readings] + [-70.0] * len(beacons), np.float64)
    unpacked_bssid, unpacked_dbm = unpack_readings(pack_readings(bssid, rssi_dbm))
    assert unpacked_bssid.tolist() == bssid.tolist()
    assert unpacked_dbm == pytest.approx(rssi_dbm, abs=0.00501)


def test_whole_decibels_come_back_exactly() -> None:
    rssi_dbm = np.arange(-127.0, 21.0)
    assert unpack_readings(pack_readings(np.arange(148), rssi_dbm))[1].tolist() == rssi_dbm.tolist()


@pytest.mark.parametrize(
    ("bssid", "rssi_dbm"),
    [([1], [np.nan]), ([1], [1e9]), ([-1], [-50.0]), ([1 << 48], [-50.0]), ([1, 2], [-50.0]), ([[1]], [[-50.0]])],
)
def test_what_does_not_fit_is_refused(bssid: list[int], rssi_dbm: list[float]) -> None:
    with pytest.raises(ValueError, match="must be"):
        pack_readings(np.array(bssid, np.int64), np.array(rssi_dbm, np.float64))


def test_damaged_or_foreign_bytes_are_refused() -> None:
    packed = pack_readings(np.array([7, 8]), np.array([-40.0, -50.0]))
    beacon = pack_readings(np.array([7, beacon_key("a")]), np.array([-40.0, -50.0]))
    for damaged in (beacon[:-1], beacon + b"\0", beacon[:1] + b"\0" + beacon[2:]):
        with pytest.raises(ValueError, match="packed readings"):
            unpack_readings(damaged)
    for damaged in (b"", packed[:-1], packed + b"\0", b"\2" + packed[1:], packed[:1] + b"\1" + packed[2:]):
        with pytest.raises(ValueError, match="packed readings"):
            unpack_readings(damaged)
