"""Every method and ablation on the open walks and on the papers' simulated sites, as one document of plain numbers."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any

from app.evaluation.campaign import Advance, Protocol, replayed
from app.evaluation.paper_figures import CLAIMS, PUBLISHED, Claim
from app.evaluation.paper_sites import PaperSite
from app.evaluation.recordings import RecordedWalk
from app.evaluation.replay import Answer
from app.evaluation.scoring import covered_errors_m, errors_m, errors_of, ratio
from app.evaluation.simulated_sites import SimulatedSite, simulated
from app.fusion.interface import Method
from app.observations import Batch
from app.pdr.tracker import advance_pdr, initial_pdr_state

OPEN = "open"
NEAR_M = 1.0
GROSS_WITHIN_S = 1.0
"""Answers so long after a scan that was made wrong are those at a gross error."""
WEAKER_BELOW = 0.5
"""Of the paper's improvement, below which a result comes out weaker."""


class Verdict(StrEnum):
    """Whether a relative result comes out again."""

    REPRODUCED = "yes"
    WEAKER = "weaker"
    NOT_REPRODUCED = "no"
    NOT_MEASURED = "not measured"


@dataclass(frozen=True, slots=True)
class RowFigures:
    """Of one method on one site. Errors in metres, NaN of none.

    beyond_1m : share of errors.  gross : mean error at scans made wrong.  step_us : the method's time per step walked,
    by the median batch, so that whatever else the machine does is left out.
    """

    n: int
    mean: float
    rms: float
    median: float
    p95: float
    beyond_1m: float
    gross: float
    step_us: float


@dataclass(frozen=True, slots=True)
class Outcome:
    """A claim beside what was measured. improvements : share by which the better row's figure is smaller.

    ours : (better, worse) on the paper's site, None where a row was not run.  open_improvement : on the open walks.
    """

    claim: Claim
    paper: tuple[float, float]
    ours: tuple[float, float] | None
    paper_improvement: float
    our_improvement: float | None
    open_improvement: float | None
    verdict: Verdict


def on_site(
    paper: PaperSite, methods: Mapping[str, Method], seed: int, jobs: int, done: Advance
) -> tuple[SimulatedSite, dict[str, list[Answer]]]:
    """The simulated site and the answers of every method on it."""
    site = simulated(paper, seed)
    return site, replayed(site.site, site.coverage, site.walks, methods, Protocol(), 0, jobs, done)


def figures(answers: Sequence[Answer], steps: int, gross_s: Mapping[str, Sequence[float]] | None = None) -> RowFigures:
    """Figures over the covered waypoints among the answers; on a simulated site that is every second.

    Parameters
    ----------
    steps : walked in the walks of these answers.  gross_s : times of scans made wrong, by walk.
    """
    judged = covered_errors_m(answers)
    errors = errors_of(judged)
    at_gross = errors_m(
        a
        for a in answers
        if any(0.0 <= a.time_s - scan_s < GROSS_WITHIN_S for scan_s in (gross_s or {}).get(a.walk, ()))
    )
    return RowFigures(
        n=errors.n,
        mean=errors.mean_m,
        rms=errors.rms_m,
        median=errors.median_m,
        p95=errors.p95_m,
        beyond_1m=ratio(sum(error > NEAR_M for error in judged), len(judged)),
        gross=errors_of(at_gross).mean_m,
        step_us=1e6 * statistics.median(a.spent_s for a in answers) * len(answers) / steps
        if steps and answers
        else math.nan,
    )


def steps_walked(walk: RecordedWalk) -> int:
    """Steps that dead reckoning counts in a walk."""
    trace = walk.trace
    whole = Batch(0, None, trace.accelerometer, trace.gyroscope, trace.magnetometer, trace.rotation_vector)
    return len(advance_pdr(initial_pdr_state(), whole)[1].steps)


def outcome(claim: Claim, site: Mapping[str, RowFigures], open_walks: Mapping[str, RowFigures]) -> Outcome:
    """The claim beside the figures of its site and of the open walks."""
    published = PUBLISHED[claim.site]
    paper = (published[claim.better][claim.statistic], published[claim.worse][claim.statistic])
    ours, here, there = _pair(claim, site), None, None
    if ours is not None:
        here = _improvement(*ours)
    recorded = _pair(claim, open_walks)
    if recorded is not None:
        there = _improvement(*recorded)
    theirs = _improvement(*paper)
    return Outcome(claim, paper, ours, theirs, here, there, _verdict(theirs, here))


def outcomes(sites: Mapping[str, Mapping[str, RowFigures]], claims: Sequence[Claim] = CLAIMS) -> list[Outcome]:
    """Every claim on the sites that were walked; `sites` holds the pooled open walks as OPEN."""
    return [outcome(claim, sites[claim.site], sites.get(OPEN, {})) for claim in claims if claim.site in sites]


def _pair(claim: Claim, rows: Mapping[str, RowFigures]) -> tuple[float, float] | None:
    if claim.better not in rows or claim.worse not in rows:
        return None
    better, worse = (float(getattr(rows[name], claim.statistic)) for name in (claim.better, claim.worse))
    return (better, worse) if math.isfinite(better) and math.isfinite(worse) and worse > 0.0 else None


def _improvement(better: float, worse: float) -> float:
    return 1.0 - better / worse


def _verdict(theirs: float, ours: float | None) -> Verdict:
    if ours is None:
        return Verdict.NOT_MEASURED
    if ours <= 0.0:
        return Verdict.NOT_REPRODUCED
    return Verdict.REPRODUCED if ours >= WEAKER_BELOW * theirs else Verdict.WEAKER


def rows_from(document: Mapping[str, Any]) -> dict[str, RowFigures]:
    """Figures from the JSON that `written_figures.plain` made of them."""
    found = {}
    for name, row in document.items():
        values = {key: math.nan if value is None else float(value) for key, value in row.items() if key != "n"}
        found[name] = RowFigures(int(row["n"]), *(values[field.name] for field in fields(RowFigures)[1:]))
    return found
