"""Case files: what ships, defaults, ``--set``, misspelt keys."""

import math
import tomllib

import myostrain as ms
from myostrain import Case, ImposedStretch, InputError, cases

import pytest

from small_cases import LINE, SHEET, changed, command_line, write_case


@pytest.mark.parametrize("name", cases.names())
def test_shipped_case_loads_and_its_resolved_form_is_the_same_case(name):
    """Interface: DIR/case.toml holds "everything resolved: myostrain run DIR/case.toml repeats it"."""
    case = Case.from_file(cases.path(name))
    again = Case.from_dict(tomllib.loads(case.to_toml()), name="another")
    assert again == case
    assert again.to_toml() == case.to_toml()
    assert case.name == name
    assert case.title
    assert case.cost


def test_cases_that_ship():
    """Requirements, "Cases that ship"; the interface names the lengths, bumps, probes and parameters."""
    assert set(cases.names()) >= {"pulse-1d", "pulse-1d-rigid", "front-1d", "startup-1d", "sheet-2d"}
    made = {name: Case.from_file(cases.path(name)) for name in cases.names()}
    for name in ("pulse-1d", "pulse-1d-rigid", "front-1d"):
        case = made[name]
        (initial,) = case.initial
        assert (case.geometry.length, initial.where) == (400.0, ms.Place(center=(0.0,), radius=5.0))
        assert initial.potential == 0.9
        assert case.stimuli == ()
        assert (case.probes["a"], case.probes["b"]) == ((100.0,), (200.0,))
        assert list(case.probes)[:2] == ["a", "b"]
        assert case.time.step == 1e-3
        assert case.cell.recovery is (name != "front-1d")
    startup = made["startup-1d"]
    assert (startup.geometry.length, startup.time.end) == (60.0, 0.3)
    assert [(i.potential, i.where.radius) for i in startup.initial] == [(0.6, 1.0)]
    sheet = made["sheet-2d"]
    assert (sheet.geometry.size, sheet.time.end) == ((130.0, 180.0), 3.0)
    assert [i.where.radius for i in sheet.initial] == [8.0]
    assert (sheet.material.mu, sheet.mechanics.robin, sheet.law.beta) == (1.0, 1.0, 0.3)
    assert sheet.fibres.direction == (1.0, -1.0)
    assert len(sheet.probes) > 2
    assert set(made) >= {"slab-3d", "ventricle-3d", "land-1", "land-2", "land-3"}
    for name in ("pulse-1d", "pulse-1d-rigid", "front-1d", "startup-1d", "sheet-2d"):
        case = made[name]
        assert (case.cell.alpha, case.cell.tau, case.cell.A) == (0.1, 0.2, 100.0)
        assert case.potential.diffusivity == 100.0


def test_defaults_are_the_papers():
    """Paper, section 2 and (3.4): α = 0.1, τ = 0.2, A = D = 100, β = 0.3, conservative balance, μ = 1."""
    least = {
        "geometry": {"kind": "line", "length": 10},
        "initial": {"potential": 0.9, "center": [0], "radius": 5},
        "mechanics": {"kinematics": "line"},
        "time": {"step": 1e-3, "end": 1.0},
    }
    found = Case.from_dict(least).parameters
    expected = {
        "cell": {"model": "FitzHughNagumo", "alpha": 0.1, "tau": 0.2, "A": 100.0, "recovery": True},
        "potential": {"diffusivity": 100.0, "balance": "conservative"},
        "activation": {"law": "proportional", "beta": 0.3, "deformation": "fibre"},
        "material": {"model": "Spring", "mu": 1.0},
        "mechanics": {"robin": 0.0, "relaxation_time": 0.0, "every": 1, "fixed": []},
        "geometry": {"kind": "line", "length": 10.0, "spacing": 1.0},
    }
    assert {
        section: {key: found[section][key] for key in keys} for section, keys in expected.items()
    } == expected
    assert "imposed_stretch" not in found["mechanics"]


HELD = "mechanics.imposed_stretch={value=1.1, until=0.01}"


