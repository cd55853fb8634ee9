"""What a set of clean walks says of a method's trustworthiness, at one or several risks, as one row of a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rich import box
from rich.table import Table

from app.evaluation.integrity import ALERT_LIMITS_M, AtLimit, Integrity, Share, integrity, share_of
from app.evaluation.replay import Answer, WalkKey
from app.evaluation.scoring import covered_errors_m, errors_m, errors_of, ratio
from app.evaluation.written_figures import number
from app.observations import Flag

RISKS = (0.01, 0.05)
"""At which the campaigns judge; the first is the default of a session."""
ALERT_LIMIT_M = max(ALERT_LIMITS_M)
"""Of the campaigns' sessions: what they are told says what smaller limits would have been told."""


@dataclass(frozen=True, slots=True)
class TrustRow:
    """Of the answers to the same walks at each risk, in ascending order of risk.

    alarms_right : walks with an alarm that began when the answer was beyond the smallest alert limit.
    error_mean_m, error_p95_m : at covered waypoints.  error_all_m : mean of every answer.  floor_right : of positions.
    at_risk : the first is that of the smallest risk.
    """

    walks: int
    alarms_right: int
    error_mean_m: float
    error_p95_m: float
    error_all_m: float
    floor_right: float
    inside_68: Share
    risks: tuple[float, ...]
    at_risk: tuple[Integrity, ...]


def trust_row(answers: Mapping[float, Sequence[Answer]]) -> TrustRow:
    """The row; answers : by risk, to the same walks."""
    risks = tuple(sorted(answers))
    found = answers[risks[0]]
    placed = [a for a in found if a.error_m is not None]
    covered = errors_of(covered_errors_m(found))
    every = errors_of(errors_m(found))
    judged = tuple(integrity(answers[risk]) for risk in risks)
    return TrustRow(
        walks=judged[0].walks,
        alarms_right=_alarms_right(found),
        error_mean_m=covered.mean_m,
        error_p95_m=covered.p95_m,
        error_all_m=every.mean_m,
        floor_right=ratio(sum(a.floor_right for a in placed), len(placed)),
        inside_68=share_of(placed, lambda a: not a.beyond(a.accuracy_m)),
        risks=risks,
        at_risk=judged,
    )


def trust_rows_table(rows: Mapping[tuple[str, ...], TrustRow], title: str, named: Sequence[str]) -> Table:
    """Rows under the words that name them; named : headings of these words."""
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    limits = next(iter(rows.values())).at_risk[0].limits if rows else ()
    risks = next(iter(rows.values())).risks if rows else ()
    columns = [*named, "walks", "alarm", "mean\nm", "95 %\nm", "in\n68 %"]
    columns += [f"inside,\nrisk {risk:g}" for risk in risks]
    columns += ["covered", "level\nm", "level~\nerror", f"usable cov.\n{', '.join(_limit(at) for at in limits)} m"]
    columns += [f"hazardous\n{_limit(at)} m" for at in limits]
    for index, column in enumerate(columns):
        table.add_column(column, justify="left" if index < len(named) else "right", no_wrap=True)
    for words, row in rows.items():
        strict = row.at_risk[0]
        cells = [*words, str(row.walks), f"{strict.false_alert_walks} ({row.alarms_right})"]
        cells += [number(row.error_mean_m, 1), number(row.error_p95_m, 1), _in_hundred(row.inside_68.share)]
        cells += [_at_least(one.inside_level) for one in row.at_risk]
        cells += [_in_hundred(strict.inside_level_covered.share), number(strict.level_median_m, 1)]
        cells += [number(strict.level_error_correlation, 2)]
        cells += [", ".join(_in_hundred(at.available_covered.share, 0) for at in strict.limits)]
        cells += [_at_most(at.hazardous) for at in strict.limits]
        table.add_row(*cells)
    return table


LEGEND = (
    "Shares in per cent. alarm: walks with flag fault, in brackets those in which the answer was then beyond the "
    f"smallest alert limit of {min(ALERT_LIMITS_M):g} m. mean, 95 %: at covered waypoints. in 68 %: truth inside the "
    "accuracy. inside: truth inside the level; in brackets the one-sided 95 % bound by bootstrap over walks.",
    "covered, level, level~error (correlation), usable, hazardous: at the smallest risk; usable of covered answers, "
    "hazardous of all, with the bound.",
)


def _alarms_right(answers: Sequence[Answer]) -> int:
    first: dict[WalkKey, Answer] = {}
    for answer in answers:
        if answer.flag is Flag.FAULT:
            first.setdefault(answer.walk_key, answer)
    return sum(answer.beyond(min(ALERT_LIMITS_M)) for answer in first.values())


def _limit(at: AtLimit) -> str:
    return f"{at.alert_limit_m:g}"


def _in_hundred(value: float, digits: int = 1) -> str:
    return number(100.0 * value, digits)


def _at_least(one: Share) -> str:
    return f"{_in_hundred(one.share)} ({_in_hundred(one.lower_95)})"


def _at_most(one: Share) -> str:
    return f"{_in_hundred(one.share, 2)} ({_in_hundred(one.upper_95, 2)})"
