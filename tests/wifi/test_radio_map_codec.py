"""A stored radio map is the map, or is refused."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.beacons import MARK
from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import calibrated_map
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.radio_map_codec import MAGIC, DamagedRadioMapError, decode_radio_map, encode_radio_map
from tests.wifi.surveys import corridor, fingerprints


def assert_same(one: RadioMap, other: RadioMap) -> None:
    for name in (field.name for field in fields(RadioMap) if field.name not in ("sections", "beacons")):
        left, right = getattr(one, name), getattr(other, name)
        assert np.array_equal(left, right)
        assert getattr(left, "dtype", None) == getattr(right, "dtype", None)
    assert sorted(one.sections) == sorted(other.sections)
    assert all(np.array_equal(array, other.sections[name]) for name, array in one.sections.items())
    assert (one.beacons is None) == (other.beacons is None)
    if one.beacons is not None and other.beacons is not None:
        assert_same(one.beacons, other.beacons)


@given(survey=fingerprints(least=0), version=st.integers(0, 10**6))
def test_a_map_comes_back_as_it_was(survey: list[Fingerprint], version: int) -> None:
    radio_map = build_radio_map(survey, version)
    assert_same(decode_radio_map(encode_radio_map(radio_map)), radio_map)


@given(survey=fingerprints(least=0), heard=fingerprints(least=0))
def test_the_map_of_beacons_comes_back_with_it(survey: list[Fingerprint], heard: list[Fingerprint]) -> None:
    radio_map = calibrated_map(survey + [replace(one, bssid=one.bssid + MARK) for one in heard])
    assert (radio_map.beacons is None) == (not heard)
    assert_same(decode_radio_map(encode_radio_map(radio_map)), radio_map)


def test_a_map_of_beacons_with_other_floors_is_refused() -> None:
    radio_map = replace(build_radio_map(corridor()), beacons=build_radio_map(corridor(floors=("B1",))))
    with pytest.raises(DamagedRadioMapError, match="different floors"):
        decode_radio_map(encode_radio_map(radio_map))


def test_further_sections_come_back() -> None:
    sections = {"field/mean": np.arange(6, dtype=np.float32).reshape(2, 3), "levels": np.array([0.5, 0.99])}
    radio_map = replace(build_radio_map(corridor()), sections=sections)
    assert_same(decode_radio_map(encode_radio_map(radio_map)), radio_map)


def test_a_section_that_is_not_numbers_is_refused() -> None:
    radio_map = replace(build_radio_map([]), sections={"names": np.array(["a"], dtype=object)})
    with pytest.raises(ValueError, match="names"):
        encode_radio_map(radio_map)


@pytest.mark.parametrize("body", [b"", b"SFRM", MAGIC, b"SFRM\x02" + bytes(40), b"PK\x03\x04" + bytes(40)])
def test_other_bytes_are_refused(body: bytes) -> None:
    with pytest.raises(DamagedRadioMapError):
        decode_radio_map(body)


@given(data=st.data())
def test_a_changed_or_missing_byte_is_noticed(data: st.DataObject) -> None:
    body = bytearray(encode_radio_map(build_radio_map(corridor(repeats=1))))
    at = data.draw(st.integers(0, len(body) - 1))
    if data.draw(st.booleans()):
        del body[at:]
    else:
        body[at] ^= data.draw(st.integers(1, 255))
    try:
        decoded = decode_radio_map(bytes(body))
    except DamagedRadioMapError:
        return
    assert_same(decoded, build_radio_map(corridor(repeats=1)))  # a bit of the frame's header that says nothing


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("point", 10**6, "point is out of range"),
        ("point", -1, "point is out of range"),
        ("floor", 7, "floor is out of range"),
        ("count", 0, "count is out of range"),
        ("start", 10**6, "out of order"),
        ("bssid", -5, "out of order"),
        ("mean_dbm", np.nan, "not finite"),
        ("xy_m", np.inf, "not finite"),
    ],
)
def test_arrays_that_do_not_fit_each_other_are_refused(name: str, value: float, said: str) -> None:
    radio_map = build_radio_map(corridor(repeats=1))
    array = getattr(radio_map, name).copy()
    array.reshape(-1)[-1] = value
    with pytest.raises(DamagedRadioMapError, match=said):
        decode_radio_map(encode_radio_map(replace(radio_map, **{name: array})))


def test_arrays_of_different_length_are_refused() -> None:
    radio_map = build_radio_map(corridor(repeats=1))
    shorter = replace(radio_map, mean_dbm=radio_map.mean_dbm[:-1])
    with pytest.raises(DamagedRadioMapError, match="differ in length"):
        decode_radio_map(encode_radio_map(shorter))


@pytest.mark.parametrize("table", [b"{}", b"[]", b'{"version":1,"floors":[],"arrays":[{}],"sections":[]}', b"\xff"])
def test_a_table_of_contents_of_another_kind_is_refused(table: bytes) -> None:
    content = len(table).to_bytes(4, "little") + table
    with pytest.raises(DamagedRadioMapError, match="table of contents"):
        decode_radio_map(MAGIC + zstandard.compress(content))
