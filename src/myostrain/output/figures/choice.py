"""What a user wants of the pictures: formats, resolution, times, fields."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path

from myostrain.errors import InputError, nearest
from myostrain.output.folder import read_regular

#: Dots per inch of the still pictures.
DPI = 150

#: Formats of the still pictures.
FORMATS = ("pdf", "png", "svg")


@dataclass(frozen=True)
class Choice:
    """What is drawn, and how; by default everything, as PNG.

    Args:
        formats: Each picture is written in all of them.
        dpi: Dots per inch.
        times: Simulated times at which fields are shown; by default the last of a sheet, telling ones else.
        fields: Names of fields and of pictures; all that a folder is about by default.
        style: Name of a style of Matplotlib, or a file of one, on top of ours; ours alone by default.

    Raises:
        InputError: A format or style is not known, or a resolution cannot be.
    """

    formats: Sequence[str] = ("png",)
    dpi: int = DPI
    times: Sequence[float] = ()
    fields: Sequence[str] = ()
    style: str = ""

    def __post_init__(self) -> None:
        """Check."""
        for each in self.formats:
            if each not in FORMATS:
                raise InputError(f"no such format: '{each}'; {nearest(each, FORMATS)}", "--format")
        if not self.formats:
            raise InputError("give one at least, such as pdf", "--format")
        if not 20 <= self.dpi <= 2400:
            raise InputError(f"{self.dpi}: give dots per inch between 20 and 2400", "--dpi")
        if self.style:
            check_style(self.style)

    def wants(self, name: str) -> bool:
        """Whether a picture is to be drawn."""
        return not self.fields or name in self.fields

    @property
    def films(self) -> bool:
        """Whether to draw films, which have no times to choose and are no vectors."""
        return self.wants("animation") and not self.times and "png" in self.formats


def check_style(style: str) -> None:
    """Refuse what is neither a style of Matplotlib nor a file of one.

    Raises:
        InputError: It is neither, or the file cannot be read.
    """
    from matplotlib import rcParams
    from matplotlib import style as styles

    if style in styles.available or style == "default":
        return
    if not Path(style).is_file():
        known = nearest(style, styles.available)
        raise InputError(f"no such style of Matplotlib, and no such file: '{style}'; {known}", "--style")
    try:
        lines = [line.partition("#")[0].strip() for line in read_regular(Path(style)).decode().splitlines()]
        keys = [line.partition(":")[0].strip() for line in lines if line]
        with styles.context(style):
            pass
    except (OSError, ValueError) as error:
        words = " ".join(str(error).split())
        raise InputError(f"{style} cannot be read as a style of Matplotlib: {words}", "--style") from error
    for key in keys:  # Matplotlib goes on without those that it does not know
        if key not in rcParams:
            raise InputError(f"{style}: no such key; {nearest(key, list(rcParams))}", "--style")


_present: ContextVar[Choice] = ContextVar("choice", default=Choice())  # noqa: B039 - it is frozen


def choice() -> Choice:
    """What is wanted now."""
    return _present.get()


@contextmanager
def choosing(wanted: Choice) -> Iterator[None]:
    """Draw as is wanted."""
    token = _present.set(wanted)
    try:
        yield
    finally:
        _present.reset(token)
