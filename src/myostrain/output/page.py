"""HTML that needs nothing beside it: tables, and a page."""

from __future__ import annotations

import html
from collections.abc import Sequence

_STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
table { border-collapse: collapse; display: block; overflow-x: auto; }
td, th { padding: .2rem .8rem .2rem 0; text-align: left; white-space: nowrap;
  font-variant-numeric: tabular-nums; border-bottom: 1px solid #8884; }
img { max-width: 100%; background: white; }
"""


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; without a head if that is empty. Texts are taken literally."""

    def row(cells: Sequence[str], tag: str) -> str:
        inner = "".join(f'<{tag} style="text-align:left">{html.escape(cell)}</{tag}>' for cell in cells)
        return f"<tr>{inner}</tr>"

    return f"<table>{row(head, 'th') if head else ''}{''.join(row(cells, 'td') for cells in rows)}</table>"


def page(title: str, body: str) -> str:
    """A page in itself.

    Args:
        title: Its title, HTML.
        body: What stands below, HTML.
    """
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{_STYLE}</style></head>\n"
        f"<body><h1>{title}</h1>\n{body}\n</body></html>\n"
    )
