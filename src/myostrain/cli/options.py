"""The order of the commands, and arguments and options that several have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

#: Commands in the order in which one comes to need them.
ORDER = (
    *("list", "show", "run", "sweep", "compare", "view", "plot", "export"),
    *("cell", "cable", "material", "reproduce", "doctor"),
)


class Ordered(TyperGroup):
    """The help lists the commands in this order."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands."""
        return sorted(super().list_commands(ctx), key=ORDER.index)


CaseName = Annotated[
    str | None, typer.Argument(metavar="CASE|FILE.toml", help="A named case, or a case file.")
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Result folder; a new one under runs/ by default."),
]
Force = Annotated[bool, typer.Option("--force", help="Replace the results of an earlier run in DIR.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="A line every few seconds instead of a progress bar.")]
