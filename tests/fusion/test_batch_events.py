"""A batch is taken in the order of time, whatever it holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.fusion.batch_events import end_of, events
from app.observations import Batch, BluetoothScan, PressureSamples, WifiScan
from app.pdr.tracker import initial_pdr_state
from tests.fusion.walks import walked

NOTHING = np.empty(0)


def scan(time_s: float) -> WifiScan:
    return WifiScan(time_s, NOTHING.astype(np.int64), NOTHING, NOTHING)


def test_scans_come_in_order_and_the_end_last() -> None:
    batch = Batch(0, 20.0, wifi=(scan(12.0), scan(11.0), scan(15.0)))
    found = list(events(initial_pdr_state(), 10.0, batch))
    assert [event.time_s for event in found] == [11.0, 12.0, 15.0, 20.0]
    assert [event.scan is None for event in found] == [False, False, False, True]


def test_beacons_are_events_of_their_own_for_whoever_asks_for_them() -> None:
    batch = Batch(0, 20.0, wifi=(scan(12.0),), bluetooth=(BluetoothScan(11.0, (), NOTHING),))
    assert [event.time_s for event in events(initial_pdr_state(), 10.0, batch)] == [12.0, 20.0]
    found = list(events(initial_pdr_state(), 10.0, batch, bluetooth=True))
    assert [event.time_s for event in found] == [11.0, 12.0, 20.0]
    assert [(event.scan is None, event.beacons is None) for event in found] == [
        (True, False),
        (False, True),
        (True, True),
    ]


def test_time_never_runs_back() -> None:
    found = list(events(initial_pdr_state(), 10.0, Batch(0, 9.0, wifi=(scan(8.5),))))
    assert [event.time_s for event in found] == [10.0, 10.0]


def test_an_empty_batch_ends_where_the_session_was() -> None:
    assert [event.time_s for event in events(initial_pdr_state(), None, Batch(0, None))] == [None]
    assert [event.time_s for event in events(initial_pdr_state(), 3.0, Batch(0, None))] == [3.0]


@pytest.mark.parametrize("stream", ["wifi", "bluetooth", "barometer"])
def test_a_batch_that_names_no_end_ends_with_its_newest_sample(stream: str) -> None:
    content = {
        "wifi": (scan(7.0),),
        "bluetooth": (BluetoothScan(7.0, (), NOTHING),),
        "barometer": PressureSamples(np.array([6.0, 7.0]), np.array([1000.0, 1000.0])),
    }
    batch = replace(Batch(0, None), **{stream: content[stream]})  # type: ignore[arg-type]
    assert end_of(batch, 2.0) == 7.0
    assert end_of(batch, 8.0) == 8.0
    assert end_of(replace(batch, end_s=7.5), None) == 7.5


def test_every_step_is_told_once_however_many_scans_part_the_batch() -> None:
    batches = walked(5).batches[:30]
    plain: list[float] = []
    parted: list[float] = []
    for cut, told in ((False, plain), (True, parted)):
        state, time_s = initial_pdr_state(), None
        for batch in batches:
            end_s = batch.end_s or 0.0
            scans = tuple(scan(end_s - 0.1 * k) for k in range(9, 0, -1)) if cut else ()
            for event in events(state, time_s, replace(batch, wifi=scans)):
                state, time_s = event.pdr, event.time_s
                told += [step.time_s for step in event.moved.steps]
    assert plain == parted
    assert len(plain) > 30
