"""With a barometer the floor is held while the height is, and changes with it; without one nothing is different."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.fusion.floor_choice import chosen_floor
from app.fusion.interface import Floor, SessionStart, Site
from app.fusion.methods import METHODS
from app.fusion.state_codec import decode_state, encode_state
from app.fusion.storeys import Storeys, climbed, heard
from app.observations import Batch, PressureSamples
from app.simulation.climb import Climbing
from app.simulation.recorded_trace import trace_of
from app.simulation.recording import SURVEY_PHONE, Recording, record_climb
from app.wifi.floor_decision import FloorBelief
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap
from tests.fusion.walks import RATE_HZ, START_S, run, site, world

NAMES = ("B1", "F1", "F2", "F3", "F4", "F5")
TOWER = Site({name: Floor(name, level, 50.0, 30.0) for level, name in enumerate(NAMES, -1)})
MAP = replace(site().radio_map or RadioMap(), floors=NAMES)  # type: ignore[call-arg]
SUREFIX = METHODS["surefix"]
SCAN_EVERY_S, STOREY_M = 2, 3.8


class Phone:
    """A phone that reports heights and, every other second, hears a scan that votes for a floor."""

    def __init__(self, noise_hpa: float = 0.05, on: Site = TOWER, barometer: bool = True) -> None:
        self.storeys, self.site, self.barometer = Storeys(), on, barometer
        self.belief: FloorBelief | None = None
        self.seconds, self.height_m, self.noise_hpa = 0, 0.0, noise_hpa
        self.rng = np.random.default_rng(7)

    def second(self, height_m: float, vote: str | None, pressure_hpa: np.ndarray | None = None) -> None:
        """Five samples at this height, or of these pressures, and perhaps a scan."""
        time_s = START_S + self.seconds + np.arange(5) / 5.0
        noise = self.rng.normal(0.0, self.noise_hpa, 5)
        pressure = 1000.0 - 0.1178 * np.linspace(self.height_m, height_m, 5) + noise
        samples = PressureSamples(time_s, pressure if pressure_hpa is None else pressure_hpa)
        self.seconds, self.height_m, now_s = self.seconds + 1, height_m, float(time_s[-1])
        sent = samples if self.barometer else PressureSamples()
        self.storeys, self.belief, _ = climbed(self.storeys, self.belief, sent, now_s, self.site)
        if vote is not None and self.seconds % SCAN_EVERY_S == 0:
            self.storeys, self.belief = heard(self.storeys, self.belief, None, MAP, self.site, voting(vote), 0.0, now_s)

    def stay(self, seconds: int, vote: str | None, drift_m_per_s: float = 0.0) -> None:
        for _ in range(seconds):
            self.second(self.height_m + drift_m_per_s, vote)

    def climb(self, rise_m: float, seconds: int, vote: str | None = None) -> None:
        for height_m in np.linspace(self.height_m, self.height_m + rise_m, seconds + 1)[1:]:
            self.second(float(height_m), vote)

    @property
    def floor(self) -> str:
        assert self.belief is not None
        return self.belief.floor


def voting(floor: str) -> Match:
    """A scan whose neighbours are all on this floor."""
    votes = np.array([float(name == floor) for name in NAMES])
    nothing = np.zeros(2)
    return Match(NAMES.index(floor), votes, nothing, np.eye(2), np.zeros(1, np.int64), np.ones(1), np.ones(1), 9)


@pytest.mark.parametrize(("rise_m", "expected"), [(STOREY_M, "F3"), (-STOREY_M, "F1")])
def test_stairs_change_the_floor_before_any_scan_of_it(rise_m: float, expected: str) -> None:
    phone = Phone()
    phone.stay(30, "F2")
    phone.climb(rise_m, 20)
    assert phone.storeys.changing
    phone.stay(4, None)
    assert phone.floor == expected


def test_scans_that_still_hear_the_old_floor_do_not_keep_the_phone_there() -> None:
    phone = Phone()
    phone.stay(40, "F2")
    phone.climb(STOREY_M, 20, "F2")
    phone.stay(10, "F2")
    assert phone.floor == "F3"


@pytest.mark.parametrize("storeys", [2, 3, -1, -2])
def test_a_lift_counts_storeys(storeys: int) -> None:
    phone = Phone()
    phone.stay(30, "F1")
    phone.climb(STOREY_M, 20)  # one storey on foot shows how high they are
    phone.stay(12, "F2")
    phone.climb(storeys * STOREY_M, 3 + abs(storeys) * 2)
    phone.stay(6, None)
    assert phone.floor == NAMES[NAMES.index("F2") + storeys]


@pytest.mark.parametrize("hpa_per_h", [-1.0, 1.0])
@pytest.mark.parametrize("noise_hpa", [0.03, 0.1])
def test_weather_never_changes_the_floor(hpa_per_h: float, noise_hpa: float) -> None:
    phone = Phone(noise_hpa)
    floors = set()
    for _ in range(3600):
        phone.second(phone.height_m - hpa_per_h / 0.1178 / 3600.0, "F2")
        if phone.belief is not None:
            floors.add(phone.floor)
    assert floors == {"F2"}
    assert not phone.storeys.changing


def test_flickering_scans_change_the_floor_of_a_phone_without_barometer_only() -> None:
    for barometer, expected in ((True, {"F2"}), (False, {"F2", "F3"})):
        phone, floors = Phone(barometer=barometer), set()
        phone.stay(20, "F2")
        for seconds in (12, 8, 12, 14):
            phone.stay(seconds, "F3")
            floors.add(phone.floor)
            phone.stay(seconds, "F2")
            floors.add(phone.floor)
        assert floors == expected


def test_scans_that_insist_are_believed_in_the_end() -> None:
    phone = Phone()
    phone.stay(20, "F2")
    phone.stay(60, "F4")
    assert phone.floor == "F4"


def test_a_door_between_rooms_of_other_pressure_is_no_storey() -> None:
    phone = Phone()
    phone.stay(30, "F2")
    phone.climb(1.5, 1, "F2")
    phone.stay(60, "F2")
    assert phone.floor == "F2"
    assert not phone.storeys.changing
    phone.climb(STOREY_M, 20)
    phone.stay(4, None)
    assert phone.floor == "F3"


def test_a_session_that_begins_in_a_lift_finds_its_floor() -> None:
    phone = Phone()
    phone.climb(3 * STOREY_M, 9, "F2")
    phone.stay(16, "F4")
    assert phone.floor == "F4"


def test_a_gap_of_a_minute_is_bridged_and_one_of_minutes_is_not() -> None:
    for seconds, expected in ((60, "F3"), (600, "F2")):
        phone = Phone()
        phone.stay(30, "F2")
        phone.seconds, phone.height_m = phone.seconds + seconds, phone.height_m + STOREY_M
        phone.stay(5, None)
        assert phone.floor == expected


def test_without_a_barometer_and_where_all_levels_are_the_same_floors_are_decided_as_by_scans_alone() -> None:
    flat = Site({name: Floor(name, 0, 50.0, 30.0) for name in NAMES})
    votes = ["F2", "F2", "F3", "F2", "F3", "F3", "F3", "B1", "F3", "F1", "F1", "F1"]
    for phone in (Phone(barometer=False), Phone(on=flat)):
        alone: FloorBelief | None = None
        for vote in votes:
            phone.climb(1.0, SCAN_EVERY_S, vote)
            alone = chosen_floor(alone, None, MAP, phone.site, voting(vote))
            assert phone.belief is not None
            assert phone.floor == alone.floor
            np.testing.assert_array_equal(phone.belief.probability, alone.probability)


@pytest.mark.parametrize("pressure_hpa", [math.nan, math.inf, 1013.25, 0.0, 1150.0])
def test_values_that_no_barometer_reports_and_a_stuck_one_change_nothing(pressure_hpa: float) -> None:
    broken, without = Phone(), Phone(barometer=False)
    for vote in ["F2"] * 10 + ["F3"] * 10 + ["F1", "F3"] * 5:
        for phone in (broken, without):
            for _ in range(SCAN_EVERY_S):
                phone.second(0.0, vote, np.full(5, pressure_hpa))
        if broken.seconds > 12:
            assert broken.floor == without.floor


@settings(deadline=None, max_examples=60)
@given(
    seconds=st.lists(
        st.tuples(
            st.lists(
                st.one_of(st.floats(100.0, 1200.0), st.sampled_from([math.nan, math.inf, 1000.0])),
                min_size=5,
                max_size=5,
            ),
            st.sampled_from([*NAMES, None]),
        ),
        max_size=40,
    )
)
def test_hostile_pressures_leave_probabilities_that_are_ones(seconds: list[tuple[list[float], str | None]]) -> None:
    phone = Phone()
    for pressures, vote in seconds:
        phone.second(0.0, vote, np.array(pressures))
        if phone.belief is not None:
            assert phone.belief.probability.sum() == pytest.approx(1.0)
            assert (phone.belief.probability >= 0.0).all()
    assert 2.0 < phone.storeys.storey_m < 8.0


@lru_cache
def upstairs(how: Climbing) -> tuple[Recording, tuple[Batch, ...]]:
    """A walk of the simulated office that goes up one floor, in batches of a second."""
    recording = record_climb(world(), (0, 1), how, SURVEY_PHONE, START_S, 60.0, RATE_HZ, np.random.default_rng(12))
    trace, barometer, batches = trace_of(recording, world().access_points, "climb"), recording.barometer, []
    from_s = START_S
    for number in range(1, int(recording.walk.time_s[-1] - START_S)):
        until_s = START_S + number
        parts = {}
        for name in ("accelerometer", "gyroscope", "magnetometer", "rotation_vector"):
            stream = getattr(trace, name)
            kept = (stream.time_s > from_s) & (stream.time_s <= until_s)
            parts[name] = type(stream)(stream.time_s[kept], stream.values[kept])
        kept = (barometer.time_s > from_s) & (barometer.time_s <= until_s)
        pressed = PressureSamples(barometer.time_s[kept], barometer.pressure_hpa[kept])
        scans = tuple(scan for scan in trace.scans if from_s < scan.time_s <= until_s)
        batches.append(Batch(number, until_s, **parts, barometer=pressed, wifi=scans))
        from_s = until_s
    return recording, tuple(batches)


@pytest.mark.parametrize("how", list(Climbing))
def test_a_walk_up_one_storey_changes_the_floor_within_six_seconds_and_no_wrong_floor_is_usable(how: Climbing) -> None:
    recording, batches = upstairs(how)
    fixes = run(SUREFIX, batches)
    wrong = [
        fix
        for fix in fixes
        if fix.position and fix.time_s and fix.position.floor != recording.walk.floor_at(fix.time_s).floor
    ]
    assert len(wrong) <= 6
    assert not any(fix.integrity.usable for fix in wrong)
    assert fixes[-1].position is not None
    assert fixes[-1].position.floor == "F2"


def test_a_climb_is_the_same_from_a_stored_state_and_in_long_batches() -> None:
    _, batches = upstairs(Climbing.STAIRS)
    state, stored = SUREFIX.start(SessionStart()), SUREFIX.start(SessionStart())
    for batch in batches:
        state, fix = SUREFIX.advance(state, batch, site())
        stored, again = SUREFIX.advance(decode_state(encode_state(stored)), batch, site())
        assert fix.position == again.position
