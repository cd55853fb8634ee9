"""A quality report as a page: one file, with the picture within and nothing from elsewhere."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from html import escape
from typing import Any

from app.api.report_document import document
from app.services.quality_description import MOST_NAMED

_TOO_FEW = "too few walks"
_OF_FLOOR_SHOWN, _ACCESS_POINTS_SHOWN = 8, 16


def page_of(venue: str, told: dict[str, Any], picture: bytes) -> bytes:
    """The report of a version. told : as in JSON.  picture : PNG."""
    made = datetime.fromtimestamp(told["created"] / 1000.0, UTC).strftime("%Y-%m-%d %H:%M UTC")
    counts = f"{_count(told['fingerprints'], 'WiFi fingerprint')} of {_count(told['walks'], 'walk')}. Made {made}."
    address = f"<code>/v1/venues/{escape(venue)}/radio-maps/{told['version']}/quality</code>"
    body = f"""<h1>{escape(venue)}, radio map version {told["version"]}</h1>
<p>{counts} As JSON: {address}</p>
{_figures(told)}
<section><h2>Over the plan</h2>
<p>Left: survey walks placed by the others, one scan at a time, without a filter: where it is dark, phones will be
placed worse. Middle: what the service promises of the same scans, one by one; sessions do better. Right: what was not
surveyed, places that one scan cannot tell apart, and where use has shown that the survey no longer holds.</p>
<img src="data:image/png;base64,{
        base64.b64encode(picture).decode()
    }" alt="Error, protection level and open ends over each floor's plan"></section>
{_resurvey(told["drift"])}
{_floors(told["floors"])}
<div class="tables">{_gaps(told["floors"])}{_look_alikes(told["floors"])}{_unsteady(told["access_points"])}{
        _watched(told["drift"])
    }</div>"""
    return document(f"{venue}, radio map version {told['version']}", body)


def waiting_page(venue: str, version: int, again_s: int | None) -> bytes:
    """What is shown until the report is made. again_s : when it loads itself again; None where it would be refused."""
    title = f"{venue}, radio map version {version}"
    told = "Ask again for it." if again_s is None else "This page looks again by itself."
    body = f"<h1>{escape(title)}</h1><p>The report is being made, which takes up to a minute. {told}</p>"
    return document(title, body, "" if again_s is None else f'<meta http-equiv="refresh" content="{again_s}">')


def _figures(told: dict[str, Any]) -> str:
    error, level, drift = told["error"], told["level"], told["drift"]
    area = sum(floor["coverage"]["area"] for floor in told["floors"])
    covered = sum(floor["coverage"]["area"] * floor["coverage"]["covered"] for floor in told["floors"])
    figures = {
        "mean error": _metres(error["mean"]),
        "95 % within": _metres(error["quantile_95"]),
        f"level at {level['risk']:g}": f"{_metres(level['median'])} <small>holds {_percent(level['inside'])}</small>",
        "wrong floor": _percent(error["wrong_floor"] / error["scans"] if error["scans"] > error["unplaced"] else None),
        "covered": f"{100.0 * covered / area:.0f} %" if area else "–",
        "smallest risk": f"{_smallest(told['risk'])} <small>of {_count(told['risk']['walks'], 'walk')}</small>",
        "drift": f"{_times(drift['score'])} <small>{len(drift['resurvey'])} of {drift['squares']} squares</small>",
        "watched": f"{100.0 * drift['watched_share']:.1f} % <small>of access points</small>",
    }
    return "<dl>" + "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in figures.items()) + "</dl>"


def _floors(floors: Sequence[dict[str, Any]]) -> str:
    risks = list(floors[0]["risk"]["levels"]) if floors else []
    rows = [
        [
            escape(floor["floor"]),
            str(floor["scans"]),
            str(floor["risk"]["walks"]),
            _metres(floor["error"]["mean"]),
            _metres(floor["error"]["quantile_95"]),
            _metres(floor["level"]["median"]),
            _percent(floor["level"]["inside"]),
            f"{100.0 * floor['coverage']['covered']:.0f} %",
            _smallest(floor["risk"]),
            *(
                _TOO_FEW if floor["risk"]["levels"][risk] is None else _metres(floor["risk"]["levels"][risk])
                for risk in risks
            ),
        ]
        for floor in floors
    ]
    names = ["Floor", "Scans", "Walks", "Mean error", "95 % within", "Level", "Holds", "Covered", "Smallest risk"]
    told = (
        "Level: the median of single scans, and how many of their errors it holds. To calibrate one at some risk takes "
        "1 / risk - 1 walks. The last columns say what a further walk's worst single scan would stay within."
    )
    return _table("Floors", told, [*names, *(f"at risk {risk}" for risk in risks)], rows, words=1)


def _gaps(floors: Sequence[dict[str, Any]]) -> str:
    rows = [
        [escape(floor["floor"]), _at(gap), f"{gap['area']:.0f} m²", _metres(gap["distance"])]
        for floor in floors
        for gap in floor["coverage"]["gaps"][:_OF_FLOOR_SHOWN]
    ]
    cut = _cut((floor["coverage"]["gaps"] for floor in floors), _OF_FLOOR_SHOWN, f"{MOST_NAMED} of a floor")
    told = "Walk here: the place of each gap that is farthest from any survey scan."
    return _table("Coverage gaps", told, ["Floor", "x, y", "Area", "From the next scan"], rows, 2, cut)


def _look_alikes(floors: Sequence[dict[str, Any]]) -> str:
    rows = [
        [*(f"{escape(place['floor'])} {_at(place)}" for place in pair["places"]), _metres(pair["apart"])]
        for floor in floors
        for pair in floor["look_alikes"]["listed"][:_OF_FLOOR_SHOWN]
    ]
    cut = _cut((floor["look_alikes"]["listed"] for floor in floors), _OF_FLOOR_SHOWN, f"{MOST_NAMED} of a floor")
    told = "One scan cannot tell these apart. More access points there would."
    return _table("Look-alike places", told, ["One", "Other", "Apart"], rows, 2, cut)


def _unsteady(access_points: dict[str, Any]) -> str:
    rows = [
        [f"<code>{escape(one['bssid'])}</code>", f"{one['spread']:.1f} dB", str(one["repeats"])]
        for one in access_points["listed"][:_ACCESS_POINTS_SHOWN]
    ]
    cut = _cut([access_points["listed"]], _ACCESS_POINTS_SHOWN, str(MOST_NAMED))
    told = f"{access_points['unsteady']} of {access_points['judged']} differ from walk to walk at the same place"
    if access_points["limit"] is not None:
        told += f" by more than {access_points['limit']:.1f} dB, twice the median"
    return _table("Unsteady access points", told + ".", ["Access point", "Spread", "Repetitions"], rows, 1, cut)


def _resurvey(drift: dict[str, Any]) -> str:
    rows = [
        [
            f"{escape(one['floor'])} {_at(one)}",
            escape(one["reason"]),
            _times(one["ratio"]),
            f"{one['score']:.1f}",
            str(one["sessions"]),
            str(one["scans"]),
            str(one["unfit"]),
            str(one["surveyed"]),
            _day(one["last"]),
        ]
        for one in drift["resurvey"]
    ]
    told = (
        f"Squares in which scans in use, since {_day(drift['since'])}, are more unlike the map than survey walks that "
        f"were left out of it. {drift['squares']} were used by enough sessions to tell."
    )
    names = ["Place", "Reason", "Unlike", "Score", "Sessions", "Scans", "Unfit", "Survey scans", "Last"]
    return _table("Survey here again", told, names, rows, words=2)


def _watched(drift: dict[str, Any]) -> str:
    rows = [
        [f"<code>{escape(one['bssid'])}</code>", escape(one["reason"]), f"{escape(one['floor'])} {_at(one)}"]
        for one in drift["access_points"][:_ACCESS_POINTS_SHOWN]
    ]
    cut = _cut([drift["access_points"]], _ACCESS_POINTS_SHOWN)
    told = "On the watch list and left out of every session, and where each was heard strongest."
    return _table("Watched access points", told, ["Access point", "Reason", "Place"], rows, 3, cut)


def _cut(listed: Iterable[Sequence[Any]], shown: int, most: str = "") -> str:
    """What of some lists is not shown, and where it is. most : what the JSON itself names at most."""
    lengths = [len(one) for one in listed]
    left = sum(max(length - shown, 0) for length in lengths)
    if not left:
        return ""
    return f"{left} more: see the JSON" + (f", which names up to {most}." if most and MOST_NAMED in lengths else ".")


def _table(
    title: str, told: str, names: Sequence[str], rows: Iterable[Sequence[str]], words: int, cut: str = ""
) -> str:
    """A section. words : how many columns are text; those after them are numbers. Cells are markup.  cut : what is said
    of rows that are left out."""
    lines = [
        "<tr>" + "".join(f"<td{_aligned(at, words)}>{cell}</td>" for at, cell in enumerate(row)) + "</tr>"
        for row in rows
    ]
    if not lines:
        return f"<section><h2>{title}</h2><p>{told}</p><p>None.</p></section>"
    head = "".join(f'<th scope="col"{_aligned(at, words)}>{name}</th>' for at, name in enumerate(names))
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(lines)}</tbody></table>"
    return f"<section><h2>{title}</h2><p>{told}</p>{table}{cut and f'<p>{cut}</p>'}</section>"


def _aligned(column: int, words: int) -> str:
    return ' class="number"' if column >= words else ""


def _at(place: dict[str, Any]) -> str:
    return f"{place['x']:.0f}, {place['y']:.0f}"


def _metres(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f} m"


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


def _smallest(risk: dict[str, Any]) -> str:
    return f"{risk['smallest']:.2g}" if risk["walks"] else "none yet"


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100.0 * share:.1f} %"


def _times(ratio: float | None) -> str:
    return "–" if ratio is None else f"{ratio:.1f} ×"


def _day(time_ms: int) -> str:
    return datetime.fromtimestamp(time_ms / 1000.0, UTC).strftime("%Y-%m-%d")
