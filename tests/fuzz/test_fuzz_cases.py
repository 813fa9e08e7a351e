"""Random changes of case files: each runs a few steps, or is refused by a message to act on."""

import contextlib
import datetime as dt
import math
import os
import signal
import tempfile
import tomllib
from pathlib import Path

from myostrain import Case, ComputationError, InputError, cases
from myostrain.case import building
from myostrain.case import size_estimate as sizes
from myostrain.case.sections import SECTIONS, TEXTS

import hypothesis
import pytest
import tomlkit
from hypothesis import strategies as st

from small_cases import ALONE, LINE, SHEET, changed

#: More examples: MYOSTRAIN_FUZZ=20 pytest tests/fuzz
TIMES = int(os.environ.get("MYOSTRAIN_FUZZ", "1"))

#: Seconds that an example may take; the slowest of the default examples takes about one.
LIMIT = 30


def settings(examples):
    return hypothesis.settings(
        deadline=None,
        derandomize=TIMES == 1,
        database=None,
        max_examples=examples * TIMES,
        suppress_health_check=list(hypothesis.HealthCheck),
    )


SHIPPED = [tomllib.loads(cases.path(name).read_text(encoding="utf-8")) for name in cases.names()]
COARSE = [
    changed(
        case,
        {"geometry.spacing": 20.0, "time.end": 20 * case["time"]["step"]}
        | ({"initial.radius": 20.0} if "radius" in case.get("initial", ()) else {}),
    )
    for case in SHIPPED
]
STRAIN = changed(SHEET, {"mechanics.kinematics": "plane-strain"})

WORDS = (
    *(
        "x",
        "",
        "line",
        "rectangle",
        "file",
        "plane-strain",
        "implicit",
        "staggered",
        "NeoHookean",
        "advective",
    ),
    *(
        "/dev/zero",
        "../..",
        "\0",
        "a\nb",
        "Å∂ψ",
        "💓",
        "x" * 300,
        "python",
        "__import__('os').abort()",
        "left",
    ),
)
HUGE = (10**19, -(10**40), 10**400, 16**3000)
NUMBERS = (-1, 0, 1, 3, 0.4, 1.0, -0.5, -0.0, 30.0, 1e-3, 1e6, 1e9, 1e30, 1e-30, 1e154, 1e-154)
NUMBERS += (1e308, -1e308, 1e-308, 5e-324, math.inf, -math.inf, math.nan, *HUGE)
SCALARS = st.one_of(st.sampled_from(NUMBERS), st.sampled_from(WORDS), st.booleans())
JUNK = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.dictionaries(st.sampled_from(["value", "until", "a", "ksp_type"]), inner),
    ),
    max_leaves=6,
)
VALUES = st.one_of(SCALARS, JUNK, st.just(dt.date(2011, 1, 1)))
KEYS = st.one_of(
    st.text(max_size=6),
    st.sampled_from(["every", "beta", "robin", "model", "constraint", "path", "name", "imposed_stretch"]),
    st.sampled_from(
        ["ksp_type", "pc_type", "ksp_max_it", "mechanics", "potential", "a\nb", "[x]", "regions"]
    ),
)


@st.composite
def mutated(draw, bases):
    """A case with one to three changes: a key deleted, added or moved, a value of another type or size."""
    data = changed(draw(st.sampled_from(bases)), {})
    for _ in range(draw(st.integers(1, 3))):
        tables = [data, *(table for table in data.values() if isinstance(table, dict))]
        table = draw(st.sampled_from(tables[1:] if draw(st.integers(0, 3)) and tables[1:] else tables))
        existing = sorted(table)
        what = draw(
            st.sampled_from(["delete", "change", "change", "add", "negate", "move"] if existing else ["add"])
        )
        key = draw(KEYS) if what == "add" else draw(st.sampled_from(existing))
        if what == "delete":
            del table[key]
        elif what == "move":
            draw(st.sampled_from(tables))[key] = table.pop(key)
        elif what == "negate" and isinstance(table[key], int | float):
            table[key] = -table[key]
        else:
            table[key] = draw(VALUES)
    return data


def toml(data):
    """A case as TOML; what TOML has no way to write is written as a text."""
    try:
        return tomlkit.dumps(data)
    except (ValueError, TypeError, RecursionError):
        hypothesis.reject()


class Enough(Exception):
    """Two steps are done."""


class TwoSteps:
    def update(self, step, time):
        if step == 2:
            raise Enough


