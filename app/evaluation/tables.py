"""Scores as tables for the terminal and as a document of plain numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.table import Table

from app.evaluation.campaign import Protocol
from app.evaluation.fault_campaign import DETECTION_S, FaultScore
from app.evaluation.integrity import Integrity, Share, integrity
from app.evaluation.replay import Answer
from app.evaluation.scoring import ISO_18305, Errors, Score, covered_errors_m, errors_of, ratio, score
from app.evaluation.written_figures import number, percent, plain

_PLACES = {
    "waypoints_covered": "waypoints, covered by the survey",
    "waypoints": "waypoints, all",
    "every_answer": "every answer",
}
LEGEND = (
    "Errors are horizontal, in metres; median and 95 % are CEP and CE95 of ISO/IEC 18305.",
    "positioned: answers with a position (ISO/IEC 18305 availability). in 68 %, in level: truth inside the 68 % radius "
    "and the protection level. NEES: 2 where the covariance is right.",
    "misleading: usable, yet beyond the level. hazardous: usable, yet beyond the alert limit; both of all answers.",
    "In brackets one-sided 95 % bounds by bootstrap over walks, of hazardous walks by Clopper-Pearson; a dash where no "
    "walk errs: the bootstrap is blind to what never happened.",
)


def error_table(scores: Mapping[str, Score]) -> Table:
    """Horizontal errors, a section for each of the three kinds of place."""
    table = _table("Horizontal error, m", ["method", "n", "mean", "RMS", "median", "75 %", "95 %"])
    for field, title in _PLACES.items():
        table.add_row(f"[bold]{title}")
        for name, one in scores.items():
            table.add_row(f"  {name}", *_error_cells(getattr(one, field)))
        table.add_section()
    return table


def trust_table(scores: Mapping[str, Score], protocol: Protocol) -> Table:
    """Whether the answers can be believed, and what they cost."""
    columns = ["method", "posi-\ntioned", "floor\nright", "in\n68 %", "in\nlevel", "level\nm", "level~\nerror", "NEES"]
    columns += ["usable", "usable\ncovered", "mis-\nleading", "hazar-\ndous", "fault\nwalks", "ms\np50", "ms\np99"]
    table = _table(f"Trust, alert limit {protocol.alert_limit_m:g} m, risk {protocol.risk:g}", columns)
    for name, one in scores.items():
        table.add_row(
            name,
            percent(one.positioned),
            percent(one.floor_right),
            percent(one.inside_68),
            percent(one.inside_protection_level),
            number(one.protection_level_median_m, 1),
            number(one.level_error_correlation, 2),
            number(one.consistency.nees_mean, 1),
            percent(one.available),
            percent(one.available_covered),
            percent(one.misleading, 2),
            percent(one.hazardous, 2),
            percent(one.walks_with_fault_flag),
            number(one.batch_ms_p50, 2),
            number(one.batch_ms_p99, 2),
        )
    return table


def parts_table(answers: Mapping[str, Sequence[Answer]]) -> Table:
    """Mean and 95 % error at covered waypoints of each floor and fold: how far a single figure can be trusted."""
    parts = sorted({part for found in answers.values() for answer in found for part in _parts(answer)})
    table = _table("Covered waypoints, mean / 95 %, m", ["method", *parts])
    for name, found in answers.items():
        cells = []
        for part in parts:
            errors = errors_of(covered_errors_m(a for a in found if part in _parts(a)))
            cells.append(f"{number(errors.mean_m, 2)} / {number(errors.p95_m, 1)}")
        table.add_row(name, *cells)
    return table


def integrity_table(found: Mapping[str, Integrity], protocol: Protocol) -> Table:
    """Whether the level keeps its promise and what remains at usual alert limits; in brackets the 95 % bounds."""
    columns = [
        "method",
        "inside level",
        "covered",
        "level\nm",
        "covered\nm",
        "level~\nerror",
        "false\nalerts",
        "limit\nm",
    ]
    columns += ["available", "covered", "misleading", "hazardous", "hazardous\nwalks"]
    table = _table(f"Integrity, promised inside the level {1.0 - protocol.risk:g}", columns)
    for name, one in found.items():
        cells = [name, _at_least(one.inside_level), _at_least(one.inside_level_covered)]
        cells += [number(one.level_median_m, 1), number(one.level_median_covered_m, 1)]
        cells += [number(one.level_error_correlation, 2), f"{one.false_alert_walks} of {one.walks}"]
        for at in one.limits:
            shares = (percent(at.available.share), percent(at.available_covered.share))
            walks = f"{at.hazardous.walks} (<={percent(at.hazardous.walks_upper_95)})"
            rates = (_at_most(at.misleading), _at_most(at.hazardous), walks)
            table.add_row(*cells, f"{at.alert_limit_m:g}", *shares, *rates)
            cells = [""] * len(cells)
        table.add_section()
    return table


def fault_table(scores: Mapping[str, FaultScore], title: str) -> Table:
    """One row a fault: was it told, how soon, and what was said meanwhile."""
    columns = [
        "fault",
        "walks",
        "alarm",
        f"within\n{DETECTION_S:g} s",
        "median\ns",
        "missed",
        "usable",
        "hazar-\ndous",
        f"later\nthan {DETECTION_S:g} s",
        "without\nalarm",
    ]
    columns += ["in\nlevel", "error\nusable", "error\nat end", "way-\npoints", "clean", "APs\nfound", "wrongly\nout"]
    table = _table(title, columns)
    for fault, one in scores.items():
        table.add_row(
            fault,
            *(str(count) for count in (one.walks, one.alarmed, one.alarmed_in_time)),
            number(one.median_alert_s, 1),
            f"{one.missed} ({percent(ratio(one.missed, one.walks))})",
            percent(one.usable),
            percent(one.hazardous, 2),
            percent(one.hazardous_late, 2),
            percent(one.hazardous_unalerted, 2),
            percent(one.inside_level),
            *(number(m, 2) for m in (one.error_usable_m, one.error_end_m, one.waypoints_m, one.waypoints_clean_m)),
            percent(one.faulty_found, 0),
            percent(one.sound_excluded, 2),
        )
    return table


def fault_document(scores: Mapping[float, Mapping[str, Mapping[str, FaultScore]]]) -> dict[str, Any]:
    """The campaign as JSON: `limits.<alert limit>.<method>.<fault>`; null where there is none."""
    written: dict[str, Any] = plain({"limits": {f"{limit_m:g}": rows for limit_m, rows in scores.items()}})
    return written


def document(answers: Mapping[str, Sequence[Answer]], protocol: Protocol) -> dict[str, Any]:
    """Every figure as JSON: `methods.<method>.all`, `.integrity`, `.floors.<floor>`, `.folds.<fold>`; null: none."""
    methods = {}
    for name, found in answers.items():
        methods[name] = {
            "all": score(found),
            "integrity": integrity(found),
            "floors": {
                floor: score([a for a in found if a.floor == floor]) for floor in sorted({a.floor for a in found})
            },
            "folds": {str(fold): score([a for a in found if a.fold == fold]) for fold in protocol.tested},
        }
    written: dict[str, Any] = plain({"protocol": protocol, "iso_18305": ISO_18305, "methods": methods})
    return written


def _parts(answer: Answer) -> tuple[str, str]:
    return f"floor {answer.floor}", f"fold {answer.fold}"


def _table(title: str, columns: Sequence[str]) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for index, column in enumerate(columns):
        table.add_column(column, justify="right" if index else "left", no_wrap=True)
    return table


def _error_cells(errors: Errors) -> list[str]:
    values = (errors.mean_m, errors.rms_m, errors.median_m, errors.p75_m, errors.p95_m)
    return [str(errors.n), *(number(value, 2) for value in values)]


def _at_least(one: Share) -> str:
    return f"{percent(one.share)} (>={percent(one.lower_95)})"


def _at_most(one: Share) -> str:
    return f"{percent(one.share, 2)} (<={percent(one.upper_95, 2)})"
