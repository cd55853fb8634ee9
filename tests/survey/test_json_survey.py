from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.errors import InvalidInput, NotFound, TooLarge
from app.survey.json_survey import MOST_VALUES
from app.wifi.beacons import beacon_key
from tests.survey.surveys import json_survey, levels, reasons
from tests.survey.traces import mac

T = 1_700_000_000_000


def reading(number: int = 1, rssi: Any = -50, **more: Any) -> dict[str, Any]:
    return {"bssid": mac(number), "rssi": rssi, **more}


def place(*readings: Any, **changed: Any) -> dict[str, Any]:
    return {"x": 1.5, "y": 2, "t": T, "readings": list(readings) or [reading()], **changed}


def body(*fingerprints: Any, **changed: Any) -> bytes:
    return json.dumps({"floor": "F1", "fingerprints": list(fingerprints), **changed}).encode()


def test_fingerprints_are_read_in_order_with_device_and_place() -> None:
    sent = body(
        place(reading(1), reading(2, -60, frequency=2412)), place(x=3), device={"brand": "OPPO\0", "model": "X"}
    )
    found, notes = json_survey(sent)
    assert [(one.floor, one.x_m, one.y_m, one.time_s) for one in found] == [
        ("F1", 1.5, 2, T / 1e3),
        ("F1", 3, 2, T / 1e3),
    ]
    assert levels(found[0]) == {mac(1): -50, mac(2): -60}
    assert notes.device == {"brand": "OPPO", "model": "X"}


def test_members_may_come_in_any_order() -> None:
    sent = json.dumps({"fingerprints": [place()], "device": None, "floor": "F1"}).encode()
    assert len(json_survey(sent)[0]) == 1


@pytest.mark.parametrize(
    ("bad", "item", "reason"),
    [
        (place(x=None), "fingerprints[1]", "x must be a number"),
        (place(x=True), "fingerprints[1]", "x must be a number"),
        (place(x="1"), "fingerprints[1]", "x must be a number"),
        (place(x=500), "fingerprints[1]", "outside floor F1"),
        (place(t=1e40), "fingerprints[1]", "Unix milliseconds"),
        (place(x=10**400), "fingerprints[1]", "too large"),
        (place(readings=None), "fingerprints[1]", "readings must be a list"),
        (place(readings=[]), "fingerprints[1]", "no reading that can be used"),
        ("text", "fingerprints[1]", "a fingerprint is an object"),
        (None, "fingerprints[1]", "a fingerprint is an object"),
        (place(reading(1), reading(2, None)), "fingerprints[1].readings[1]", "rssi must be a number"),
        (place(reading(1), 7), "fingerprints[1].readings[1]", "a reading is an object"),
        (place(reading(1), {"bssid": "x", "rssi": -50}), "fingerprints[1].readings[1]", "not a MAC address"),
        (place(reading(1), reading(2, 99)), "fingerprints[1].readings[1]", "outside [-127, 20]"),
        (place(bluetooth=7), "fingerprints[1]", "bluetooth must be a list"),
        (place(bluetooth=[7]), "fingerprints[1].bluetooth[0]", "an object of id and rssi"),
        (place(bluetooth=[{"id": "a:1:2", "rssi": 99}]), "fingerprints[1].bluetooth[0]", "outside [-127, 20]"),
        (place(bluetooth=[{"id": "", "rssi": -60}]), "fingerprints[1].bluetooth[0]", "1 to 128 characters"),
    ],
)
def test_what_is_bad_is_rejected_by_its_path_and_the_rest_lands(bad: Any, item: str, reason: str) -> None:
    try:
        found, notes = json_survey(body(place(), bad, place(x=7)))
    except InvalidInput as error:  # numbers that no double holds end the parse
        assert "10000" in json.dumps(bad) and error.field == item
        return
    assert {1.5, 7.0} <= {one.x_m for one in found}
    assert list(reasons(notes)) == [item]
    assert reason in reasons(notes)[item]


