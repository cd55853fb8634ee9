"""What every method does with a batch: one event after the other, and what is left behind for the Fix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol, TypeVar

from app.fusion.batch_events import Event, events
from app.observations import Batch, Fix, InnovationCheck, RadioFix, Step
from app.pdr.tracker import PdrOutput, PdrState


class _Advancing(Protocol):
    """Of a state: as the last event left it."""

    @property
    def pdr(self) -> PdrState: ...

    @property
    def time_s(self) -> float | None: ...


_State = TypeVar("_State", bound=_Advancing)


@dataclass(frozen=True, slots=True)
class Findings:
    """What a batch leaves behind, in the order in which it came.

    checks : the record of every measurement.  evidence : what smoothing works with.  confirmed : access points that
    scans heard as they were surveyed.
    """

    checks: list[InnovationCheck] = field(default_factory=list)
    evidence: list[Step | RadioFix] = field(default_factory=list)
    confirmed: list[int] = field(default_factory=list)


def advanced(
    state: _State,
    batch: Batch,
    after: Callable[[_State, Event, Findings], _State],
    fix: Callable[[_State, PdrOutput, tuple[InnovationCheck, ...]], Fix],
    bluetooth: bool = False,
) -> tuple[_State, Fix]:
    """The state after every event of a batch, and the Fix at its end with what was left behind.

    Parameters
    ----------
    after : the state after an event; adds to what is left behind.
    fix : of the state at the end, by what dead reckoning says there and the checks.
    bluetooth : scans of beacons are events, too.
    """
    findings, moved = Findings(), None
    for event in events(state.pdr, state.time_s, batch, bluetooth):
        moved = event.moved
        state = after(state, event, findings)
    if moved is None:
        raise RuntimeError("a batch has an end")
    made = fix(state, moved, tuple(findings.checks))
    return state, replace(made, evidence=tuple(findings.evidence), confirmed=tuple(findings.confirmed))