@pytest.mark.parametrize(
    "overrides, read, value",
    [
        (["cell.alpha=0.13"], lambda c: c.cell.alpha, 0.13),
        ([" cell . alpha = 0.13 "], lambda c: c.cell.alpha, 0.13),
        (["cell.A=50"], lambda c: c.cell.A, 50.0),
        (["cell.alpha=0.2", "cell.alpha=0.3"], lambda c: c.cell.alpha, 0.3),
        (["cell.recovery=false"], lambda c: c.cell.states, ()),
        (["potential.balance=advective"], lambda c: c.potential.balance, "advective"),
        (["potential.balance='advective'"], lambda c: c.potential.balance, "advective"),
        (['time.scheme="staggered"'], lambda c: c.scheme.order, 1),
        (["time.scheme=second-order", "mechanics.every=4"], lambda c: c.scheme.every, 4),
        (["potential.diffusivity=[100, 25]"], lambda c: c.potential.diffusivity, (100.0, 25.0)),
        ([HELD], lambda c: c.mechanics.imposed_stretch, ImposedStretch(value=1.1, until=0.01)),
        ([HELD, "mechanics.imposed_stretch.until=0.02"], lambda c: c.mechanics.imposed_stretch.until, 0.02),
        (["mechanics.imposed_stretch.until=inf"], lambda c: c.mechanics.imposed_stretch.until, math.inf),
        (["probes.c=[1.5]"], lambda c: dict(c.probes), {"a": (6.0,), "b": (8.0,), "c": (1.5,)}),
        (["probes={c=[1.5]}"], lambda c: dict(c.probes), {"c": (1.5,)}),
        (["solver.potential.ksp_type=cg"], lambda c: c.solver["potential"], {"ksp_type": "cg"}),
        (["solver.mechanics={ksp_rtol=1e-3}"], lambda c: c.solver["mechanics"], {"ksp_rtol": 1e-3}),
        (["title='a = b'"], lambda c: c.title, "a = b"),
    ],
)  # fmt: skip
def test_set(tmp_path, overrides, read, value):
    """Interface: ``--set`` "overrides one key, values in TOML syntax"; nested tables, later ones win."""
    file = write_case(tmp_path / "line.toml", LINE)
    assert read(Case.from_file(file, overrides)) == value


@pytest.mark.parametrize(
    "override, words",
    [
        ("cell.alpha", "KEY=VALUE"),
        ("=0.1", "KEY=VALUE"),
        ("cell..alpha=0.1", "KEY=VALUE"),
        (".alpha=0.1", "KEY=VALUE"),
        ("cell.alpha=", "cell.alpha"),
        ("cell.alpha=0.1 0.2", "cell.alpha"),
        ("cell.alpha=[0.1", "cell.alpha"),
        ("cell.alpha=0.1\ntau=3", "cell.alpha"),
        ("cell.alpha.deep=0.1", "cell.alpha.deep"),
        ("title.deep=0.1", "title: give a text"),
        ("cel.alpha=0.1", "'cell'"),
        ("cell=0.1", "[cell]"),
        ("alpha=0.1", "no such section or key"),
    ],
)
def test_set_of_a_wrong_form_is_refused(tmp_path, override, words):
    """Interface: exit status 2 with one message that names the key."""
    out = tmp_path / "out"
    done = command_line(
        "run", write_case(tmp_path / "line.toml", LINE), "--set", override, "--out", out, "--quiet"
    )
    assert done.status == 2
    assert words in done.err
    assert not out.exists()


# Cases in which every key is there that has a fixed name.
FULL_LINE = changed(
    LINE,
    {
        "mechanics.imposed_stretch": {"value": 1.0, "until": 0.01},
        "mechanics.robin_boundary": ["right"],
        "name": "x",
        "title": "x",
        "cost": "x",
    },
)
FULL_SHEET = changed(SHEET, {"fibres.regions": {}})
IMPLICIT = changed(LINE, {"time.scheme": "implicit"})


def known_keys(case):
    """Dotted keys of a case, resolved, but for those whose names the user chooses."""
    for section, values in (case | dict(Case.from_dict(case).parameters)).items():
        yield section
        if isinstance(values, dict) and section not in ("probes", "solver"):
            yield from (f"{section}.{key}" for key in values)
    if "imposed_stretch" in case["mechanics"]:
        yield from ("mechanics.imposed_stretch.value", "mechanics.imposed_stretch.until")


def misspelt(word):
    """A word with two letters exchanged, or one doubled where it is short."""
    i = len(word) // 2
    return word[0] + word if len(word) < 3 else word[: i - 1] + word[i] + word[i - 1] + word[i + 1 :]


MISSPELT = {
    f"{key}-{label}": (case, key)
    for label, case in (("line", FULL_LINE), ("sheet", FULL_SHEET), ("implicit", IMPLICIT))
    for key in known_keys(case)
    if label != "implicit" or key in ("time.tolerance", "time.max_iterations")
}


@pytest.mark.parametrize("case, key", MISSPELT.values(), ids=MISSPELT)
def test_misspelt_key_names_the_known_one(case, key):
    """Requirements, "unknown keys refused and the nearest known key named", for every key there is."""
    *sections, last = key.split(".")
    data = changed(case | dict(Case.from_dict(case).parameters), {})
    at = data
    for section in sections:
        at = at[section]
    at[misspelt(last)] = at.pop(last)
    with pytest.raises(InputError) as caught:
        Case.from_dict(data)
    message = str(caught.value)
    assert f"'{last}'" in message or message.startswith(f"{key}: missing")


def test_the_name_of_a_case_is_no_case(tmp_path):
    """A name in place of a case is refused with what to give."""
    with pytest.raises(InputError, match=r"case: 'pulse-1d': give a Case, such as Case\.from_file"):
        ms.run_case("pulse-1d", tmp_path / "run")
