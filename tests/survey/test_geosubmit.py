from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.floorplan.georeference import Georeference
from app.survey.admission import FloorExtent
from app.survey.geosubmit import PlacedFloor, placed_reports
from tests.survey.surveys import levels
from tests.survey.traces import mac

T = 1_700_000_000_000
FRAME = Georeference(30.0, 120.0, 0.3)


def floor(name: str, level: int, venue: str = "mall", frame: Georeference = FRAME) -> PlacedFloor:
    return PlacedFloor(venue, level, FloorExtent(name, 100.0, 60.0), frame)


FLOORS = [floor("F2", 1), floor("F1", 0), floor("B1", -1)]


def report(x_m: float = 40.0, y_m: float = 20.0, **changed: Any) -> dict[str, Any]:
    latitude, longitude = FRAME.to_wgs84(x_m, y_m)
    points = [{"macAddress": mac(n), "signalStrength": -50 - n, "frequency": 2412, "age": 100} for n in (1, 2)]
    return {
        "timestamp": T,
        "position": {"latitude": latitude, "longitude": longitude, "accuracy": 5.0, **changed.pop("position", {})},
        "wifiAccessPoints": points,
        "cellTowers": [{"cellId": 1}],
        **changed,
    }


def placed(*reports: Any, floors: list[PlacedFloor] = FLOORS) -> list[tuple[str, Any]]:
    return list(placed_reports(reports, floors, T + 5000))


def test_a_report_lands_where_its_coordinates_are_in_the_frame() -> None:
    ((venue, found),) = placed(report())
    assert (venue, found.floor, found.time_s) == ("mall", "F1", T / 1000)
    assert (found.x_m, found.y_m) == pytest.approx((40.0, 20.0), abs=1e-3)
    assert levels(found) == {mac(1): -51, mac(2): -52}


@pytest.mark.parametrize(
    ("floors", "said", "expected"),
    [
        (["F2", "F1", "B1"], None, "F1"),
        (["F2", "B1"], None, "F2"),
        (["B1"], None, "B1"),
        (["F2", "F1"], "F2", "F2"),
        (["F2", "F1"], "", "F1"),
    ],
)
def test_of_floors_above_one_another_the_named_one_counts_or_the_ground_floor(
    floors: list[str], said: str | None, expected: str
) -> None:
    chosen = [one for one in FLOORS if one.extent.floor in floors]
    ((_, found),) = placed(report(position={"floor": said}), floors=chosen)
    assert found.floor == expected


@pytest.mark.parametrize("said", ["F9", 2, ["F1"]])
def test_a_report_of_a_floor_that_is_not_there_is_not_put_on_another(said: Any) -> None:
    assert placed(report(position={"floor": said})) == []


def test_a_place_that_two_venues_claim_is_nobodys() -> None:
    assert placed(report(), floors=[*FLOORS, floor("G", 0, venue="station")]) == []


def test_a_report_without_a_time_was_made_when_it_came() -> None:
    assert placed(report(timestamp=None))[0][1].time_s == (T + 5000) / 1000


@pytest.mark.parametrize(
    "bad",
    [
        report(x_m=500.0),
        report(position={"latitude": 91.0}),
        report(position={"latitude": None}),
        report(position={"longitude": "120"}),
        report(position={"accuracy": 26.0}),
        report(position={"age": 7000}),
        report() | {"position": []},
        report(wifiAccessPoints=None),
        report(wifiAccessPoints=[]),
        report(wifiAccessPoints=[{"macAddress": mac(1), "signalStrength": -50}]),
        report(wifiAccessPoints=[{"macAddress": mac(1), "signalStrength": -50}, {"macAddress": mac(2)}]),
        report(wifiAccessPoints=[{"macAddress": mac(n), "signalStrength": -50, "ssid": "a_nomap"} for n in (1, 2)]),
        report(wifiAccessPoints=[{"macAddress": mac(n), "signalStrength": -50, "age": 6001} for n in (1, 2)]),
        report(timestamp=-1),
        None,
        7,
        [],
    ],
)
def test_a_bad_report_is_left_out_and_the_others_land(bad: Any) -> None:
    assert len(placed(report(), bad, report())) == 2


VALUES = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                ["position", "latitude", "longitude", "wifiAccessPoints", "macAddress", "timestamp", "accuracy"]
            ),
            inner,
            max_size=5,
        )
    ),
    max_leaves=15,
)


@given(VALUES, st.sampled_from(["position", "wifiAccessPoints", "timestamp"]))
def test_whatever_a_report_holds_nothing_is_raised(value: Any, member: str) -> None:
    assert len(placed(value, report(), {**report(), member: value})) >= 1
