"""A session's evidence on one line of time: by which links the walker came from each place to the next.

Forward filters take evidence in the order in which it came. Afterwards a step can stand where it belongs: between the
scans before and after it.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.observations import Motion, RadioFix, Step
from app.pdr.rhythm import STEP_OVERDUE
from app.pdr.turn_doubt import SPAN_S, TurnRecord, led

BLIND_AFTER_S = 10.0
"""Without a step for so long, and yet not still, a phone moves in a way that nobody counts."""
LONGEST_BLIND_S = 1.0
MOST_BLIND = 20_000
"""Pieces of a session's blind time; of days of it they are longer."""


@dataclass(frozen=True, slots=True)
class Moment:
    """A time at which the smoothed track is asked for, and what the walker was doing."""

    time_s: float
    motion: Motion


@dataclass(frozen=True, slots=True)
class Link:
    """What lies between two states of the walk.

    length_m, turn_rad : of a step, before any scale.  turns : whether its turn is known.  phone_rad : heading by the
    phone at its end, NaN without any.  north : whether that is from north.
    blind_s : time in which the walker may have gone anywhere.  new_floor : another floor begins here, whose frame and
    radio map have nothing in common with those before.
    """

    start_s: float
    end_s: float
    length_m: float = 0.0
    turn_rad: float = 0.0
    turns: bool = True
    phone_rad: float = math.nan
    north: bool = False
    blind_s: float = 0.0
    new_floor: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """links : in order of time, each from the state before it to the one after; n links have n + 1 states.
    fixes : in order of time, at least one."""

    links: tuple[Link, ...]
    fixes: tuple[RadioFix, ...]

    def at(self, time_s: FloatArray) -> tuple[IntArray, FloatArray]:
        """(n,) which link is under way at each time, and (n,) the share of it that has passed."""
        starts = np.array([link.start_s for link in self.links])
        ends = np.array([link.end_s for link in self.links])
        index = np.minimum(np.searchsorted(ends, time_s, side="right"), len(ends) - 1)
        span_s = np.maximum(ends[index] - starts[index], 1e-6)
        share = np.clip((time_s - starts[index]) / span_s, 0.0, 1.0)
        return index, np.where(time_s >= ends[index], 1.0, share)

    def floors(self, time_s: FloatArray) -> list[str]:
        """Floor at each of (n,) times: of the newest fix by then; before the first, of the first."""
        newest = np.searchsorted([fix.time_s for fix in self.fixes], time_s, side="right") - 1
        return [self.fixes[max(int(index), 0)].floor for index in newest]


def timeline(evidence: Sequence[Step | RadioFix], moments: Sequence[Moment]) -> Timeline | None:
    """The evidence in order of its own times, or None where no scan has said anything.

    Parameters
    ----------
    moments : in order of time; they tell whether a phone without steps was still.
    """
    fixes = sorted((one for one in evidence if isinstance(one, RadioFix)), key=lambda fix: fix.time_s)
    steps = sorted((one for one in evidence if isinstance(one, Step)), key=lambda step: step.time_s)
    if not fixes:
        return None
    links = _stepped(steps)
    if steps and moments and moments[-1].motion is Motion.WALKING:
        links += _under_way(steps[-1], moments[-1].time_s)
    links += _blind([link.end_s for link in links], moments)
    links += [
        Link(after.time_s, after.time_s, new_floor=True)
        for before, after in itertools.pairwise(fixes)
        if after.floor != before.floor
    ]
    links.sort(key=lambda link: link.end_s)
    return Timeline(tuple(links) or (Link(fixes[0].time_s, fixes[0].time_s),), tuple(fixes))


def _stepped(steps: Sequence[Step]) -> list[Link]:
    """A link a step. Of a gyroscope that is doubted neither turns nor headings are believed, nor what it said in the
    time that it took to doubt it."""
    doubts_s = [one.step.time_s for one in led(TurnRecord(), steps, turns=True)[1] if one.doubted]
    links, before_s = list[Link](), -math.inf
    for step in steps:
        north, next_doubt = step.absolute, bisect.bisect_left(doubts_s, step.time_s)
        doubted = next_doubt < len(doubts_s) and doubts_s[next_doubt] <= step.time_s + SPAN_S
        # without gyroscope and north there is no turn at all, not even noise
        turns = not doubted and (north or step.heading_change_rad != 0.0)
        start_s = min(max(step.time_s - step.duration_s, before_s), step.time_s)
        links.append(
            Link(
                start_s,
                step.time_s,
                step.length_m,
                step.heading_change_rad if turns else 0.0,
                turns,
                step.heading_rad if turns else math.nan,
                north and not doubted,
            )
        )
        before_s = step.time_s
    return links


def _under_way(last: Step, now_s: float) -> list[Link]:
    """The step that has begun and is not yet told, taken to be like the one before."""
    since_s, duration_s = now_s - last.time_s, max(last.duration_s, 1e-3)
    if not 0.0 < since_s < STEP_OVERDUE * duration_s:
        return []
    share = min(since_s / duration_s, 1.0)
    return [Link(last.time_s, last.time_s + share * duration_s, share * last.length_m)]


def _blind(step_ends_s: Sequence[float], moments: Sequence[Moment]) -> list[Link]:
    """Links for the time in which the phone moved and no step was told, in pieces of a second."""
    ends = np.array([-math.inf, *step_ends_s])
    stretches = list[list[float]]()
    for before, after in itertools.pairwise(moments):
        if after.motion is Motion.STILL:
            continue
        last_step_s = float(ends[np.searchsorted(ends, after.time_s, side="right") - 1])
        from_s = max(before.time_s, last_step_s)
        if stretches and from_s == stretches[-1][1]:
            stretches[-1][1] = after.time_s
        else:
            stretches.append([from_s, after.time_s])
    counted = len(step_ends_s) or any(moment.motion is Motion.STILL for moment in moments)
    piece_s = max(LONGEST_BLIND_S, sum(until_s - from_s for from_s, until_s in stretches) / MOST_BLIND)
    links = list[Link]()
    for from_s, until_s in stretches:
        if until_s - from_s > (BLIND_AFTER_S if counted else 0.0):
            cuts = np.linspace(from_s, until_s, math.ceil((until_s - from_s) / piece_s) + 1).tolist()
            links += [Link(start_s, end_s, blind_s=end_s - start_s) for start_s, end_s in itertools.pairwise(cuts)]
    return links
