"""Every chapter of `myostrain reproduce`: its verdicts and numbers are those of `cases/paper`.

Each file there says what its chapter measured when it was last examined, with a tolerance from measured
convergence; what the numbers mean, and which equation of the paper they belong to, stands there too.
"""

from myostrain.output.figures.style import style
from myostrain.reproduce import chapters
from myostrain.reproduce.build import plain_numbers
from myostrain.reproduce.jobs import Store, run_jobs
from myostrain.reproduce.page import outcome
from myostrain.reproduce.verdict import claims, paper

import pytest


def at(numbers, path):
    """The number at a dotted path; a key may hold dots itself."""
    if path in numbers:
        return numbers[path]
    for split in (i for i, letter in enumerate(path) if letter == "."):
        if isinstance(numbers.get(path[:split]), dict):
            try:
                return at(numbers[path[:split]], path[split + 1 :])
            except KeyError:
                continue
    raise KeyError(path)


def check(name, quick, folder):
    found = run_jobs(chapters.jobs(name, quick), Store(folder), workers=1)
    chapter = chapters.chapter(name, found, quick)
    data = paper(name)
    judged = {statement.claim.name: statement for statement in chapter.statements}
    # Every claim of the file is judged, and none else.
    assert judged.keys() == claims(name).keys() == data["verdicts"].keys()
    found = {claim: statement.verdict.kind for claim, statement in judged.items()}
    assert found == data["verdicts"], {c: outcome(s) for c, s in judged.items()}
    numbers = plain_numbers(chapter.numbers)
    wanted = "quick" if quick else "full"
    measured = {path: m for path, m in data["measured"].items() if m["settings"] == wanted}
    off = {
        path: (at(numbers, path), m["value"])
        for path, m in measured.items()
        if abs(at(numbers, path) - m["value"]) > m["within"]
    }
    assert not off
    assert quick or len(chapter.tables) == len(data["tables"])
    with style():
        for picture in chapter.pictures:
            picture.draw()
    return chapter


#: Those of the open questions take half a minute and more each.
QUICK = [
    pytest.param(name, marks=pytest.mark.slow) if name in chapters.groups()["open-questions"] else name
    for name in chapters.names()
]


@pytest.mark.parametrize("name", QUICK)
def test_chapter(name, tmp_path):
    """At the quick settings: verdicts, numbers, and its pictures can be drawn."""
    chapter = check(name, True, tmp_path)
    assert chapter.statements
    assert any(m["settings"] == "quick" for m in paper(name)["measured"].values())


@pytest.mark.slow
@pytest.mark.parametrize("name", chapters.names())
def test_chapter_in_full(name, tmp_path):
    """The same at the full settings."""
    check(name, False, tmp_path)
