from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import ormsgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.errors import DependencyDown
from app.fusion.evidence_codec import decode_evidence, encode_evidence
from app.fusion.fix_assembly import Walker, no_fix
from app.fusion.interface import SessionStart
from app.observations import Carrying, Fix, Motion, RadioFix, Step

number = st.floats(-1e6, 1e6)
positive = st.floats(0.0, 1e6)
steps = st.builds(Step, number, positive, positive, number, positive, number, number | st.just(math.nan))
scans = st.builds(
    lambda time_s, floor, xy_m, own, lasting_m2, distance, fits, source: RadioFix(
        time_s, floor, np.array(xy_m), np.array([own[:2], own[1:]]), lasting_m2, distance, fits, source
    ),
    number,
    st.text(min_size=1, max_size=64),
    st.tuples(number, number),
    st.tuples(positive, number, positive),
    positive,
    positive,
    st.booleans(),
    st.sampled_from(["wifi", "bluetooth"]),
)


def fix_of(evidence: list[Step | RadioFix], motion: Motion = Motion.WALKING) -> Fix:
    fix = no_fix(SessionStart(), 1.0, Walker(None, None, 0, motion, Carrying.UNKNOWN))
    return replace(fix, evidence=tuple(evidence))


@given(st.lists(steps | scans, max_size=8), st.sampled_from(Motion), st.booleans(), positive)
def test_evidence_comes_back_as_it_was(
    evidence: list[Step | RadioFix], motion: Motion, certain: bool, unsurveyed_m2: float
) -> None:
    fix = replace(fix_of(evidence, motion), floor_certain=certain, unsurveyed_m2=unsurveyed_m2)
    decoded = decode_evidence(encode_evidence(fix))
    assert (decoded.motion, decoded.floor_certain, decoded.unsurveyed_m2) == (motion, certain, unsurveyed_m2)
    assert [repr(one) for one in decoded.measured] == [repr(one) for one in evidence]


def test_evidence_that_did_not_say_whether_the_floor_was_certain_counts_as_if_it_was_not() -> None:
    decoded = decode_evidence(ormsgpack.packb([1, "still", []]))
    assert (decoded.measured, decoded.floor_certain, decoded.unsurveyed_m2) == ((), False, 0.0)


def test_a_step_takes_less_than_70_bytes() -> None:
    step = Step(1.7e9, 0.55, 0.7, 1.0, 0.2, 0.01, math.nan)
    empty, full = len(encode_evidence(fix_of([]))), len(encode_evidence(fix_of([step] * 100)))
    assert empty < 30
    assert full - empty < 100 * 70


@pytest.mark.parametrize(
    "lost", [b"", b"\x93\x01\xa5still", b"\x93\x09\xa5still\x90", b"\x93\x01\xa5stile\x90", b"\x93\x02\xa5still\x90"]
)
def test_bytes_that_are_no_evidence_are_a_broken_store(lost: bytes) -> None:
    with pytest.raises(DependencyDown, match="cannot be read"):
        decode_evidence(lost)


@pytest.mark.parametrize("measured", [[[1.0, 2.0]], [["F1", 1.0]], [[]], [7]])
def test_rows_that_are_cut_short_are_a_broken_store(measured: object) -> None:
    with pytest.raises(DependencyDown, match="cannot be read"):
        decode_evidence(ormsgpack.packb([1, "still", measured]))
