from __future__ import annotations

import json
import math
import struct
from typing import Any

import numpy as np
import ormsgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.api.batch_body import parse_batch
from app.api.decoding import Packing
from app.errors import InvalidInput, TooLarge
from app.observations import Batch

T0 = 1_573_190_000_000
AXES = ("accelerometer", "gyroscope", "magnetometer", "rotation_vector")


def columns(n: int = 20, start: int = T0, value: float = 0.5) -> dict[str, Any]:
    return {"t": [start + 10 * i for i in range(n)], **{axis: [value] * n for axis in "xyz"}}


def parsed(body: Any) -> Batch:
    """The batch, after making sure that both layouts give the same."""
    batch = parse_batch(json.dumps(body).encode(), Packing.JSON)
    packed = parse_batch(ormsgpack.packb(body), Packing.MSGPACK)
    assert packed.end_s == batch.end_s and packed.dropped == batch.dropped and packed.sequence == batch.sequence
    np.testing.assert_array_equal(packed.accelerometer.values, batch.accelerometer.values)
    return batch


def refused(body: Any) -> str:
    """The field that the refusal names."""
    fields = set()
    for sent, packing in ((json.dumps(body).encode(), Packing.JSON), (ormsgpack.packb(body), Packing.MSGPACK)):
        with pytest.raises(InvalidInput) as refusal:
            parse_batch(sent, packing)
        fields.add(refusal.value.field)
    (field,) = fields
    return field


def readings(*given: dict[str, Any]) -> dict[str, Any]:
    return {"sequence": 0, "wifi": [{"t": T0, "readings": list(given)}]}


def test_columns_become_rows_in_seconds() -> None:
    batch = parsed({"sequence": 3, "accelerometer": {"t": [T0, T0 + 20], "x": [1, 2], "y": [3, 4], "z": [5, 6.5]}})
    np.testing.assert_allclose(batch.accelerometer.time_s, [T0 / 1000, T0 / 1000 + 0.02])
    np.testing.assert_array_equal(batch.accelerometer.values, [[1, 3, 5], [2, 4, 6.5]])
    assert batch.accelerometer.values.flags.c_contiguous
    assert batch.sequence == 3


def test_the_end_is_the_newest_sample_of_any_stream_unless_given() -> None:
    body = {"sequence": 0, "gyroscope": columns(5), "wifi": [{"t": T0 + 700, "readings": []}]}
    assert parsed(body).end_s == (T0 + 700) / 1000
    assert parsed({**body, "end": T0 + 1000}).end_s == (T0 + 1000) / 1000


@pytest.mark.parametrize("body", [{}, {"accelerometer": None, "wifi": None}, {"gyroscope": columns(0)}, {"future": 1}])
def test_a_batch_may_be_empty_and_unknown_fields_are_ignored(body: dict[str, Any]) -> None:
    batch = parsed({"sequence": 0, **body})
    assert batch.end_s is None
    assert batch.gyroscope.values.shape == (0, 3)


@pytest.mark.parametrize("kind", ["<f8", "<f4"])
def test_packed_columns_are_read_as_float64_or_float32(kind: str) -> None:
    values = np.arange(6, dtype=kind)
    times = np.arange(T0, T0 + 6, dtype="<f8").tobytes()
    stream = {"t": times, "x": values.tobytes(), "y": values.tolist(), "z": values.tobytes()}
    barometer = {"t": times, "pressure": (1000 + values).tobytes()}
    batch = parse_batch(
        ormsgpack.packb({"sequence": 1, "magnetometer": stream, "barometer": barometer}), Packing.MSGPACK
    )
    np.testing.assert_array_equal(batch.magnetometer.values, np.repeat(np.arange(6.0), 3).reshape(6, 3))
    np.testing.assert_array_equal(batch.barometer.pressure_hpa, 1000 + np.arange(6.0))


