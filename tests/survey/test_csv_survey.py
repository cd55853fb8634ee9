from __future__ import annotations

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.errors import InvalidInput
from app.survey.rejection import LISTED_MOST
from tests.survey.surveys import csv_survey, levels, reasons
from tests.survey.traces import mac

HEADER = "floor,x,y,t,bssid,rssi\n"
T = 1_700_000_000_000


def row(number: int = 1, rssi: object = -50, x: object = 1, y: object = 2, t: object = T, floor: str = "F1") -> str:
    return f"{floor},{x},{y},{t},{mac(number)},{rssi}\n"


def test_consecutive_rows_of_one_place_and_time_are_one_fingerprint() -> None:
    found, notes = csv_survey(HEADER + row(1, -50) + row(2, -60.5) + row(1, -70, t=T + 1) + row(1, -71, x=3, t=T + 1))
    assert [levels(one) for one in found] == [{mac(1): -50, mac(2): -60.5}, {mac(1): -70}, {mac(1): -71}]
    assert [(one.floor, one.x_m, one.y_m, one.time_s) for one in found] == [
        ("F1", 1, 2, T / 1000),
        ("F1", 1, 2, (T + 1) / 1000),
        ("F1", 3, 2, (T + 1) / 1000),
    ]
    assert notes.rejections.count == 0


def test_columns_may_come_in_any_order_case_and_with_optional_ones_and_a_byte_order_mark() -> None:
    text = "\ufeffRSSI, BSSID ,t,Y,x,Floor,frequency,ssid\r\n" + f"-50,{mac(1).upper()},{T},2,1,F1,2412,shop\r\n"
    found, _ = csv_survey(text)
    assert levels(found[0]) == {mac(1): -50} and (found[0].x_m, found[0].y_m) == (1, 2)


def test_of_an_access_point_that_occurs_twice_the_stronger_counts() -> None:
    found, _ = csv_survey(HEADER + row(1, -60) + row(1, -50) + row(1, -70))
    assert [levels(one) for one in found] == [{mac(1): -50}]


def test_networks_that_opted_out_are_dropped_without_a_word() -> None:
    text = "floor,x,y,t,bssid,rssi,ssid\n" + f"F1,1,2,{T},{mac(1)},-50,home_nomap\nF1,1,2,{T},{mac(2)},-50,shop\n"
    found, notes = csv_survey(text)
    assert [levels(one) for one in found] == [{mac(2): -50}]
    assert notes.rejections.count == 0


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (row(x="nan"), "x and y must be finite"),
        (row(y="inf"), "x and y must be finite"),
        (row(x="abc"), "x 'abc' is not a number"),
        (row(x="1_0"), "x '1_0' is not a number"),
        (row(y="١"), "y '١' is not a number"),
        (row(x=111), "x 111 is outside floor F1"),
        (row(y=-11), "y -11 is outside floor F1"),
        (row(floor="F9"), "the venue has no floor 'F9'"),
        (row(floor=""), "the venue has no floor ''"),
        (row(t=-1), "t must be Unix milliseconds"),
        (row(t="nan"), "t must be Unix milliseconds"),
        (row(t=1e300), "t must be Unix milliseconds"),
        (row(t=2 * 3600 * 10**9), "t must be Unix milliseconds"),
        (row(rssi=-128), "rssi -128 is outside [-127, 20] dBm"),
        (row(rssi="nan"), "rssi nan is outside [-127, 20] dBm"),
        (row(rssi=""), "rssi '' is not a number"),
        (row().replace("02:00", "zz:00"), "not a MAC address"),
        ("F1,1,2\n", "3 cells where the header has 6"),
        (row().replace("\n", ",9\n"), "7 cells where the header has 6"),
    ],
)
def test_a_bad_row_is_rejected_by_its_number_and_good_rows_land(bad: str, reason: str) -> None:
    found, notes = csv_survey(HEADER + row(1, -50) + bad + row(2, -60, t=T + 9))
    assert [levels(one) for one in found] == [{mac(1): -50}, {mac(2): -60}]
    assert list(reasons(notes)) == [3]
    assert reason in reasons(notes)[3]