@contextlib.contextmanager
def limit(seconds):
    """Fail an example that takes too long (as soon as it is back in Python)."""

    def stop(*_):
        raise AssertionError(f"not done in {seconds} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def holds(content, words=()):
    """Whether the property holds: a case file runs, or is refused by one line that names a key or the file.

    Args:
        content: The file, bytes.
        words: One of these may stand in the message too.

    Returns:
        "runs", "refused" or "fails" (exit status 0, 2, 3).
    """
    with tempfile.TemporaryDirectory() as folder, limit(LIMIT):
        file, out = Path(folder) / "case.toml", Path(folder) / "out"
        file.write_bytes(content)
        try:
            simulation, message = Case.from_file(file).simulation(ALONE, out), ""
        except InputError as error:
            message = str(error)
        except ComputationError:
            return "fails"
        if message:
            assert "\n" not in message
            assert len(message) < 1000
            assert any(word in message for word in (*SECTIONS, *TEXTS, str(file), *words)), message
            assert not out.exists()
            return "refused"
        failed = False
        try:
            simulation.run(TwoSteps())
        except ComputationError:
            failed = True
        except Enough:
            pass
        if failed:
            assert (out / "failure.json").exists()
            assert not (out / "results.json").exists()
        return "fails" if failed else "runs"


@pytest.fixture(autouse=True, scope="module")
def _little_memory():
    """Memory for a few ten thousand nodes: what is larger must be refused before it is meshed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sizes, "free_memory", lambda: sizes.BASE + 2e8)
        yield


@settings(600)
@hypothesis.given(data=mutated([*SHIPPED, SHEET, STRAIN]))
def test_random_case_is_checked_or_refused(data):
    """Interface: wrong input is exit status 2, so nothing but InputError; what passes, survives TOML."""
    try:
        case = Case.from_dict(data)
    except InputError:
        return
    assert Case.from_dict(tomllib.loads(case.to_toml())).to_toml() == case.to_toml()


@settings(250)
@hypothesis.given(data=mutated([LINE, *COARSE[:2]]))
def test_random_line_runs_or_is_refused(data):
    """Requirements, "Fuzz": two steps, or a message; never a traceback, a hang or half a result."""
    holds(toml(data).encode())


@settings(50)
@hypothesis.given(data=mutated([SHEET, STRAIN, *COARSE[-1:]]))
def test_random_sheet_runs_or_is_refused(data):
    """The same of a sheet."""
    holds(toml(data).encode())


TEXT = toml(LINE)
BYTES = (b"\0", b"\xff", b"[", b"]", b'"', b"=", b"#", b"\n", b"1e999", b"{", b".", b"'''", "∂".encode())


@st.composite
def damaged(draw):
    """The text of a case, cut off, with bytes replaced or lines repeated."""
    text = TEXT.encode()
    for _ in range(draw(st.integers(1, 3))):
        at, to = sorted(draw(st.tuples(*[st.integers(0, len(text))] * 2)))
        what = draw(st.sampled_from(["cut", "delete", "repeat", "replace", "insert"]))
        text = {
            "cut": text[:to],
            "delete": text[:at] + text[to:],
            "repeat": text[:to] + text[at:],
            "replace": text[:at] + draw(st.sampled_from(BYTES)) + text[at + 1 :],
            "insert": text[:at] + draw(st.sampled_from(BYTES)) + text[at:],
        }[what]
    return text


@settings(150)
@hypothesis.given(content=damaged())
def test_damaged_text_runs_or_is_refused(content):
    """A file that is cut off, or not TOML, or not UTF-8."""
    holds(content)


@pytest.mark.parametrize(
    "content",
    [
        b"a = " + b"[" * 5000,
        b"a = " + b"{a=" * 5000,
        b".".join([b"a"] * 3000) + b" = 1",
        b"geometry = " + b"[" * 500 + b"]" * 500,
        b"[geometry]\nlength = " + b"9" * 5000,
        b"[geometry]\nlength = 0x" + b"f" * 5000,
        b"# " + b"x" * 2_000_000,
        b"\xef\xbb\xbf[geometry]\n",
    ],
    ids=["lists", "tables", "keys", "deep", "digits", "hex", "long", "BOM"],
)
def test_junk_is_refused(content):
    """Requirements, "Input": case files are data, and bounded."""
    assert holds(content) == "refused"


def test_the_property_can_fail(monkeypatch):
    """Each arm of it: a run, a refusal, a failure; and a traceback is not let through."""
    assert holds(TEXT.encode()) == "runs"
    assert holds(TEXT.replace("length = 20.0", "length = -1").encode()) == "refused"
    monkeypatch.setattr(building, "model", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        holds(TEXT.encode())
