"""`myostrain reproduce` around its chapters: jobs and what is kept of them, verdicts, the page."""

import contextlib
import importlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tomllib
from html.parser import HTMLParser
from pathlib import Path

import myostrain as ms
from myostrain.output.figures.style import new_figure
from myostrain.reproduce import build, chapters, jobs, words
from myostrain.reproduce.content import Chapter, Difference, Picture, Statement, Table
from myostrain.reproduce.jobs import Found, Job, Store, run_jobs
from myostrain.reproduce.verdict import Claim, claims, judge, paper

import jinja2
import numpy as np
import pytest

from small_cases import COMMAND, command_line, strict_json

CLAIM = Claim("faster", "section 6", "of order $10\\,\\%$ <b>", {"ratio": (1.05, 1.15)}, "an order")


@pytest.mark.parametrize(
    "readings, kind, reading",
    [
        ({"printed": {"ratio": 1.1}, "other": {"ratio": 1.1}}, "agrees", "printed"),
        ({"printed": {"ratio": 1.26}, "other": {"ratio": 1.11}}, "agrees with a reading", "other"),
        ({"printed": {"ratio": 1.26}, "other": {"ratio": 1.3}}, "does not agree", "printed"),
        ({"printed": {"ratio": 1.15}}, "agrees", "printed"),
        ({"printed": {"ratio": 1.1501}}, "does not agree", "printed"),
        ({"printed": {"ratio": None}}, "does not agree", "printed"),
        ({"printed": {"ratio": float("nan")}, "other": {"ratio": 1.1}}, "agrees with a reading", "other"),
    ],
)
def test_a_verdict_follows_from_numbers_and_bounds(readings, kind, reading):
    """A verdict is borne out by the numbers: judge sees nothing else."""
    verdict = judge(CLAIM, readings)
    assert (verdict.kind, verdict.reading) == (kind, reading)
    assert set(verdict.numbers) == {"ratio"}


def test_a_missing_number_is_no_verdict():
    """A chapter that does not measure what the claim is about is a mistake, not a disagreement."""
    with pytest.raises(KeyError):
        judge(CLAIM, {"printed": {"celerity": 1.1}})


@pytest.mark.parametrize("name", chapters.names())
def test_claims_are_whole(name):
    """Each claim has its words, its place and the reason of its bounds; numbers have tolerances."""
    file = Path(ms.__file__).parent / "cases" / "paper" / f"{name}.toml"
    assert file.is_file()
    for claim in claims(name).values():
        assert claim.bounds
        assert all(low <= high for low, high in claim.bounds.values())
        assert len(claim.because) > 20
        assert re.search(r"section|abstract|introduction|equation|figure|\(\d", claim.where, re.IGNORECASE)
    for entry in tomllib.loads(file.read_text(encoding="utf-8"))["measured"].values():
        assert entry["within"] > 0
        assert entry["settings"] in ("quick", "full")


def test_chapters_are_alike():
    """Each has the four parts, and its words name exactly the tables and pictures that it makes."""
    folder = Path(chapters.__file__).parent
    for name in chapters.names():
        parts = {file.stem for file in (folder / name.replace("-", "_")).glob("*.py")}
        assert parts == {"__init__", "jobs", "numbers", "text", "pictures"}
        words, drawn = (
            paper(name),
            importlib.import_module(f"{chapters.__name__}.{name.replace('-', '_')}.pictures"),
        )
        assert words["pictures"].keys() == drawn.PICTURES.keys()
        assert all(claim["measured"] for claim in words["claims"].values())
    folders = {path.name.replace("_", "-") for path in folder.iterdir() if (path / "jobs.py").is_file()}
    assert folders == set(chapters.names())


@pytest.mark.parametrize(
    "template, text",
    [
        ("{{ c|fixed(2) }} and {{ c|number }}", "1.26 and 1.26"),
        (
            "{{ c|more('faster', 'slower') }}, {{ (1 / c)|more('faster', 'slower') }}",
            "26.0 % faster, 20.6 % slower",
        ),
        ("{{ c|change }}, {{ (1 / c)|change }}", "+26.0 %, −20.6 %"),
        ("{{ (c / 100)|percent(1) }} of {{ large|thousands }}, {{ c|g }}", "1.3 % of 12,346, 1.26"),
        ("{% if quick %}quick{% else %}full{% endif %} $\\frac{a}{b}$", "quick $\\frac{a}{b}$"),
    ],
)
def test_templates(template, text):
    """Numbers are put into words as the filters say; formulas are left alone."""
    assert words.filled(template, {"c": 1.26, "large": 12345.6, "quick": True}) == text


