"""Session states to bytes and back: what lets any worker, or a restarted one, take the next batch of any session.

A state is a frozen dataclass of numbers, text, enums, arrays, tuples, None and other such dataclasses. Only classes
that were made storable are written or read: the bytes name them, and a name that is not in the registry is an error,
never an import. Each class is stored with a fingerprint of its fields, so that a state of an earlier version of the
code is refused instead of being read with its numbers in the wrong places.
"""

from __future__ import annotations

import dataclasses
import enum
import math
import zlib
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import ormsgpack

from app.errors import DependencyDown, Expired
from app.fusion.interface import SessionStart
from app.observations import Carrying, Excluded, Flag, Motion, Position, Step
from app.pdr.attitude_state import AttitudeState
from app.pdr.step_detection import StepState
from app.pdr.tracker import PdrState

FORMAT = 1
_PLAIN = frozenset({type(None), bool, int, float, str})
_DTYPES = tuple(np.dtype(name) for name in ("<f8", "<f4", "<i8", "<i4", "|u1", "|b1"))
_DTYPE_CODES = {dtype.num: code for code, dtype in enumerate(_DTYPES)}
_TUPLE, _ARRAY, _CLASSES = 0, 1, 2
"""First element of every list in the tree; from _CLASSES on it counts the classes named at the head."""
_Class = TypeVar("_Class", bound=type)


@dataclasses.dataclass(frozen=True, slots=True)
class _Plan:
    """How a class is written. fields : None for an enum.  fingerprint : of what a stored state must agree with."""

    name: str
    kind: type
    fields: tuple[str, ...] | None
    fingerprint: int


_plans: dict[type, _Plan] = {}
_named: dict[str, _Plan] = {}


def storable(kind: _Class) -> _Class:
    """Allow a frozen dataclass or an enum in stored states; also a class decorator.

    Raises
    ------
    TypeError : neither of the two, or one whose fields are not all arguments of its constructor, in order.
    ValueError : another class has that name.
    """
    if issubclass(kind, enum.Enum):
        fields = None
        text = " ".join(f"{member.name}={member.value!r}" for member in kind)
    elif dataclasses.is_dataclass(kind) and kind.__dataclass_params__.frozen:  # type: ignore[attr-defined]
        described = dataclasses.fields(kind)
        if not all(one.init and not one.kw_only for one in described):
            raise TypeError(f"{kind.__name__} has fields that its constructor does not take in order")
        fields = tuple(one.name for one in described)
        text = " ".join(f"{one.name}:{one.type}" for one in described)
    else:
        raise TypeError(f"{kind.__name__} is neither a frozen dataclass nor an enum")
    held = _named.get(kind.__name__)
    if held is not None and held.kind is not kind:
        raise ValueError(f"two classes named {kind.__name__} cannot both be stored")
    plan = _Plan(kind.__name__, kind, fields, zlib.crc32(text.encode()))
    _plans[kind] = _named[plan.name] = plan
    return kind


for _kind in (PdrState, AttitudeState, StepState, SessionStart, Position, Step, Excluded, Flag, Motion, Carrying):
    storable(_kind)


def encode_state(state: Any) -> bytes:
    """The state as bytes.

    Raises
    ------
    TypeError : it holds something that is not storable.
    """
    head: list[tuple[str, int]] = []
    codes: dict[type, int] = {}
    arrays: list[bytes] = []

    def pack(value: Any) -> Any:
        kind = type(value)
        if kind in _PLAIN:
            return value
        if kind is np.ndarray:
            dtype = value.dtype
            stored = _DTYPE_CODES.get(dtype.num)
            if stored is None or not dtype.isnative:
                raise TypeError(f"an array of {dtype} cannot be stored in a state")
            raw = value.tobytes()
            arrays.append(raw)
            if stored and len(raw) % 8:
                arrays.append(bytes(-len(raw) % 8))
            return [_ARRAY, stored, *value.shape]
        if kind is tuple:
            return [_TUPLE, *map(pack, value)]
        code = codes.get(kind)
        plan = _plans.get(kind)
        if plan is None:
            raise TypeError(f"{kind.__module__}.{kind.__qualname__} cannot be stored in a state")
        if code is None:
            code = codes[kind] = len(head) + _CLASSES
            head.append((plan.name, plan.fingerprint))
        if plan.fields is None:
            return [code, value.name]
        return [code, *[pack(getattr(value, name)) for name in plan.fields]]

    tree = pack(state)
    return ormsgpack.packb([FORMAT, head, tree, b"".join(arrays)])


def decode_state(encoded: bytes) -> Any:
    """The state that encode_state wrote; its arrays are writable and its own.

    Raises
    ------
    Expired : it was written by a version of the code whose states were different.
    DependencyDown : these are not the bytes of a state; the store has lost some.
    """
    try:
        layout, head, tree, raw = ormsgpack.unpackb(encoded)
        if layout != FORMAT:
            raise Expired(f"the session was stored in format {layout}, now it is {FORMAT}; open a new one")
        return _reader([_known(name, fingerprint) for name, fingerprint in head], bytearray(raw))(tree)
    except (ValueError, TypeError, KeyError, IndexError) as error:
        raise DependencyDown(f"a stored session state cannot be read: {error}") from error


def _known(name: str, fingerprint: int) -> _Plan:
    plan = _named.get(name)
    if plan is None or plan.fingerprint != fingerprint:
        reason = "is unknown" if plan is None else "has other fields"
        raise Expired(f"the session was begun under another version of the service ({name} {reason}); open a new one")
    return plan


def _reader(plans: list[_Plan], raw: bytearray) -> Callable[[Any], Any]:
    """What turns the tree back into values, taking arrays from `raw` in order."""
    words: Any = np.frombuffer(raw, np.float64) if raw else np.empty(0)
    offset = 0

    def unpack(node: Any) -> Any:
        nonlocal offset
        if type(node) is not list:
            return node
        code = node[0]
        if code >= _CLASSES:
            plan = plans[code - _CLASSES]
            if plan.fields is None:
                return plan.kind[node[1]]
            return plan.kind(*[unpack(child) for child in node[1:]])
        if code == _TUPLE:
            return tuple([unpack(child) for child in node[1:]])
        shape = node[2:]
        count = math.prod(shape)
        if node[1] == 0:
            begin, offset = offset, offset + count
            values = words[begin:offset]
        else:  # each begins on a word of 8 bytes, so that compiled code sees the layout it was compiled for
            dtype = _DTYPES[node[1]]
            begin, offset = offset, offset + (count * dtype.itemsize + 7) // 8
            values = words[begin:offset].view(dtype)[:count]
        if values.size != count:
            raise ValueError("its arrays are cut short")
        return values if len(shape) == 1 else values.reshape(shape)

    return unpack
