"""How the figures look, in one place; no pyplot, so that a notebook's backend stays as it is."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from myostrain.output.figures.choice import choice
from myostrain.output.folder import write_atomically, writing

import matplotlib.style
import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from PIL import Image

#: Colours that people with any colour vision tell apart (Okabe and Ito 2008), dark ones first.
BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
GREY = "#8c8c8c"
#: Colour maps: the potential and times; what has a sign.
SEQUENTIAL, DIVERGING = "viridis", "RdBu_r"
#: Ends of the scale of a potential that rests at 0 and peaks near 1.
POTENTIAL = (-0.2, 1.0)
#: A potential that rises above this is not cut at 1: some sets of Fenton and Karma have 1.2 to 1.3.
PLATEAU = 1.15

_STYLE = {
    "axes.edgecolor": "#444444",
    "axes.grid": False,
    "axes.labelcolor": "#222222",
    "axes.labelsize": 10,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 11,
    "figure.facecolor": "white",
    "figure.titlesize": 12,
    "font.size": 10,
    "image.cmap": SEQUENTIAL,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
    "text.color": "#222222",
    "xtick.color": "#444444",
    "xtick.labelsize": 9,
    "ytick.color": "#444444",
    "ytick.labelsize": 9,
}


@contextmanager
def style() -> Iterator[None]:
    """Draw in the package's style, and in the one that is wanted; the user's settings are back afterwards."""
    wanted = [choice().style] if choice().style else []
    with matplotlib.style.context(["default", _STYLE, *wanted]):
        yield


def new_figure(
    width: float, height: float, title: str = "", *, dpi: int | None = None, compress: bool = False
) -> Figure:
    """An empty figure that draws without a screen.

    Args:
        width: Width in inches.
        height: Height in inches.
        title: Its title, taken literally and broken into lines that fit.
        dpi: Dots per inch; those of :func:`~myostrain.output.figures.choice.choice` by default.
        compress: Whether to leave no gaps beside panels of fixed proportions.
    """
    layout = ConstrainedLayoutEngine(compress=compress, w_pad=0.08, h_pad=0.06)
    figure = Figure(figsize=(width, height), dpi=dpi or choice().dpi, layout=layout)
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(textwrap.fill(plain(title), max(20, int(11 * width))))
    return figure


def save(figure: Figure, path: Path) -> Path:
    """Write a figure, the whole page and nothing cropped.

    A PNG is written in each format of :func:`~myostrain.output.figures.choice.choice`, beside each other.

    Args:
        figure: The figure.
        path: Where to, replaced if it exists.

    Returns:
        The path.

    Raises:
        InputError: It cannot be written.
    """
    for each in [path.with_suffix(f".{f}") for f in choice().formats] if path.suffix == ".png" else [path]:
        content = io.BytesIO()
        figure.savefig(content, dpi=choice().dpi, format=each.suffix.removeprefix(".") or "png")
        with writing(each):
            write_atomically(each, content.getvalue())
    return path


def save_film(images: Sequence[Image.Image], paces: Sequence[int], path: Path) -> Path:
    """Write a film.

    Args:
        images: Its pictures.
        paces: Milliseconds that each is shown.
        path: Where to, replaced if it exists.

    Returns:
        The path.

    Raises:
        InputError: It cannot be written.
    """
    content = io.BytesIO()
    images[0].save(
        content,
        format="GIF",
        save_all=True,
        append_images=images[1:],
        duration=list(paces),
        loop=0,
        optimize=False,
    )
    with writing(path):
        write_atomically(path, content.getvalue())
    return path


def plain(text: str) -> str:
    """Text that is shown as it stands: a dollar sign begins no formula."""
    return text.replace("$", r"\$")


def at_time(time: float) -> str:
    """The line that says when: "t = 0.35"."""
    return f"$t$ = {time:.4g}"


def potential_range(v: npt.NDArray[np.float64]) -> tuple[float, float]:
    """Ends (low, high) of the colour scale and the axis of a potential.

    They are −0.2 and 1, the same in every figure, for the potentials of models without dimension, and more
    where a plateau is clearly above 1; the data's own extremes for others, say in millivolt.

    Args:
        v: Potential, any shape, not empty.
    """
    low, high = float(np.nanmin(v)), float(np.nanmax(v))
    if not (low > -1 and high < 2):
        return low, high
    return POTENTIAL if high < PLATEAU else (POTENTIAL[0], high)


def symmetric_range(values: npt.NDArray[np.float64]) -> tuple[float, float]:
    """Ends (−a, a) of a colour scale for values of both signs.

    Args:
        values: Values, any shape, not empty; the outermost two in a thousand do not count, as stress peaks
            at corners would hide all else.
    """
    size = float(np.nanquantile(np.abs(values), 0.998)) or 1.0
    return -size, size


def extend(norm: Normalize, values: npt.NDArray[np.float64]) -> str:
    """Which ends of a colour bar to draw pointed, as values lie beyond: "neither", "min", "max" or "both"."""
    low, high = float(norm.vmin or 0.0), float(norm.vmax or 0.0)
    slack = 0.01 * (high - low)
    below, above = bool(np.nanmin(values) < low - slack), bool(np.nanmax(values) > high + slack)
    return {(False, False): "neither", (True, False): "min", (False, True): "max"}.get((below, above), "both")
