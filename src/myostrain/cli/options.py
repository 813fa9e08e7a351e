"""Arguments and options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

CaseName = Annotated[
    str | None, typer.Argument(metavar="CASE|FILE.toml", help="A named case, or a case file.")
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Result folder; a new one under runs/ by default."),
]
Force = Annotated[bool, typer.Option("--force", help="Replace the results of an earlier run in DIR.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="A line every few seconds instead of a progress bar.")]
