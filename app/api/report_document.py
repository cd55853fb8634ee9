"""A report as one HTML file: its style, and the headers under which nothing from elsewhere is loaded."""

from __future__ import annotations

import base64
import hashlib
from html import escape

_STYLE = """
:root { color-scheme: light dark; --ink: #17212b; --quiet: #5a6876; --line: #dde3e9; --page: #f3f5f7; --card: #fff;
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6edf3; --quiet: #9aa9b7; --line: #2a3742; --page: #10161c; --card: #18212a; }
}
body { margin: 0; background: var(--page); color: var(--ink); }
main { max-width: 76rem; margin: 0 auto; padding: 1.5rem 1.2rem 3rem; }
h1 { margin: 0; font-size: 1.5rem; letter-spacing: -.01em; }
h2 { margin: 0 0 .5rem; font-size: 1.05rem; }
p { margin: .2rem 0 1rem; color: var(--quiet); }
section { margin-top: 1rem; padding: 1rem 1.2rem; border: 1px solid var(--line); border-radius: 12px;
  background: var(--card); }
section > table + p { margin: .6rem 0 0; }
section > p { max-width: 60rem; margin-bottom: .7rem; font-size: .9rem; }
dl { display: grid; grid-template-columns: repeat(auto-fit, minmax(8.4rem, 1fr)); gap: 1px; margin: 1rem 0 0;
  border: 1px solid var(--line); border-radius: 12px; overflow: hidden; background: var(--card); }
dl div { padding: .7rem .9rem; outline: 1px solid var(--line); }
dt { color: var(--quiet); font-size: .8rem; }
dd { margin: 0; font-size: 1.4rem; font-weight: 650; font-variant-numeric: tabular-nums; }
dd small { display: block; font-size: .8rem; font-weight: 400; color: var(--quiet); }
img { display: block; width: 100%; height: auto; border-radius: 6px; }
.tables { display: grid; grid-template-columns: repeat(auto-fit, minmax(30rem, 1fr)); gap: 0 1rem; align-items: start; }
table { width: 100%; border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th { color: var(--quiet); font-size: .78rem; font-weight: 500; text-align: left; }
td, th { padding: .25rem .6rem .25rem 0; border-top: 1px solid var(--line); }
thead th { border-top: 0; }
.number { text-align: right; }
@media (max-width: 40rem) { .tables { grid-template-columns: minmax(0, 1fr); } section { overflow-x: auto; } }
"""
STYLE_SOURCE = f"'sha256-{base64.b64encode(hashlib.sha256(_STYLE.encode()).digest()).decode()}'"
"""The style in a Content-Security-Policy."""
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
        f"style-src {STYLE_SOURCE}"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "private, no-cache",
}


def document(title: str, body: str, head: str = "") -> bytes:
    """A page. title : text.  body, head : markup."""
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">{head}
<title>{escape(title)}</title><style>{_STYLE}</style></head>
<body><main>{body}</main></body></html>
""".encode()