def test_beacons_of_a_place_are_readings_of_its_fingerprint() -> None:
    heard = [{"id": "a:1:2", "rssi": -70}, {"id": "A:1:2", "rssi": -60, "tx_power": -59}]
    (both, alone), notes = json_survey(body(place(bluetooth=heard), place(readings=[], bluetooth=heard)))
    assert notes.rejections.count == 0
    assert both.bssid.tolist() == [int(mac(1).replace(":", ""), 16), beacon_key("a:1:2")]
    assert (alone.bssid.tolist(), alone.rssi_dbm.tolist()) == ([beacon_key("a:1:2")], [-60.0])


def test_networks_that_opted_out_are_dropped_without_a_word() -> None:
    found, notes = json_survey(body(place(reading(1, ssid="home_nomap"), reading(2, ssid="shop"))))
    assert [levels(one) for one in found] == [{mac(2): -50}]
    assert notes.rejections.count == 0


@pytest.mark.parametrize(
    ("sent", "field"),
    [
        (body(place(), floor=None), "floor"),
        (body(place(), floor=["F1"]), "floor"),
        (body(place(), colour=1), "colour"),
        (body(place(), device={"colour": 1}), "device"),
        (body(place(), device="phone"), "device"),
        (body(place(), device={"brand": 7}), "device.brand"),
        (b'{"floor":"F1"}', "fingerprints"),
        (b'{"floor":"F1","fingerprints":7}', "fingerprints"),
        (b"[]", ""),
        (b"7", ""),
        (b"", ""),
        (b"{", ""),
        (b"\xff\xfe", ""),
        (b"PK\x03\x04", ""),
        (body(place())[:-3], "fingerprints[0]"),
        (b'{"floor":"F1","fingerprints":[{"x":NaN}]}', "fingerprints[0]"),
        (body(place(), place(t=10**20)), "fingerprints[1]"),
        (body(place(readings=[reading(frequency=10**400)])), "fingerprints[0]"),
        (b"[" * 100_000, ""),
        (b'{"floor":"F1","fingerprints":[' + b'{"a":' * 100_000, ""),
    ],
)
def test_a_body_that_is_no_survey_is_refused_by_its_field(sent: bytes, field: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        json_survey(sent)
    assert refused.value.field == field


@pytest.mark.parametrize("number", ["1e400", "-1e400", "123456789012345678901234567890", "9" * 5000])
@pytest.mark.parametrize("place", ['"x":%s', '"x":1,"readings":[{"rssi":%s}]', '"unknown":[[%s]]'])
def test_a_number_beyond_64_bits_is_refused_by_its_fingerprint_with_the_remedy(number: str, place: str) -> None:
    good = '{"x":1,"y":2,"t":1,"readings":[]}'
    sent = f'{{"floor":"F1","fingerprints":[{good},{{{place % number}}},{good}]}}'
    with pytest.raises(
        InvalidInput, match=r"^fingerprints\[1\] holds .* correct the number or leave it out$"
    ) as refused:
        json_survey(sent.encode())
    assert refused.value.field == "fingerprints[1]"


def test_a_floor_that_the_venue_does_not_have_is_not_found() -> None:
    with pytest.raises(NotFound, match="it has B1, F1") as refused:
        json_survey(body(place(), floor="F9"))
    assert refused.value.field == "floor"


def test_a_fingerprint_that_would_not_fit_in_memory_is_refused_before_it_is_built() -> None:
    sent = body(place(), place(readings=[1] * (MOST_VALUES + 10)))
    with pytest.raises(TooLarge) as refused:
        json_survey(sent)
    assert refused.value.field == "fingerprints[1]"


VALUES = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["x", "y", "t", "readings", "bssid", "rssi", "z"]), inner, max_size=4)
    ),
    max_leaves=12,
)


@given(st.lists(VALUES, max_size=4))
def test_whatever_fingerprints_hold_a_good_one_lands_or_the_body_is_refused(values: list[Any]) -> None:
    try:
        found, _ = json_survey(body(place(), *values))
    except InvalidInput:
        return
    assert found[0].x_m == 1.5
