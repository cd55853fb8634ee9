"""The answer to a batch holds what is known, null for what is not, and no number that is not finite."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import Any

import pytest

from app.fusion.interface import Floor, Site
from app.observations import Batch, Carrying, Excluded, Fix, Flag, Integrity, Motion, Position
from app.services.fix_document import fix_document, flag_of, in_fault, initial_document

SITE = Site({"F1": Floor("F1", 0, 100.0, 60.0)})
INTEGRITY = Integrity(Flag.NOMINAL, True, 0, 0, 0, 1.5, 29.8, 6.0, 10.0, 0.01)
FIX = Fix(
    time_s=1_573_190_000.25,
    position=Position(3.0, 4.0, "F1"),
    accuracy_m=2.0,
    covariance_m2=((1.0, 0.1), (0.1, 2.0)),
    heading_rad=0.5,
    speed_mps=1.1,
    step_count=7,
    motion=Motion.WALKING,
    carrying=Carrying.HANDHELD,
    integrity=INTEGRITY,
)


def document(**changes: Any) -> dict[str, Any]:
    return dict(json.loads(fix_document("s", Batch(4, None), dataclasses.replace(FIX, **changes), SITE)))


def test_a_position_may_be_known_before_the_heading_and_the_speed_are() -> None:
    assert (document()["heading"], document()["speed"]) == (0.5, 1.1)
    known = document(heading_rad=None, speed_mps=None)
    assert (known["heading"], known["speed"]) == (None, None)
    assert known["position"] == {"x": 3.0, "y": 4.0, "floor": "F1", "latitude": None, "longitude": None}


def test_without_a_position_every_estimate_is_null_and_nothing_is_usable() -> None:
    unknown = document(position=None)
    assert [unknown[name] for name in ("position", "accuracy", "covariance", "heading", "speed")] == [None] * 5
    assert unknown["integrity"]["protection_level"] is None
    assert unknown["integrity"]["usable"] is False
    assert unknown.keys() == json.loads(initial_document("s", 10.0, 0.01)).keys()


@pytest.mark.parametrize("flag", list(Flag))
def test_the_flag_is_read_from_what_was_answered_whatever_its_text_says(flag: Flag) -> None:
    excluded = (Excluded('"flag":"fault"', observation="wifi"), Excluded('{"flag":"nominal"}', bssid=1))
    integrity = dataclasses.replace(INTEGRITY, flag=flag, excluded=excluded)
    answered = fix_document('"flag":"coasting"', Batch(4, None), dataclasses.replace(FIX, integrity=integrity), SITE)
    assert flag_of(answered) is flag
    assert in_fault(answered) == (flag is Flag.FAULT)
    assert not in_fault(None)


@pytest.mark.parametrize(
    "broken",
    [
        {"accuracy_m": 0.0},
        {"accuracy_m": None},
        {"covariance_m2": None},
        {"heading_rad": math.nan},
        {"speed_mps": math.inf},
        {"position": Position(math.nan, 0.0, "F1")},
        {"integrity": dataclasses.replace(INTEGRITY, protection_level_m=math.inf)},
        {"integrity": dataclasses.replace(INTEGRITY, protection_level_m=None)},
    ],
)
def test_a_method_that_breaks_its_promise_is_a_defect_and_not_an_answer(broken: dict[str, Any]) -> None:
    with pytest.raises(ValueError):
        document(**broken)