@pytest.mark.parametrize(
    ("column", "sent", "field"),
    [
        ("x", b"\0" * 7, "gyroscope.x"),
        ("t", b"\0" * 12, "gyroscope.t"),
        ("z", struct.pack("<2d", 0.0, math.nan), "gyroscope.z[1]"),
        ("t", struct.pack("<2d", T0, T0 - 1), "gyroscope.t[1]"),
    ],
)
def test_a_damaged_packed_column_is_named(column: str, sent: bytes, field: str) -> None:
    stream = {**columns(2), column: sent}
    with pytest.raises(InvalidInput) as refusal:
        parse_batch(ormsgpack.packb({"sequence": 0, "gyroscope": stream}), Packing.MSGPACK)
    assert refusal.value.field == field


@pytest.mark.parametrize("stream", AXES)
@pytest.mark.parametrize("axis", "txyz")
@pytest.mark.parametrize("value", ["1", None, True, [], {}, 1e308, -1e308])
def test_a_value_of_the_wrong_type_or_size_is_named_with_its_index(stream: str, axis: str, value: Any) -> None:
    body: dict[str, Any] = {"sequence": 0, stream: columns()}
    body[stream][axis][7] = value
    assert refused(body) == f"{stream}.{axis}[7]"


@pytest.mark.parametrize("word", ["NaN", "Infinity", "-Infinity", "1e999"])
@pytest.mark.parametrize("axis", "txyz")
def test_numbers_that_are_not_finite_are_named(word: str, axis: str) -> None:
    sent = json.dumps({"sequence": 0, "accelerometer": {**columns(3), axis: [1, 1, "?"]}}).replace('"?"', word)
    with pytest.raises(InvalidInput) as refusal:
        parse_batch(sent.encode(), Packing.JSON)
    assert refusal.value.field == f"accelerometer.{axis}[2]"


@given(st.sampled_from(AXES), st.sampled_from("xyz"), st.integers(0, 40))
def test_columns_of_unequal_length_are_named(stream: str, axis: str, length: int) -> None:
    body = {"sequence": 0, stream: {**columns(20), axis: [0.1] * length}}
    if length == 20:
        parsed(body)
    else:
        assert refused(body) == f"{stream}.{axis}"


@given(st.integers(1, 19), st.integers(1, 10**6))
def test_time_that_runs_backwards_is_named(index: int, back_ms: int) -> None:
    stream = columns(20)
    times = stream["t"]
    times[index] = times[index - 1] - back_ms
    assert refused({"sequence": 0, "magnetometer": stream}) == f"magnetometer.t[{index}]"


def test_scans_out_of_order_are_named() -> None:
    scans = [{"t": T0 + 5, "readings": []}, {"t": T0, "readings": []}]
    assert refused({"sequence": 0, "wifi": scans}) == "wifi[1].t"
    assert refused({"sequence": 0, "bluetooth": scans}) == "bluetooth[1].t"


@pytest.mark.parametrize("hours", [-3, 3])
def test_a_sample_hours_away_from_its_stream_is_named(hours: int) -> None:
    stream = columns(20)
    if hours > 0:
        stream["t"][19] += hours * 3_600_000
    else:
        stream["t"][0] += hours * 3_600_000
    assert refused({"sequence": 0, "gyroscope": stream}) == f"gyroscope.t[{19 if hours > 0 else 1}]"


@pytest.mark.parametrize("hours", [-3, 3])
def test_a_stream_hours_away_from_the_others_is_named(hours: int) -> None:
    away = columns(20, T0 + hours * 3_600_000)
    body = {"sequence": 0, "accelerometer": columns(), "gyroscope": columns(), "magnetometer": away}
    assert refused(body) == "magnetometer.t"


def test_an_end_before_or_hours_after_the_samples_is_named() -> None:
    body = {"sequence": 0, "gyroscope": columns(20)}
    assert refused({**body, "end": T0 + 189}) == "end"
    assert refused({**body, "end": T0 + 7_200_000}) == "end"
    assert parsed({**body, "end": T0 + 190}).end_s == (T0 + 190) / 1000


@pytest.mark.parametrize(
    ("stream", "value"),
    [("accelerometer", 401), ("gyroscope", -101), ("magnetometer", 10001), ("rotation_vector", 1.1)],
)
def test_implausible_values_are_named(stream: str, value: float) -> None:
    body = {"sequence": 0, stream: columns()}
    body[stream]["y"][4] = value  # type: ignore[index]
    assert refused(body) == f"{stream}.y[4]"


