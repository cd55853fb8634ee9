"""Session states survive being stored, and what is not a state of this version is refused."""

from __future__ import annotations

import dataclasses
import enum
import math
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np
import ormsgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from app.errors import DependencyDown, Expired
from app.fusion.state_codec import decode_state, encode_state, storable
from app.observations import Motion
from app.pdr.tracker import initial_pdr_state


@storable
class Mood(enum.Enum):
    GOOD = 1
    BAD = "two"


@storable
@dataclass(frozen=True, slots=True, eq=False)
class Leaf:
    values: Any
    mood: Mood = Mood.GOOD


@storable
@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    left: Any
    right: Any


def same(one: Any, other: Any) -> bool:
    """Equal in type, value, and for arrays in dtype and shape; NaN equals NaN."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and bool(one.tobytes() == other.tobytes())
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if dataclasses.is_dataclass(one):
        names = [field.name for field in dataclasses.fields(one)]
        return all(same(getattr(one, name), getattr(other, name)) for name in names)
    return bool(one == other) or (one != one and other != other)


dtypes = st.sampled_from(["<f8", "<f4", "<i8", "<i4", "|u1", "|b1"])
kept_arrays = dtypes.flatmap(
    lambda dtype: arrays.arrays(dtype, arrays.array_shapes(min_dims=0, min_side=0, max_side=4))
)
leaves = (
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats()
    | st.text()
    | st.sampled_from([*Mood, *Motion])
    | kept_arrays
)
states = st.recursive(
    leaves,
    lambda inner: (
        st.lists(inner, max_size=4).map(tuple)
        | st.builds(Leaf, inner, st.sampled_from(Mood))
        | st.builds(Branch, inner, inner)
    ),
    max_leaves=20,
)


@given(states)
def test_a_state_comes_back_as_it_was(state: Any) -> None:
    assert same(decode_state(encode_state(state)), state)


@given(states)
def test_the_bytes_of_a_state_are_always_the_same(state: Any) -> None:
    encoded = encode_state(state)
    assert encode_state(decode_state(encoded)) == encoded


def test_arrays_come_back_laid_out_for_compiled_code_and_shared_with_nothing() -> None:
    state = Branch(np.ones(3, np.bool_), np.arange(12.0).reshape(3, 4).T)
    first, second = decode_state(encode_state(state)), decode_state(encode_state(state))
    assert first.right.flags.c_contiguous and first.right.flags.aligned and first.right.flags.writeable
    first.right[0, 0] = 99.0
    assert second.right[0, 0] == 0.0 == state.right[0, 0]


def test_dead_reckoning_state_survives() -> None:
    state = initial_pdr_state()
    assert repr(astuple(decode_state(encode_state(state)))) == repr(astuple(state))


def test_what_is_not_made_storable_is_not_stored() -> None:
    @dataclass(frozen=True)
    class Stranger:
        values: float

    for thing in (Stranger(1.0), [1.0], {"a": 1}, np.float64(1.0), np.array([object()]), math.sin):
        with pytest.raises(TypeError, match="cannot be stored"):
            encode_state(Branch(thing, None))


def test_only_frozen_dataclasses_and_enums_can_be_made_storable() -> None:
    @dataclass
    class Mutable:
        value: float

    with pytest.raises(TypeError, match="neither a frozen dataclass nor an enum"):
        storable(Mutable)
    with pytest.raises(TypeError, match="neither a frozen dataclass nor an enum"):
        storable(dict)


def test_two_classes_of_one_name_are_not_mixed_up() -> None:
    impostor = dataclasses.make_dataclass("Leaf", ["values"], frozen=True)
    with pytest.raises(ValueError, match="Leaf"):
        storable(impostor)


@pytest.mark.parametrize(("name", "fingerprint"), [("Leaf", 1), ("Forgotten", 2)])
def test_a_state_of_another_version_is_refused_by_name(name: str, fingerprint: int) -> None:
    layout, _, tree, raw = ormsgpack.unpackb(encode_state(Leaf(1.0)))
    with pytest.raises(Expired, match=f"another version.*{name}"):
        decode_state(ormsgpack.packb([layout, [[name, fingerprint]], tree, raw]))
    with pytest.raises(Expired, match="format"):
        decode_state(ormsgpack.packb([layout + 1, [], tree, raw]))


@given(states, st.data())
def test_bytes_that_were_cut_off_are_an_error_of_the_store(state: Any, data: st.DataObject) -> None:
    encoded = encode_state(state)
    with pytest.raises(DependencyDown):
        decode_state(encoded[: data.draw(st.integers(0, len(encoded) - 1))])


@given(st.binary(max_size=60))
def test_arbitrary_bytes_are_refused_and_nothing_else(encoded: bytes) -> None:
    with pytest.raises((DependencyDown, Expired)):
        decode_state(encoded)


def test_arrays_that_were_lost_are_an_error_of_the_store() -> None:
    layout, head, tree, _ = ormsgpack.unpackb(encode_state(Leaf(np.arange(5.0))))
    with pytest.raises(DependencyDown, match="cut short"):
        decode_state(ormsgpack.packb([layout, head, tree, np.arange(3.0).tobytes()]))
