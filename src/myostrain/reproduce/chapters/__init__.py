"""The chapters of the page, in the paper's order; a module each, see ``ChapterModule``."""

import importlib
from typing import cast

from myostrain.reproduce.content import ChapterModule

#: Modules, in the order of the page.
_MODULES = (
    "springs",
    "fronts",
    "figure_1",
    "viscosity",
    "startup",
    "figure_2",
    "figure_3",
    "viscous_sheet",
)


def names() -> list[str]:
    """What the chapters are called, in the order of the page."""
    return [name.replace("_", "-") for name in _MODULES]


def module(name: str) -> ChapterModule:
    """The module of a chapter."""
    return cast(ChapterModule, importlib.import_module(f"{__name__}.{name.replace('-', '_')}"))
