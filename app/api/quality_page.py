"""A quality report as a page: one file, with the picture within and nothing from elsewhere."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from html import escape
from typing import Any

_STYLE = """
:root { color-scheme: light; --ink: #17212b; --quiet: #5a6876; --line: #dde3e9; --page: #f3f5f7;
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif; }
body { margin: 0; background: var(--page); color: var(--ink); }
main { max-width: 76rem; margin: 0 auto; padding: 1.5rem 1.2rem 3rem; }
h1 { margin: 0; font-size: 1.5rem; letter-spacing: -.01em; }
h2 { margin: 0 0 .5rem; font-size: 1.05rem; }
p { margin: .2rem 0 1rem; color: var(--quiet); }
section { margin-top: 1rem; padding: 1rem 1.2rem; border: 1px solid var(--line); border-radius: 12px;
  background: #fff; }
section > p { max-width: 60rem; margin-bottom: .7rem; font-size: .9rem; }
dl { display: grid; grid-template-columns: repeat(auto-fit, minmax(8.4rem, 1fr)); gap: 1px; margin: 1rem 0 0;
  border: 1px solid var(--line); border-radius: 12px; overflow: hidden; background: #fff; }
dl div { padding: .7rem .9rem; outline: 1px solid var(--line); }
dt { color: var(--quiet); font-size: .8rem; }
dd { margin: 0; font-size: 1.4rem; font-weight: 650; font-variant-numeric: tabular-nums; }
dd small { display: block; font-size: .8rem; font-weight: 400; color: var(--quiet); }
img { display: block; width: 100%; height: auto; }
.tables { display: grid; grid-template-columns: repeat(auto-fit, minmax(30rem, 1fr)); gap: 0 1rem; align-items: start; }
table { width: 100%; border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th { color: var(--quiet); font-size: .78rem; font-weight: 500; text-align: left; }
td, th { padding: .25rem .6rem .25rem 0; border-top: 1px solid var(--line); }
thead th { border-top: 0; }
.number { text-align: right; }
@media (max-width: 40rem) { .tables { grid-template-columns: minmax(0, 1fr); } section { overflow-x: auto; } }
"""
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
        f"style-src 'sha256-{base64.b64encode(hashlib.sha256(_STYLE.encode()).digest()).decode()}'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "private, no-cache",
}
_TOO_FEW = "too few walks"


def page_of(venue: str, told: dict[str, Any], picture: bytes) -> bytes:
    """The report of a version. told : as in JSON.  picture : PNG."""
    made = datetime.fromtimestamp(told["created"] / 1000.0, UTC).strftime("%Y-%m-%d %H:%M UTC")
    counts = f"{told['fingerprints']} survey scans of {told['walks']} walks. Made {made}."
    body = f"""<h1>{escape(venue)}, radio map version {told["version"]}</h1>
<p>{counts}</p>
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
    return _document(f"{venue}, radio map version {told['version']}", body)


def waiting_page(venue: str, version: int, again_s: int) -> bytes:
    """What is shown until the report is made; loads itself again."""
    title = f"{escape(venue)}, radio map version {version}"
    body = (
        f"<h1>{title}</h1><p>The report is being made, which takes up to a minute. This page looks again by itself.</p>"
    )
    return _document(f"{venue}, radio map version {version}", body, f'<meta http-equiv="refresh" content="{again_s}">')


def _document(title: str, body: str, head: str = "") -> bytes:
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">{head}
<title>{escape(title)}</title><style>{_STYLE}</style></head>
<body><main>{body}</main></body></html>
""".encode()


def _figures(told: dict[str, Any]) -> str:
    error, level, drift = told["error"], told["level"], told["drift"]
    area = sum(floor["coverage"]["area"] for floor in told["floors"])
    covered = sum(floor["coverage"]["area"] * floor["coverage"]["covered"] for floor in told["floors"])
    figures = {
        "mean error": _metres(error["mean"]),
        "95 % within": _metres(error["quantile_95"]),
        f"level at {level['risk']:g}": f"{_metres(level['median'])} <small>holds {_percent(level['inside'])}</small>",
        "wrong floor": f"{100.0 * error['wrong_floor'] / error['scans']:.1f} %" if error["scans"] else "–",
        "covered": f"{100.0 * covered / area:.0f} %" if area else "–",
        "smallest risk": f"{_significant(told['risk']['smallest'])} <small>of {told['risk']['walks']} walks</small>",
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
            _significant(floor["risk"]["smallest"]),
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
        for gap in floor["coverage"]["gaps"][:8]
    ]
    told = "Walk here: the place of each gap that is farthest from any survey scan."
    return _table("Coverage gaps", told, ["Floor", "x, y", "Area", "From the next scan"], rows, words=2)


def _look_alikes(floors: Sequence[dict[str, Any]]) -> str:
    rows = [
        [*(f"{escape(place['floor'])} {_at(place)}" for place in pair["places"]), _metres(pair["apart"])]
        for floor in floors
        for pair in floor["look_alikes"]["listed"][:8]
    ]
    told = "One scan cannot tell these apart. More access points there would."
    return _table("Look-alike places", told, ["One", "Other", "Apart"], rows, words=2)


def _unsteady(access_points: dict[str, Any]) -> str:
    rows = [
        [f"<code>{escape(one['bssid'])}</code>", f"{one['spread']:.1f} dB", str(one["repeats"])]
        for one in access_points["listed"][:16]
    ]
    told = f"{access_points['unsteady']} of {access_points['judged']} differ from walk to walk at the same place"
    if access_points["limit"] is not None:
        told += f" by more than {access_points['limit']:.1f} dB, twice the median"
    return _table("Unsteady access points", told + ".", ["Access point", "Spread", "Repetitions"], rows, words=1)


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
        for one in drift["access_points"][:16]
    ]
    told = "On the watch list and left out of every session, and where each was heard strongest."
    return _table("Watched access points", told, ["Access point", "Reason", "Place"], rows, words=3)


def _table(title: str, told: str, names: Sequence[str], rows: Iterable[Sequence[str]], words: int) -> str:
    """A section. words : how many columns are text; those after them are numbers. Cells are markup."""
    lines = [
        "<tr>" + "".join(f"<td{_aligned(at, words)}>{cell}</td>" for at, cell in enumerate(row)) + "</tr>"
        for row in rows
    ]
    if not lines:
        return f"<section><h2>{title}</h2><p>{told}</p><p>None.</p></section>"
    head = "".join(f'<th scope="col"{_aligned(at, words)}>{name}</th>' for at, name in enumerate(names))
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(lines)}</tbody></table>"
    return f"<section><h2>{title}</h2><p>{told}</p>{table}</section>"


def _aligned(column: int, words: int) -> str:
    return ' class="number"' if column >= words else ""


def _at(place: dict[str, Any]) -> str:
    return f"{place['x']:.0f}, {place['y']:.0f}"


def _metres(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f} m"


def _significant(value: float) -> str:
    return f"{value:.2g}"


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100.0 * share:.1f} %"


def _times(ratio: float | None) -> str:
    return "–" if ratio is None else f"{ratio:.1f} ×"


def _day(time_ms: int) -> str:
    return datetime.fromtimestamp(time_ms / 1000.0, UTC).strftime("%Y-%m-%d")