def test_a_rotation_vector_longer_than_a_unit_quaternion_is_refused() -> None:
    assert refused({"sequence": 0, "rotation_vector": columns(value=0.9)}) == "rotation_vector.x[0]"


@given(st.binary(min_size=1, max_size=20), st.integers(1, 60))
def test_a_packed_body_that_is_cut_short_or_followed_by_anything_is_refused(more: bytes, less: int) -> None:
    whole = ormsgpack.packb({"sequence": 1, "end": T0, "barometer": {"t": [], "pressure": []}})
    for sent in (whole + more, whole + whole, whole[:-less]):
        with pytest.raises(InvalidInput, match="MessagePack") as refusal:
            parse_batch(sent, Packing.MSGPACK)
        assert refusal.value.field == ""


@given(st.lists(st.floats(100, 1200) | st.sampled_from([0, 99, 1201, -5, 1e308, 2**63])))
def test_a_pressure_of_no_air_is_dropped_and_counted(pressure: list[float]) -> None:
    times = [T0 + index for index in range(len(pressure))]
    batch = parsed({"sequence": 0, "barometer": {"t": times, "pressure": pressure}})
    kept = [(time / 1000, value) for time, value in zip(times, pressure, strict=True) if 100 <= value <= 1200]
    assert list(zip(batch.barometer.time_s, batch.barometer.pressure_hpa, strict=True)) == kept
    assert batch.dropped == len(pressure) - len(kept)
    assert batch.end_s == (times[-1] / 1000 if times else None)


@pytest.mark.parametrize("sequence", [-1, 2**31, 2**80, 1.5, "1", True, None])
def test_a_sequence_is_a_whole_number_from_zero(sequence: Any) -> None:
    sent = json.dumps({"sequence": sequence}).encode()
    with pytest.raises(InvalidInput) as refusal:
        parse_batch(sent, Packing.JSON)
    assert refusal.value.field == "sequence"


def test_a_batch_without_sequence_is_refused() -> None:
    assert refused({"end": T0}) == "sequence"


@pytest.mark.parametrize("bssid", ["a8:0c:ca:03:9d:d7", "A8-0C-CA-03-9D-D7", "a80cca039dd7"])
def test_an_address_is_read_however_a_phone_writes_it(bssid: str) -> None:
    (scan,) = parsed(readings({"bssid": bssid, "rssi": -49})).wifi
    assert scan.bssid.tolist() == [0xA80CCA039DD7]


@pytest.mark.parametrize(
    "bssid", ["", "a8:0c", "a8:0c:ca-03:9d:d7", "zz:0c:ca:03:9d:d7", "\0", "é" * 17, None, 5, [1], {}]
)
def test_a_reading_without_a_usable_address_is_dropped_and_counted(bssid: Any) -> None:
    batch = parsed(readings({"bssid": bssid, "rssi": -49}, {"rssi": -49}, {"bssid": "a8:0c:ca:03:9d:d7", "rssi": -49}))
    assert batch.dropped == 2
    assert batch.wifi[0].bssid.size == 1


def test_half_a_character_costs_its_reading_and_not_the_batch() -> None:
    sent = b'{"sequence": 3, "wifi": [{"t": 1573190000000, "readings": [{"bssid": "\\ud800", "rssi": -49},'
    sent += b' {"bssid": "a8:0c:ca:03:9d:d7", "ssid": "\\udfff", "rssi": -50}]}]}'
    batch = parse_batch(sent, Packing.JSON)
    assert (batch.sequence, batch.dropped, batch.wifi[0].bssid.size) == (3, 1, 1)
    with pytest.raises(InvalidInput, match="finite"):
        parse_batch(
            b'{"sequence": 0, "\\ud800": 1, "accelerometer": {"t": [NaN], "x": [0], "y": [0], "z": [0]}}', Packing.JSON
        )
    with pytest.raises(InvalidInput):
        parse_batch(b'["\\ud800"' + b"[" * 100_000, Packing.JSON)


@pytest.mark.parametrize(("rssi", "dropped"), [(-127, 0), (20, 0), (-127.1, 1), (21, 1), (1e308, 1), (-1e308, 1)])
def test_a_reading_beyond_what_radios_report_is_dropped_and_counted(rssi: float, dropped: int) -> None:
    assert parsed(readings({"bssid": "a8:0c:ca:03:9d:d7", "rssi": rssi})).dropped == dropped


