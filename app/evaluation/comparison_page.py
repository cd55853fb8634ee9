"""docs/comparison.md from the document of a comparison."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from app.evaluation.comparison import OPEN, Outcome, RowFigures, Verdict, outcomes, rows_from
from app.evaluation.paper_figures import PUBLISHED, STATISTICS
from app.evaluation.written_figures import number, percent

COLUMNS = ("row", "n", "mean", "RMS", "median", "95 %", "beyond 1 m", "us a step")


def page(document: Mapping[str, Any], pictures: str | None) -> str:
    """The page. pictures : folder of the CDF plots as the page's reader finds it, None without them."""
    return "\n".join(_lines(document, pictures)) + "\n"


def _lines(document: Mapping[str, Any], pictures: str | None) -> Iterator[str]:
    folds = {name: rows_from(rows) for name, rows in document[OPEN]["parts"].items()}
    counts = document[OPEN]["walks"]
    sites = {name: rows_from(site["rows"]) for name, site in document["sites"].items()}
    yield "# Comparison"
    yield ""
    yield (
        "`make compare` wrote this page. Figures and verdicts are what it measured; the reasons, where a claim does "
        "not come out, are written by hand. It walks every method and every ablation over the open recordings and over "
        f"a simulation of each paper's site (seed {document['seed']}), and took {_minutes(document['seconds'])} with "
        f"{document['jobs']} processes, "
        f"{_minutes(document[OPEN]['seconds'])} of them on the open walks."
    )
    yield ""
    yield (
        "Errors are horizontal, in metres. The time is the method's own, scan matching and dead reckoning included, a "
        "step walked, on the machine that made this page. Tuning used folds 1 to 4 of the open walks and never fold 0, "
        "and none of the simulated sites."
    )
    yield ""
    yield "## Open walks"
    yield ""
    yield (
        f"{sum(counts.values())} recorded walks of a mall's floors, each on a map of the walks of the other folds; "
        f"waypoints that the survey covers. Fold 0 alone is {counts['fold 0']} walks: 0.3 m there are noise."
    )
    for part, rows in folds.items():
        if part in ("pooled", "fold 0"):
            yield from ("", f"### {part}", "", *_table(rows, {}))
    yield from ("", "### Mean of each fold", "", *_folds_table(folds))
    yield from _picture(pictures, OPEN)
    yield from ("", "## What the papers claim, and what comes out here", "")
    yield (
        "An improvement is the share by which the better row's figure is smaller. It comes out (*yes*) with at least "
        "half of the paper's, *weaker* with less than that, *no* where there is none."
    )
    found = [one for one in outcomes({**sites, OPEN: folds["pooled"]}) if one.verdict is not Verdict.NOT_MEASURED]
    yield from ("", *_outcome_table(found), "", "### Where it does not, and why", "")
    yield from _reasons(found)
    for name, site in document["sites"].items():
        yield from ("", f"## {site['title']} ({name})", "")
        yield f"Paper of `{site['method']}`. Stated there: {site['stated']}. Assumed: {site['assumed']}."
        yield from ("", *_table(sites[name], PUBLISHED.get(name, {})))
        yield from _picture(pictures, name)


def _table(rows: Mapping[str, RowFigures], published: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    """The figures of every row, best mean first; the paper's own behind a slash."""
    paper = {"mean": "mean", "rms": "RMS", "p95": "95 %", "beyond_1m": "beyond 1 m"}
    gross = any(math.isfinite(row.gross) for row in rows.values())
    columns = [*COLUMNS, "at gross errors"] if gross else list(COLUMNS)
    yield f"| {' | '.join(columns)} |"
    yield "|" + " --- |" * len(columns)
    for name, row in sorted(rows.items(), key=lambda item: (math.isnan(item[1].mean), item[1].mean)):
        theirs = published.get(name, {})
        cells = {
            "row": f"`{name}`",
            "n": str(row.n),
            "mean": number(row.mean, 2),
            "RMS": number(row.rms, 2),
            "median": number(row.median, 2),
            "95 %": number(row.p95, 2),
            "beyond 1 m": percent(row.beyond_1m, 0),
            "us a step": f"{row.step_us:.0f}" if math.isfinite(row.step_us) else "-",
            "at gross errors": number(row.gross, 2),
        }
        for statistic, column in paper.items():
            if statistic in theirs:
                value = theirs[statistic]
                cells[column] += f" / {percent(value, 0) if statistic == 'beyond_1m' else number(value, 2)}"
        if "gross" in theirs:
            cells["at gross errors"] += f" / {number(theirs['gross'], 2)}"
        yield f"| {' | '.join(cells[column] for column in columns)} |"
    if published:
        yield ""
        yield "Behind a slash: the paper's own figure."


def _folds_table(folds: Mapping[str, Mapping[str, RowFigures]]) -> Iterator[str]:
    parts = [part for part in folds if part != "pooled"]
    yield f"| row | {' | '.join(parts)} |"
    yield "|" + " --- |" * (len(parts) + 1)
    for name in sorted(folds["pooled"], key=lambda one: folds["pooled"][one].mean):
        cells = " | ".join(number(folds[part][name].mean, 2) for part in parts)
        yield f"| `{name}` | {cells} |"


def _outcome_table(found: Sequence[Outcome]) -> Iterator[str]:
    yield "| site | better | than | by | paper | ours | paper's improvement | ours | open walks | comes out |"
    yield "|" + " --- |" * 10
    for one in found:
        claim, share = one.claim, one.claim.statistic == "beyond_1m"
        pairs = [
            "-" if pair is None else " < ".join(percent(v, 0) if share else number(v, 2) for v in pair)
            for pair in (one.paper, one.ours)
        ]
        if one.ours is not None and one.ours[0] >= one.ours[1]:
            pairs[1] = pairs[1].replace("<", ">=")
        gains = [percent(v, 0) for v in (one.paper_improvement, one.our_improvement, one.open_improvement)]
        cells = [claim.site, f"`{claim.better}`", f"`{claim.worse}`", STATISTICS[claim.statistic], *pairs, *gains]
        yield f"| {' | '.join([*cells, one.verdict.value])} |"


def _reasons(found: Sequence[Outcome]) -> Iterator[str]:
    """A line for every claim that does not come out; equal reasons of one site and row are told once."""
    told: dict[str, list[str]] = {}
    for one in found:
        if one.verdict in (Verdict.WEAKER, Verdict.NOT_REPRODUCED):
            claim = one.claim
            what = f"{claim.site}, `{claim.better}` against `{claim.worse}`, {STATISTICS[claim.statistic]}"
            told.setdefault(claim.why or "no reason was found yet", []).append(f"{what} ({one.verdict.value})")
    for why, claims in told.items():
        yield f"- {'; '.join(claims)}: {why.rstrip('.')}."
    if not told:
        yield "Everything that was measured comes out."


def _picture(pictures: str | None, name: str) -> Iterator[str]:
    if pictures is not None:
        yield from ("", f"![Distribution of the error, {name}]({pictures}/cdf_{name}.png)")


def _minutes(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} minutes"
