"""The track of a session as all of its evidence has it: what came before each moment, and what came after it.

Robust least squares over the walking model of app/fusion/smoothing_model.py, whatever method took the evidence down.
The forward filter does not know at first which way a phone without north is going, nor how it is held; afterwards
everybody does. docs/smoothing.md says what it measures.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.estimation.angles import wrap_all
from app.estimation.arrays import FloatArray, IntArray
from app.estimation.block_chain import banded, covariances, solved
from app.fusion.smoothed_track import SmoothedTrack
from app.fusion.smoothing_model import (
    HEADING,
    SIZE,
    Fixes,
    Links,
    SmoothingSettings,
    fixes_of,
    links_of,
    normal_equations,
)
from app.fusion.walk_timeline import Moment, Timeline, timeline
from app.observations import RadioFix, Step

SETTLED_M = 0.02
MOST_ROUNDS = 30
SHAPED_AFTER = 2
"""Rounds after which the track has its shape, and every fix is weighed by how far it lies off."""
LARGEST_TURN_RAD = 0.7
"""By which a round may turn any heading."""
LEAST_WEIGHT = 1e-3
BORNE_OUT = 0.25
"""Weight of a fix that the track agrees with."""
FACED_WITHIN_RAD = 1.0
"""Standard deviation of a heading that says something."""


def smoothed(
    evidence: Sequence[Step | RadioFix], moments: Sequence[Moment], settings: SmoothingSettings | None = None
) -> SmoothedTrack | None:
    """The track at these moments, or None where no scan has said anything.

    Parameters
    ----------
    evidence : of a session up to now, in any order.  moments : in order of time, at least one.

    Notes
    -----
    Takes time in proportion to the length of the session. Coordinates of different floors have nothing in common but
    north.
    """
    settings = settings or SmoothingSettings()
    line = timeline(evidence, moments)
    if line is None:
        return None
    origin_m = np.mean([fix.xy_m for fix in line.fixes], axis=0)
    links, fixes = links_of(line, settings), fixes_of(line, origin_m)
    state = np.zeros((len(line.links) + 1, SIZE))
    state[:, HEADING] = _first_headings(links, fixes, settings)
    weight = np.where(fixes.fits > 0.0, 1.0, settings.doubted_weight)
    for done in range(MOST_ROUNDS):
        diagonal, below, right = normal_equations(state, links, fixes, weight, settings)
        change = solved(banded(diagonal, below), right.ravel())[0].reshape(state.shape)
        share = min(1.0, LARGEST_TURN_RAD / max(float(np.abs(change[:, HEADING]).max()), LARGEST_TURN_RAD))
        state = state + share * change
        if done < SHAPED_AFTER:
            continue
        weight = np.maximum(1.0 / (1.0 + fixes.misfit(state) / settings.unlikely), LEAST_WEIGHT)
        # the first weights have moved nothing yet, however little the round before them did
        if done > SHAPED_AFTER and share == 1.0 and float(np.hypot(*change[:, :HEADING].T).max()) < SETTLED_M:
            break
    diagonal, below, right = normal_equations(state, links, fixes, weight, settings)
    factor = solved(banded(diagonal, below), right.ravel())[1]
    return _told(line, moments, links, state, *covariances(factor, SIZE), weight, origin_m, settings)


def _told(
    line: Timeline,
    moments: Sequence[Moment],
    links: Links,
    state: FloatArray,
    of_one: FloatArray,
    of_two: FloatArray,
    weight: FloatArray,
    origin_m: FloatArray,
    settings: SmoothingSettings,
) -> SmoothedTrack:
    """The track between its states. of_one, of_two : covariances of a state, and of one with the state before it."""
    time_s = np.array([moment.time_s for moment in moments])
    link, share = line.at(time_s)
    before, after = 1.0 - share, share
    at = before[:, None] * state[link] + after[:, None] * state[link + 1]
    both = of_two[link, :HEADING, :HEADING]
    spread = _times(before * before, of_one[link, :HEADING, :HEADING])
    spread += _times(after * after, of_one[link + 1, :HEADING, :HEADING])
    spread += _times(before * after, both + np.swapaxes(both, 1, 2))
    # what a link adds to the place within it, between two states that are known: a bridge
    spread += _times(before * after / links.precision[link, 0], np.broadcast_to(np.eye(2), spread.shape))
    faced = of_one[link + 1, HEADING, HEADING] < FACED_WITHIN_RAD**2
    agreed = np.flatnonzero(weight >= BORNE_OUT)
    contested = line.fixes[agreed[-1] + 1 if len(agreed) else 0 :]
    return SmoothedTrack(
        time_s=time_s,
        floor=line.floors(time_s),
        xy_m=at[:, :HEADING] + origin_m,
        covariance_m2=settings.inflation * spread,
        heading_rad=np.where(faced, wrap_all(at[:, HEADING]), np.nan),
        contested_s=contested[0].time_s if contested else None,
        contested_xy_m=np.array([fix.xy_m for fix in contested]).reshape(-1, 2),
        contested_m2=np.array([fix.lasting_m2 + float(np.trace(fix.noise_m2)) / 2.0 for fix in contested]),
    )


def _times(factor: FloatArray, matrices: FloatArray) -> FloatArray:
    return factor[:, None, None] * matrices


def _first_headings(links: Links, fixes: Fixes, settings: SmoothingSettings) -> FloatArray:
    """(n,) of the states: the phone's own, turned window by window so that the way they lead lies along the fixes.

    Notes
    -----
    The rotation that fits two weighted sets of places best is the argument of a sum of products of complex numbers; a
    phone that knows north adds a term for its heading being off by no more than how it is held.
    """
    count = len(links.length_m)
    known = np.flatnonzero(np.isfinite(links.phone_rad))
    if not len(known):
        return np.zeros(count + 1)
    newest = np.maximum(np.searchsorted(known, np.arange(count), side="right") - 1, 0)
    own = np.unwrap(links.phone_rad[known])[newest]
    own = np.concatenate([own[:1] - links.turn_rad[:1], own])
    towards = 0.5 * np.pi - own[:-1] - 0.5 * links.turn_rad
    way = np.concatenate([[0.0], np.cumsum(links.length_m * np.exp(1j * towards))])
    walked = fixes.between(way[:, None])[:, 0]
    seen = fixes.xy_m[:, 0] + 1j * fixes.xy_m[:, 1]
    weight = np.where(fixes.fits > 0.0, 1.0, settings.doubted_weight) / fixes.variance_m2

    windows = max(1, round(count / settings.window))
    part = fixes.link * windows // count
    # each window looks at its neighbours too; sums by window make that linear
    counts, of_walked, of_seen, product = (
        _with_neighbours(part, np.asarray(values, dtype=np.complex128), windows)
        for values in (weight, weight * walked, weight * seen, weight * walked.conj() * seen)
    )
    turned = product - of_walked.conj() * of_seen / np.where(counts == 0.0, 1.0, counts)
    if (links.north > 0.0).any():
        turned = turned + settings.askew_sigma_rad**-2
    middle = (np.arange(windows) + 0.5) * count / windows
    return own - np.interp(np.arange(count + 1), middle, np.unwrap(np.angle(turned)))


def _with_neighbours(part: IntArray, values: NDArray[np.complex128], windows: int) -> NDArray[np.complex128]:
    """(windows,) sums of complex values by the window that they lie in and those on both sides."""
    sums = np.zeros(windows + 2, dtype=np.complex128)
    np.add.at(sums, part + 1, values)
    return sums[:-2] + sums[1:-1] + sums[2:]