def test_readings_after_a_place_that_was_rejected_do_not_land_at_the_place_before() -> None:
    found, notes = csv_survey(HEADER + row(1, -50) + row(2, -50, x="nan") + row(3, -50, x="nan"))
    assert [levels(one) for one in found] == [{mac(1): -50}]
    assert list(reasons(notes)) == [3, 4]


@pytest.mark.parametrize(
    ("header", "field"),
    [
        ("", "floor"),
        ("floor,x,y,t,bssid\n", "rssi"),
        ("floor,x,y,t,bssid,rssi,rssi\n", "rssi"),
        ("floor,x,y,t,bssid,rssi,colour\n", "colour"),
        ("\x00\xff\n", "floor"),
    ],
)
def test_a_header_that_cannot_be_used_is_refused_by_its_column(header: str, field: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        csv_survey(header + row())
    assert refused.value.field == field


def test_a_file_of_garbage_has_a_short_answer_that_counts_all() -> None:
    found, notes = csv_survey(HEADER + "garbage\n" * 5000)
    assert found == []
    assert (notes.rejections.count, len(notes.rejections.listed)) == (5000, LISTED_MOST)


@given(st.binary(max_size=300))
def test_no_bytes_after_the_header_raise_anything(garbage: bytes) -> None:
    found, notes = csv_survey((HEADER + row()).encode() + garbage)
    assert len(found) >= 1 or notes.rejections.count


def test_a_line_without_an_end_is_one_row_and_rejected() -> None:
    found, notes = csv_survey(HEADER + row(1) + "x" * 1_000_000 + "\n" + row(2, t=T + 1) + "bad\n" + '"' * 300_000)
    assert len(found) == 2
    assert list(reasons(notes)) == [3, 5, 6]


def test_cells_may_be_in_quotes_and_hold_commas_and_quotes_then() -> None:
    text = (
        "floor,x,y,t,bssid,ssid,rssi\n"
        + f'"F1","1",2,{T},{mac(1)},"a ""good"", place_nomap",-50\n'
        + f'F1,1,2,{T},{mac(2)},6" of rain,"-50"\n'
    )
    found, notes = csv_survey(text)
    assert [levels(one) for one in found] == [{mac(2): -50}]
    assert notes.rejections.count == 0


LINES = st.text(st.characters(codec="utf-8", exclude_characters="\n\r"), min_size=1) | st.sampled_from(
    ['"', 'F1,1,2,"', '"F1,1,2', row().strip().replace("F1", '"F1'), "x" * 100_000, "x" * 250_000, '"' * 99_999]
)


@given(st.lists(st.none() | LINES, max_size=30), st.sampled_from(["\n", "\r\n", "\r"]))
def test_among_any_lines_the_good_ones_land_and_the_others_are_rejected_by_number(
    lines: list[str | None], end: str
) -> None:
    good = [number for number, line in enumerate(lines, start=2) if line is None]
    rows = [row(t=T + number).strip() if line is None else line for number, line in enumerate(lines, start=2)]
    found, notes = csv_survey(end.join([HEADER.strip(), *rows]))
    assert [round(1000 * one.time_s) - T for one in found] == good
    assert [one.item for one in notes.rejections.listed] == [n for n in range(2, 2 + len(lines)) if n not in good]


CELLS = st.text(st.characters(codec="utf-8"), max_size=12)


@given(st.lists(st.lists(CELLS, min_size=6, max_size=6), max_size=8))
def test_whatever_cells_hold_only_finite_numbers_land(rows: list[list[str]]) -> None:
    buffer = io.StringIO()
    csv.writer(buffer).writerows(rows)
    found, _ = csv_survey(HEADER + buffer.getvalue())
    assert all(0 <= one.time_s < 1e11 and -10 <= one.x_m <= 110 and len(one.bssid) for one in found)


def test_measurements_of_one_place_are_left_out_together_in_cross_validation() -> None:
    found, _ = csv_survey(HEADER + "".join(row(1, -50, x=x, t=T + t) for x in range(40) for t in range(2)))
    by_place: dict[float, set[str]] = {}
    for one in found:
        by_place.setdefault(one.x_m, set()).add(one.walk)
    assert all(len(walks) == 1 for walks in by_place.values())
    assert len(set().union(*by_place.values())) > 10
