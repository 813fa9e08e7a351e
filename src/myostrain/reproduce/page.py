"""The page: one HTML file with everything inside, formulas as MathML, no network."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from myostrain.reproduce.chapters import groups, names
from myostrain.reproduce.content import Chapter, Statement
from myostrain.reproduce.formulas import mathml
from myostrain.reproduce.words import number

import jinja2
import numpy as np
from markdown_it import MarkdownIt
from markupsafe import Markup
from mdit_py_plugins.dollarmath import dollarmath_plugin

#: Of a verdict: the class of its badge, and its sign for those who do not see colours.
BADGES = {
    "agrees": ("good", "✓"),
    "agrees with a reading": ("reading", "≈"),
    "does not agree": ("bad", "✗"),
}


def html_page(chapters: Mapping[str, Chapter], figures: Path, numbers: Mapping[str, Any]) -> str:
    """The whole page.

    Args:
        chapters: The chapters by name.
        figures: Folder of the PNG files, which are put into the page.
        numbers: What ``numbers.json`` holds: settings and versions are shown.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("myostrain.reproduce", "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "text": text,
        "inline": inline,
        "cell": cell,
        "picture": lambda name: _data_url(figures / f"{name}.png"),
        "outcome": outcome,
        "badge": lambda verdict: BADGES[verdict.kind],
    }
    every = [s for chapter in chapters.values() for s in chapter.statements]
    answers = [s.verdict.kind for s in every if s.claim.answer]
    flags = " --quick" if numbers["settings"] == "quick" else ""
    return environment.get_template("page.html.j2").render(
        chapters=chapters,
        numbers=numbers,
        counts={kind: sum(kind == s.verdict.kind for s in every if not s.claim.answer) for kind in BADGES},
        answers=len(answers),
        borne_out=len(answers) - answers.count("does not agree"),
        flags=flags,
        parts=_parts(list(chapters)),
        badges=BADGES,
    )


def _parts(shown: list[str]) -> str:
    """What to write after the command for these chapters: a group's name where they are all of a group."""
    whole = [name for name, members in groups().items() if members == shown]
    return "" if shown == names() else "".join(f" {name}" for name in whole or shown)


def _markdown() -> MarkdownIt:
    markdown = MarkdownIt("commonmark", {"html": False, "typographer": True})
    return markdown.enable("table").use(
        dollarmath_plugin, renderer=_mathml, double_inline=True, allow_digits=False
    )


def _mathml(formula: str, options: Mapping[str, Any]) -> str:
    return mathml(formula, display=options["display_mode"])


def text(markdown: str) -> Markup:
    """Markdown with formulas as HTML."""
    return Markup(_markdown().render(markdown))


def inline(markdown: str) -> Markup:
    """One line of Markdown with formulas as HTML, without a paragraph around it."""
    return Markup(_markdown().renderInline(markdown))


def cell(value: str | float | None) -> Markup:
    """A cell of a table: four significant digits, a dash where there is no number."""
    if isinstance(value, str):
        return inline(value)
    if value is None or not np.isfinite(value):
        return Markup("–")
    if isinstance(value, int):
        return Markup("%d") % value
    return Markup("%s") % number(value, digits=4)


def outcome(statement: Statement) -> str:
    """The verdict in words; an answer of ours is borne out or not."""
    verdict, asked = statement.verdict, bool(statement.claim.answer)
    if verdict.kind == "agrees":
        return "borne out" if asked else "agrees"
    if verdict.kind == "agrees with a reading":
        return f"{'borne out' if asked else 'agrees'} with a reading that we name: {verdict.reading}"
    parts = [
        f"{name.replace('_', ' ')} {'none' if value is None else number(value)}"
        f" (the claim: {_interval(*statement.claim.bounds[name])})"
        for name, value in statement.claim.failing(verdict.numbers).items()
    ]
    return f"{'not borne out' if asked else 'does not agree'}: measured " + ", ".join(parts)


def _interval(low: float, high: float) -> str:
    if np.isinf(low):
        return f"at most {number(high)}"
    return f"at least {number(low)}" if np.isinf(high) else f"{number(low)} to {number(high)}"


def _data_url(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()