@pytest.mark.parametrize("rssi", ["-49", None, True, [], {}])
def test_an_rssi_that_is_no_number_is_refused_by_name(rssi: Any) -> None:
    good = {"bssid": "a8:0c:ca:03:9d:d7", "rssi": -49}
    assert refused(readings(good, {**good, "rssi": rssi})) == "wifi[0].readings[1].rssi"


def test_of_an_access_point_heard_twice_the_newest_counts_and_then_the_stronger() -> None:
    one = "a8:0c:ca:03:9d:d7"
    batch = parsed(
        readings(
            {"bssid": one, "rssi": -40, "seen": T0 - 9000},
            {"bssid": one.upper(), "rssi": -80, "seen": T0 - 100},
            {"bssid": one, "rssi": -70, "seen": T0 - 100},
            {"bssid": one, "rssi": -75, "seen": T0 - 100},
        )
    )
    assert batch.wifi[0].rssi_dbm.tolist() == [-70]
    assert batch.wifi[0].seen_s.tolist() == [(T0 - 100) / 1000]
    assert batch.dropped == 0


@pytest.mark.parametrize("seen", [None, 0, -1, T0 + 60_000])
def test_a_missing_or_future_seen_is_the_time_of_the_scan(seen: int | None) -> None:
    (scan,) = parsed(readings({"bssid": "a8:0c:ca:03:9d:d7", "rssi": -49, "seen": seen, "frequency": None})).wifi
    assert scan.seen_s.tolist() == [T0 / 1000]


def test_bluetooth_readings_may_say_their_power_and_bad_ones_are_dropped() -> None:
    sent = [
        {"id": "u:1:2", "rssi": -82, "tx_power": -65},
        {"id": "u:1:2", "rssi": -80},
        {"id": "", "rssi": -80},
        {"id": 7, "rssi": -80},
        {"id": "far", "rssi": -200},
    ]
    batch = parsed({"sequence": 0, "bluetooth": [{"t": T0, "readings": sent}]})
    (scan,) = batch.bluetooth
    assert batch.dropped == 3
    assert scan.beacon == ("u:1:2", "u:1:2")
    assert scan.rssi_dbm.tolist() == [-82, -80]


@pytest.mark.parametrize(
    ("body", "field"),
    [
        (readings(*[{"bssid": "a8:0c:ca:03:9d:d7", "rssi": -49}] * 100_000), "wifi[0].readings"),
        ({"sequence": 0, "wifi": [{"t": T0, "readings": []}] * 601}, "wifi"),
        ({"sequence": 0, "gyroscope": {"t": [T0] * 200_001, "x": [], "y": [], "z": []}}, "gyroscope.t"),
    ],
)
def test_what_is_too_long_is_refused_by_name(body: dict[str, Any], field: str) -> None:
    with pytest.raises(TooLarge) as refusal:
        parse_batch(json.dumps(body).encode(), Packing.JSON)
    assert refusal.value.field == field


@pytest.mark.parametrize(
    "sent", [b"", b"{", b"\xff\xfe", b"null", b"[]", b'"x"', b"[" * 100_000, b'{"sequence":"\\ud800"}']
)
def test_what_is_no_object_is_refused(sent: bytes) -> None:
    with pytest.raises(InvalidInput):
        parse_batch(sent, Packing.JSON)


@pytest.mark.parametrize(
    "sent", [b"", b"\xdd\xff\xff\xff\xff", b"\x91" * 100_000, b"\x81\x01\x02", b"\xa1\xff", b"\x90"]
)
def test_what_is_no_messagepack_object_is_refused(sent: bytes) -> None:
    with pytest.raises(InvalidInput):
        parse_batch(sent, Packing.MSGPACK)


@given(st.binary(max_size=200), st.sampled_from(list(Packing)))
def test_no_bytes_whatever_do_more_than_be_refused(sent: bytes, packing: Packing) -> None:
    try:
        parse_batch(sent, packing)
    except InvalidInput as refusal:
        assert str(refusal)
