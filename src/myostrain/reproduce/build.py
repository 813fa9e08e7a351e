"""From the chapters asked for to a folder with the page, its pictures and its numbers."""

from __future__ import annotations

import csv
import dataclasses
import io
import math
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from myostrain.engine import MPI, versions
from myostrain.errors import InputError, nearest
from myostrain.output.figures.style import save, style
from myostrain.output.folder import write_atomically, write_json, writing
from myostrain.reproduce import chapters
from myostrain.reproduce.content import Chapter
from myostrain.reproduce.jobs import Store, run_jobs


def reproduce(
    what: Sequence[str] = (),
    out: str | Path = "runs/reproduce",
    *,
    quick: bool = False,
    fresh: bool = False,
    workers: int | None = None,
    store: Path | None = None,
    tell: Callable[[str, float, float], None] = lambda name, done, total: None,
) -> dict[str, Any]:
    """Measure, judge, and write ``index.html``, ``figures/*.png``, ``data/*.csv`` and ``numbers.json``.

    Args:
        what: Chapters, or groups of them such as "open-questions"; all of them unless given.
        out: The folder; files of an earlier call are replaced.
        quick: Coarser settings; the page says which.
        fresh: Whether to compute anew what is kept from an earlier call.
        workers: Processes; as many as there are cores unless given.
        store: Where outcomes are kept; the user's cache folder unless given.
        tell: Is told the name of a computation that is done, and the cost done and in total.

    Returns:
        What ``numbers.json`` holds.

    Raises:
        InputError: A chapter does not exist, the folder cannot be written, several processes were started, or
            the libraries of the page are missing.
        ComputationError: A computation failed.
    """
    names = _chosen(what)
    if MPI.COMM_WORLD.size > 1:
        raise InputError("start it without mpiexec: it runs computations side by side itself", "reproduce")
    html_page = _page()
    out = Path(out)
    with writing(out):
        (out / "figures").mkdir(parents=True, exist_ok=True)
    begin = time.perf_counter()
    jobs = {name: chapters.jobs(name, quick) for name in names}
    found = run_jobs(
        {f"{name}: {job}": one for name, own in jobs.items() for job, one in own.items()},
        Store(store),
        workers=workers,
        fresh=fresh,
        tell=tell,
    )
    done: dict[str, Chapter] = {}
    for name, own in jobs.items():
        done[name] = chapters.chapter(name, {job: found[f"{name}: {job}"] for job in own}, quick)
    with style():
        for chapter in done.values():
            for picture in chapter.pictures:
                save(picture.draw(), out / "figures" / f"{picture.name}.png")
    for chapter in done.values():
        for table, columns in chapter.data.items():
            with writing(out):
                (out / "data").mkdir(exist_ok=True)
                write_atomically(out / "data" / f"{table}.csv", csv_text(columns))
    numbers: dict[str, Any] = plain_numbers(_numbers(done, quick))
    numbers["seconds"] = round(time.perf_counter() - begin, 1)
    with writing(out):
        write_json(out / "numbers.json", numbers)
        write_atomically(out / "index.html", html_page(done, out / "figures", numbers))
    return numbers


def _page() -> Callable[..., str]:
    """What makes the page; its libraries are looked for before anything is computed."""
    try:
        from myostrain.reproduce.page import html_page
    except ImportError as missing:
        advice = "pip install 'myostrain[page]'; in a checkout, uv sync --extra page"
        raise InputError(
            f"the page needs {missing.name}, which is not here: {advice}", "reproduce"
        ) from missing
    return html_page


def _chosen(what: Sequence[str]) -> list[str]:
    known, groups = chapters.names(), chapters.groups()
    wanted: set[str] = set()
    for name in what:
        if name not in known and name not in groups:
            raise InputError(f"no part is called '{name}'; {nearest(name, [*known, *groups])}", "WHAT")
        wanted |= set(groups.get(name, [name]))
    return [name for name in known if name in wanted or not what]


def _numbers(done: Mapping[str, Chapter], quick: bool) -> dict[str, Any]:
    """Every number and verdict, as JSON holds it."""
    return {
        "settings": "quick" if quick else "full",
        "versions": versions(),
        "chapters": {
            name: {
                "verdicts": {
                    statement.claim.name: {
                        "where": statement.claim.where,
                        "quote": statement.claim.quote,
                        "bounds": dict(statement.claim.bounds),
                        "because": statement.claim.because,
                        "answer": statement.claim.answer,
                        "source": statement.claim.source,
                        "sure": statement.claim.sure,
                        "verdict": statement.verdict.kind,
                        "reading": statement.verdict.reading,
                        "numbers": statement.verdict.numbers,
                        "readings": {reading: dict(n) for reading, n in statement.readings.items()},
                    }
                    for statement in chapter.statements
                },
                "numbers": dict(chapter.numbers),
                "tables": [dataclasses.asdict(table) for table in chapter.tables],
                "differences": [dataclasses.asdict(difference) for difference in chapter.differences],
                "figures": [f"figures/{picture.name}.png" for picture in chapter.pictures],
                "data": [f"data/{table}.csv" for table in chapter.data],
            }
            for name, chapter in done.items()
        },
    }


def csv_text(columns: Mapping[str, Sequence[Any]]) -> str:
    """Columns of one length as comma-separated values, numbers in full, nothing where there is none."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    plain = [plain_numbers(list(column)) for column in columns.values()]
    writer.writerows(zip(*plain, strict=True))
    return stream.getvalue()


def plain_numbers(value: Any) -> Any:
    """Nested numbers as JSON has them: no NaN, no infinity, no NumPy."""
    if isinstance(value, Mapping):
        return {str(key): plain_numbers(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_numbers(item) for item in value]
    if hasattr(value, "tolist"):
        return plain_numbers(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
