"""Runs beside each other: metrics with differences, what their cases differ in, a picture, a page."""

from __future__ import annotations

import base64
import csv
import html
import io
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.errors import InputError
from myostrain.output.datasets import dataset
from myostrain.output.folder import check_path, write_atomically, writing
from myostrain.output.opening import Results
from myostrain.output.opening import open as open_results
from myostrain.output.page import page, table
from myostrain.output.reader import Reader

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

#: Keys that say nothing of what was computed.
UNTOLD = ("name", "title", "cost")

#: Units of metrics whose size alone says that they are zero, and up to which value.
DIMENSIONLESS, ROUNDING = ("1", "degree"), 1e-10


def compare(*folders: str | Path | Results) -> Comparison:
    """Put runs beside each other; no solver is loaded.

    Args:
        folders: Result folders, or runs that :func:`myostrain.open` has read; the others are compared with
            the first. What of a run that has not reached its end there is, is compared too.

    Raises:
        InputError: There are not two, or one is not a result folder.
    """
    if len(folders) < 2:
        raise InputError("name two result folders at least", "DIR")
    return Comparison([f if isinstance(f, Results) else open_results(f, unfinished=True) for f in folders])


class Comparison:
    """Runs beside each other: see :func:`compare`.

    Attributes:
        runs: The runs.
        names: What they are called: their folders' names, with as much of the path as tells them apart.
        case: By dotted key the values of all runs, where their cases differ; None where a case has no such
            key.
    """

    def __init__(self, runs: Sequence[Results]) -> None:
        self.runs, self.names = list(runs), _names([run.folder for run in runs])
        trees = [dict(flat({k: v for k, v in run.case.items() if k not in UNTOLD})) for run in runs]
        keys = dict.fromkeys(key for tree in trees for key in tree)
        values = {key: [tree.get(key) for tree in trees] for key in keys}
        self.case = {key: found for key, found in values.items() if any(v != found[0] for v in found)}

    @cached_property
    def metrics(self) -> xr.Dataset:
        """Metrics over ``run``, with units; NaN where a run has none.

        ``metrics - metrics.isel(run=0)`` are the differences.
        """
        variables = {}
        for name, (unit, values) in self._metrics().items():
            numbers = [np.nan if value is None else value for value in values]
            variables[name] = ("run", numbers, {"units": unit} if unit else {})
        return dataset(variables, {"run": self.names})

    def _metrics(self) -> dict[str, tuple[str, list[float | None]]]:
        """Unit and values by name, of those that a run has at all."""
        names = dict.fromkeys(name for run in self.runs for name in run.metrics)
        found = {}
        for name in names:
            units = {run.metrics.units.get(name, "") for run in self.runs if name in run.metrics}
            values = [run.metrics.get(name) for run in self.runs]
            if any(value is not None for value in values):
                numbers = [None if value is None else float(value) for value in values]
                found[name] = (" or ".join(sorted(units)), numbers)
        return found

    def rows(self) -> list[list[str]]:
        """One row per metric, as text: name, unit, the first value, each other value and difference."""
        return [
            [name, "" if unit == "1" else unit, _number(values[0])]
            + [
                text
                for value in values[1:]
                for text in (_number(value), _difference(values[0], value, self._least(name)))
            ]
            for name, (unit, values) in self._metrics().items()
        ]

    def _least(self, name: str) -> float:
        """Values of a metric up to this are zero but for rounding: forces that cancel, small pure numbers."""
        if name.startswith("reaction_"):
            return max(run.least_force for run in self.runs)
        return ROUNDING if self._metrics()[name][0] in DIMENSIONLESS else 0.0

    def head(self) -> list[str]:
        """What the columns of :meth:`rows` are."""
        others = [text for name in self.names[1:] for text in (name, f"less {self.names[0]}")]
        return ["metric", "unit", self.names[0], *others]

    def case_rows(self) -> list[list[str]]:
        """One row per key, as text: the key and the value of each run."""
        return [
            [key, *("–" if value is None else _short(value) for value in values)]
            for key, values in self.case.items()
        ]

    def __repr__(self) -> str:
        """Tables of what the cases differ in, and of the metrics."""
        lines = (
            _aligned([["key", *self.names], *self.case_rows()]) if self.case else ["the cases are the same"]
        )
        return "\n".join([*lines, "", *_aligned([self.head(), *self.rows()])])

    def _repr_html_(self) -> str:
        return table(["key", *self.names], self.case_rows()) + table(self.head(), self.rows())

    def draw(self, path: str | Path) -> Path | None:
        """Draw the potential at the probes and the measures of all runs over each other.

        Args:
            path: The picture; its ending says the format.

        Returns:
            The path; None if there is nothing that two runs share.

        Raises:
            InputError: It cannot be written.
        """
        from myostrain.output.figures.comparison import draw_comparison

        return draw_comparison(self.runs, self.names, Path(path))

    def draw_loops(self, path: str | Path) -> Path | None:
        """Draw the pressure–volume loops of the last beats of all runs over each other, one panel per cavity.

        Args:
            path: The picture; its ending says the format.

        Returns:
            The path; None if there are not two runs with cavities.

        Raises:
            InputError: It cannot be written.
        """
        from myostrain.output.figures.loops_beside import draw_loops_beside

        readers = [Reader(run.folder) for run in self.runs]
        runs = list(zip(self.names, readers, strict=True))
        return next(iter(draw_loops_beside(runs, Path(path), least=2)), None)

    def write(self, out: str | Path, *, page: bool = False) -> list[Path]:
        """Write ``metrics.csv`` and pictures into a folder, and on request all on one page.

        The pictures are ``compare.png`` and, of runs with cavities, ``loops.png``.

        Args:
            out: The folder, made if it is not there; files of an earlier comparison are replaced.
            page: Whether to write ``index.html`` too, which needs no other file and no network.

        Returns:
            The files written.

        Raises:
            InputError: It is a result folder, or cannot be written.
        """
        out = Path(out)
        check_path(out, "--out")
        if any((out / name).exists() for name in ("results.json", "case.toml", "sweep.json")):
            raise InputError(f"{out} is a result folder; name another", "--out")
        with writing(out):
            out.mkdir(parents=True, exist_ok=True)
            write_atomically(out / "metrics.csv", self._csv())
        drawn = {
            "Probes and measures over time": self.draw(out / "compare.png"),
            "Pressure–volume loops": self.draw_loops(out / "loops.png"),
        }
        pictures = {title: path for title, path in drawn.items() if path is not None}
        written = [out / "metrics.csv", *pictures.values()]
        if page:
            with writing(out):
                write_atomically(out / "index.html", self._page(pictures))
            written.append(out / "index.html")
        return written

    def _csv(self) -> str:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        others = [column for name in self.names[1:] for column in (name, f"{name} less {self.names[0]}")]
        writer.writerow(["metric", "unit", self.names[0], *others])
        for name, (unit, values) in self._metrics().items():
            first = values[0]
            cells = ["" if first is None else f"{first:.9g}"]
            for value in values[1:]:
                cells.append("" if value is None else f"{value:.9g}")
                cells.append("" if value is None or first is None else f"{value - first:.9g}")
            writer.writerow([name, unit, *cells])
        return text.getvalue()

    def _page(self, pictures: Mapping[str, Path]) -> str:
        about = [
            [name, run.title, str(run.folder.resolve()), "" if run.finished else "not finished"]
            for name, run in zip(self.names, self.runs, strict=True)
        ]
        parts = [table(["run", "case", "folder", ""], about)]
        same = "<p>The cases are the same.</p>"
        differing = table(["key", *self.names], self.case_rows()) if self.case else same
        parts += ["<h2>What the cases differ in</h2>", differing]
        parts += ["<h2>Metrics</h2>", table(self.head(), self.rows())]
        for title, picture in pictures.items():
            content = base64.b64encode(picture.read_bytes()).decode()
            parts += [f"<h2>{title}</h2>", f'<img alt="{title}" src="data:image/png;base64,{content}">']
        return page(f"{', '.join(map(html.escape, self.names))}: compared", "\n".join(parts))


def flat(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys and values of nested dictionaries."""
    for key, value in tree.items():
        if isinstance(value, Mapping) and value:
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _names(folders: Sequence[Path]) -> list[str]:
    """The shortest ends of paths that tell them apart."""
    parts = [folder.resolve().parts for folder in folders]
    for count in range(1, max(map(len, parts)) + 1):
        names = ["/".join(part[-count:]) for part in parts]
        if len(set(names)) == len(names):
            return names
    return [f"{number}: {folder.resolve().name}" for number, folder in enumerate(folders, start=1)]


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.5g}"


def _difference(first: float | None, value: float | None, least: float) -> str:
    """A difference, and its share of the first value; of what is zero but for rounding there is none."""
    if first is None or value is None:
        return "–"
    if value == first:
        return "same"
    if max(abs(first), abs(value)) <= least:
        return "rounding"
    share = f" ({100 * (value - first) / abs(first):+.3g} %)" if first else ""
    return f"{value - first:+.3g}{share}"


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(f"{c:{w}}" for c, w in zip(row, widths, strict=True)).rstrip() for row in rows]