def test_a_template_that_names_no_number_is_an_error():
    """A number that does not exist is never left out silently."""
    with pytest.raises(jinja2.UndefinedError, match="celerity"):
        words.filled("{{ celerity|fixed(2) }}", {})


def test_a_statement_joins_no_words():
    """words.ALONE: a line of statements alone leaves none behind; after others on a line a new one begins."""
    template = """at
    {% for x in xs %}{{ x }}{{ "," if not loop.last }}{% endfor %}
here
    {% if xs %}
and
    {% endif %}
there"""
    assert words.filled(template, {"xs": [1, 2]}).split() == ["at", "1,2", "here", "and", "there"]
    assert "here\nand\nthere" in words.filled(template, {"xs": [1, 2]})


def test_without_the_libraries_of_the_page(tmp_path, monkeypatch):
    """The extra `page` may be missing: exit status 2, and how to get it, before anything is computed."""
    monkeypatch.setitem(sys.modules, "myostrain.reproduce.page", None)
    monkeypatch.setitem(sys.modules, "latex2mathml.converter", None)
    done = command_line("reproduce", "springs", "--out", tmp_path / "out")
    assert done.status == 2
    assert "pip install 'myostrain[page]'" in done.err
    assert not (tmp_path / "out").exists()


@pytest.fixture
def counted(monkeypatch):
    """A measurement that counts its calls, under the name "counted.square"."""
    calls = []

    class Module:
        @staticmethod
        def square(x):
            calls.append(x)
            if x < 0:
                raise ms.ComputationError("x is negative", time=0.5, advice="a positive one.")
            return Found({"y": x * x, "none": None}, {"line": np.arange(x)})

    whole = jobs.importlib.import_module
    monkeypatch.setattr(
        jobs.importlib, "import_module", lambda n, *a: Module if n.endswith(".counted") else whole(n, *a)
    )
    return calls


def run(store, *numbers, **options):
    named = {f"job {x}": Job("counted.square", {"x": x}) for x in numbers}
    return run_jobs(named, store, workers=1, **options)


def test_outcomes_are_kept_under_parameters_and_code(tmp_path, counted, monkeypatch):
    """Outcomes are computed once; again for other parameters, other
    code, a damaged file, or when asked to; equal jobs of two chapters are computed once."""
    store = Store(tmp_path)
    first = run(store, 3)
    again = run(store, 3)
    assert counted == [3]
    assert first["job 3"].numbers == again["job 3"].numbers == {"y": 9, "none": None}
    np.testing.assert_array_equal(again["job 3"].arrays["line"], np.arange(3))
    run(store, 3, 4)
    assert counted == [3, 4]
    run(store, 4, fresh=True)
    assert counted == [3, 4, 4]
    twice = {"a": Job("counted.square", {"x": 5}), "b": Job("counted.square", {"x": 5}, cost=9.0)}
    assert run_jobs(twice, store, workers=1).keys() == {"a", "b"}
    assert counted == [3, 4, 4, 5]
    monkeypatch.setattr(jobs, "_code", lambda measurement: "other code")
    run(store, 3)
    assert counted == [3, 4, 4, 5, 3]
    monkeypatch.setattr(jobs, "versions", lambda: {"dolfinx": "another"})
    run(store, 3)
    assert counted == [3, 4, 4, 5, 3, 3]
    for file in tmp_path.iterdir():
        file.write_bytes(file.read_bytes()[:50])
    run(store, 3)
    assert counted == [3, 4, 4, 5, 3, 3, 3]


def test_a_store_that_cannot_be_written_is_no_error(tmp_path, counted):
    """Nothing is kept then, and everything is computed."""
    (tmp_path / "file").write_text("")
    store = Store(tmp_path / "file" / "below")
    assert run(store, 3)["job 3"].numbers["y"] == 9
    assert run(store, 3)["job 3"].numbers["y"] == 9
    assert counted == [3, 3]


