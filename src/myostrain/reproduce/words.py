"""The words of a chapter: templates in ``cases/paper/CHAPTER.toml`` that measured numbers are put into."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any


def number(value: float, digits: int = 3) -> str:
    """A number with so many significant digits, very small and large ones with a power of ten."""
    if value != 0 and not 1e-3 <= abs(value) < 1e5:
        mantissa, power = f"{value:.1e}".split("e")
        return f"{mantissa.replace('-', '−')} × 10{_raised(int(power))}"
    return (f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}").replace("-", "−")


def _raised(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def fixed(value: float, digits: int) -> str:
    """A number with so many decimals."""
    return f"{float(value):.{digits}f}"


def percent(value: float, digits: int) -> str:
    """A share in percent with so many decimals: "12.3 %"."""
    return f"{100 * value:.{digits}f} %"


def more(ratio: float, larger: str, smaller: str) -> str:
    """How far a ratio is from one, in words: "12.3 % longer"."""
    return f"{percent(abs(ratio - 1), 1)} {larger if ratio > 1 else smaller}"


def change(ratio: float) -> str:
    """How far a ratio is from one, in percent: "+9.0 %"."""
    return f"{100 * (ratio - 1):+.1f} %".replace("-", "−")


#: What a template may write after "|", beside Jinja's own filters.
FILTERS: dict[str, Callable[..., str]] = {
    "number": number,
    "fixed": fixed,
    "percent": percent,
    "more": more,
    "change": change,
    "g": lambda value, digits=6: f"{float(value):.{digits}g}",
    "thousands": lambda value: f"{float(value):,.0f}",
}


#: A line of nothing but statements, which leaves no line behind. After others on a line a new one begins.
ALONE = re.compile(r"^[ \t]*((?:\{%(?:(?!%\}).)*%\}[ \t]*)+)\n", re.MULTILINE)


@cache
def _environment() -> Any:
    import jinja2

    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, lstrip_blocks=True)
    environment.filters |= FILTERS
    return environment


def filled(template: str, values: Mapping[str, Any]) -> str:
    """A template of Jinja with its numbers put in.

    Args:
        template: Markdown with formulas between dollar signs and expressions between double braces.
        values: What the expressions may name.

    Raises:
        jinja2.UndefinedError: An expression names something else.
    """
    made: str = _environment().from_string(ALONE.sub(r"\1", template)).render(values)
    return made