def test_a_failure_names_the_computation(tmp_path, counted):
    """ComputationError says which job, when and what to try; what was done before is kept."""
    with pytest.raises(ms.ComputationError, match=r"t = 0.5: job -1: x is negative\. Try: a positive one"):
        run(Store(tmp_path), 2, -1)


def test_the_code_that_counts(tmp_path, monkeypatch):
    """The key changes with any module that computes, and the measurement that it is of and those it imports;
    not with a chapter's text, a figure's colours or another measurement."""
    source = Path(ms.__file__).parent
    copy = tmp_path / "myostrain"
    shutil.copytree(source, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(jobs, "__file__", str(copy / "reproduce" / "jobs.py"))

    def code():
        jobs._code.cache_clear()
        return jobs._code("sheets")

    try:
        before = code()
        for file in (
            "reproduce/chapters/viscosity/text.py",
            "output/figures/style.py",
            "reproduce/page.py",
            "reproduce/measurements/springs.py",
        ):
            (copy / file).write_text("# changed")
            assert code() == before
        for file in (
            "mechanics/equilibrium.py",
            "reproduce/measurements/cases.py",
            "output/metrics.py",
            "membranes/__init__.py",
        ):
            now = code()
            (copy / file).write_text("# changed")
            assert code() != now, file
    finally:
        jobs._code.cache_clear()


def test_jobs_side_by_side(tmp_path):
    """Two processes find what one finds; the dear ones begin first; progress ends at the whole."""
    samples = {"samples": 20, "relaxation_time": 0.3, "mu": 2.0}
    two = {f"seed {s}": Job("viscous.dissipation", {"seed": s, **samples}, cost=s) for s in (1, 2)}
    told = []
    found = run_jobs(two, Store(tmp_path), workers=2, tell=lambda *what: told.append(what))
    alone = run_jobs(two, Store(tmp_path / "other"), workers=1)
    assert {name: f.numbers for name, f in found.items()} == {name: f.numbers for name, f in alone.items()}
    assert sorted(done for _, done, _ in told)[-1] == 3.0
    assert {total for _, _, total in told} == {3.0}


# The page.


class Parsed(HTMLParser):
    """Collects what a page refers to, and checks that its tags are closed."""

    VOID = frozenset({"meta", "link", "img", "br", "hr"})

    def __init__(self, text):
        super().__init__()
        self.open, self.references, self.tags = [], [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        self.references += [value for name, value in attributes if name in ("src", "href", "srcset")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def example():
    statement = Statement(CLAIM, "We measured $\\frac{c}{c_0}$ = 1.26.", {"printed": {"ratio": 1.26}})
    table = Table("A table of $x'$.", ("name", "$c$"), [("one <two>", 1.23456), ("none", None), ("n", 12345)])

    def draw():
        figure = new_figure(3, 2)
        figure.add_subplot().plot([0, 1])
        return figure

    return Chapter(
        "An example",
        "Text with $\\alpha\\beta < 1/2$ and <script>alert(1)</script>.",
        [statement],
        [table],
        [Picture("example", "A line.", "A rising line.", draw)],
        [Difference("A difference", "We find another number.", "myostrain run pulse-1d")],
        {"ratio": np.float64(1.26), "missing": float("nan"), "list": np.arange(2)},
    )


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A folder made of the example alone."""

    monkeypatch.setattr(build.chapters, "jobs", lambda name, quick: {})
    monkeypatch.setattr(build.chapters, "chapter", lambda name, found, quick: example())
    numbers = build.reproduce(["springs"], tmp_path / "out", quick=True, store=tmp_path / "kept")
    return tmp_path / "out", numbers


def test_the_page_stands_alone(made):
    """One HTML page with everything inside: figures, and equations rendered without a network."""
    folder, _ = made
    text = (folder / "index.html").read_text(encoding="utf-8")
    parsed = Parsed(text)
    inside = [r for r in parsed.references if r.startswith(("data:", "#"))]
    assert set(parsed.references) - set(inside) == {"https://doi.org/10.1137/100788379"}
    assert not re.search(r"@import|url\(", text)
    assert sum(tag == "math" for tag, _ in parsed.tags) >= 4
    assert "<mfrac>" in text
    images = [attributes for tag, attributes in parsed.tags if tag == "img"]
    assert len(images) == 1
    assert images[0]["alt"] == "A rising line."
    assert (folder / "figures" / "example.png").read_bytes()[1:4] == b"PNG"
    assert ("meta", {"name": "viewport", "content": "width=device-width, initial-scale=1"}) in parsed.tags
    assert "<script" not in text


def test_the_page_says_what_was_judged(made):
    """The quote, the number, the verdict with its bounds, the table, the difference, its command."""
    folder, _ = made
    text = (folder / "index.html").read_text(encoding="utf-8")
    assert "does not agree: measured ratio 1.26 (the claim: 1.05 to 1.15)" in text
    for shown in (
        "1.235",
        "12345",
        "–",
        "one &lt;two&gt;",
        "myostrain run pulse-1d",
        "&lt;b&gt;",
        "an order",
    ):
        assert shown in text
    assert "Quick settings" in text
    assert "myostrain reproduce springs --quick" in text


def test_the_numbers_file(made):
    """numbers.json holds every number, its verdict and its bounds, as strict JSON."""
    folder, numbers = made
    kept = strict_json((folder / "numbers.json").read_text())
    assert kept == json.loads(json.dumps(numbers))
    chapter = kept["chapters"]["springs"]
    assert chapter["numbers"] == {"ratio": 1.26, "missing": None, "list": [0, 1]}
    assert chapter["verdicts"]["faster"]["verdict"] == "does not agree"
    assert chapter["verdicts"]["faster"]["bounds"] == {"ratio": [1.05, 1.15]}
    assert chapter["figures"] == ["figures/example.png"]
    assert kept["settings"] == "quick"


@pytest.mark.parametrize(
    "value, shown",
    [
        (1.23456, "1.23"),
        (0.0, "0"),
        (-0.5, "−0.5"),
        (12345.6, "12346"),
        (4.6e-16, "4.6 × 10⁻¹⁶"),
        (-2e7, "−2.0 × 10⁷"),
    ],
)
def test_numbers_as_shown(value, shown):
    """Three significant digits, a true minus, powers of ten for the very small and large."""
    assert words.number(value) == shown


def test_an_unknown_part(tmp_path):
    """Exit status 2, one message with the nearest known name."""
    done = command_line("reproduce", "figure1", "--out", tmp_path / "out")
    assert done.status == 2
    assert "did you mean 'figure-1'" in done.err
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written(tmp_path):
    """Exit status 2, and nothing is computed first."""
    (tmp_path / "file").write_text("")
    done = command_line("reproduce", "springs", "--out", tmp_path / "file")
    assert done.status == 2
    assert "cannot be written" in done.err


def test_the_command_line(tmp_path, monkeypatch):
    """`myostrain reproduce WHAT --quick --out DIR` prints each verdict and where the page is."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(jobs, "_workers", lambda asked, count: 1)
    done = command_line("reproduce", "springs", "--quick", "--out", tmp_path / "out")
    assert done.status == 0, done.err
    for name, claim in claims("springs").items():
        assert claim.name == name
        assert re.search(rf"springs\s+{name}\s+(agrees|does not agree)", done.out)
    assert str(tmp_path / "out" / "index.html") in done.out
    Parsed((tmp_path / "out" / "index.html").read_text(encoding="utf-8"))


def test_an_interrupt_ends_the_workers(tmp_path):
    """Ctrl-C, which the terminal sends to the whole group: exit status 130, one line, and no process left."""
    arguments = (
        "reproduce",
        "fronts",  # many short computations: the first message comes early, and much is left then
        "--quick",
        "--fresh",
        "--quiet",
        "--out",
        str(tmp_path / "out"),
    )
    # Where SIGINT is ignored, as in a shell's background, a new Python ignores it too.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    process = subprocess.Popen(
        [*COMMAND[:-1], heard + COMMAND[-1], *arguments],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert any("% done" in line for line in process.stderr)  # waits for the first
        os.killpg(process.pid, signal.SIGINT)
        _, rest = process.communicate(timeout=120)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == 130
    assert "interrupted" in rest
    assert "Traceback" not in rest
    assert not (tmp_path / "out" / "index.html").exists()
