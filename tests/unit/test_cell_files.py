"""Membranes from .ode, .mmt and .cellml files: the same numbers as in Python, names, units, nothing run."""

import builtins
import logging
import sys
import tomllib
from unittest import mock

import myostrain as ms
from myostrain import Case, InputError
from myostrain.membranes import GeneralizedRushLarsen, Step
from myostrain.membranes.files import file_membrane, ode
from myostrain.membranes.reaction import Reaction, default_integrator

import numpy as np
import pytest

from cell_files import CELLML, MMT, ODE, cellml_in_python, ode_in_python
from small_cases import ALONE, LINE, command_line, write_case

RNG = np.random.default_rng(7)
V = RNG.uniform(-90.0, 40.0, 50)
STATES = RNG.uniform(0.05, 0.95, (3, 50))
SMALL = "parameters(a=2.0, b=1.0)\nstates(v=0.0, w=0.5)\ndv_dt = -a*v - w\ndw_dt = b*v\n"


@pytest.fixture
def made(tmp_path):
    """Write a file and make the membrane of it."""

    def make(text, name="cell.ode", **given):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return ms.membranes.FileMembrane(path=path, **given)

    return make


def close(found, wanted):
    return np.max(np.abs(found - wanted) / (np.abs(wanted) + 1e-3)) < 1e-12


@pytest.mark.parametrize("text, name, prefix", [(ODE, "cell.ode", {}), (MMT, "cell.mmt", {
    "V": "membrane.V", "m": "ina.m", "h": "ina.h", "Ca_i": "ca.Ca_i"})], ids=["ode", "mmt"])  # fmt: skip
def test_the_same_as_in_python(made, text, name, prefix):
    """Rates of random values to 1e-12, as arrays and compiled; what is what; rest is the file's."""
    cell = made(text, name)
    wanted = {prefix.get(n, n): x for n, x in ode_in_python(V, *STATES).items()}
    states = [
        {prefix.get(n, n): x for n, x in zip(("m", "h", "Ca_i"), STATES, strict=True)}[s] for s in cell.states
    ]
    assert cell.potential == prefix.get("V", "V")
    assert close(-cell.current(V, states), wanted.pop(cell.potential))
    assert cell.states == tuple(wanted)
    for name, rate in zip(cell.states, cell.rates(V, states), strict=True):
        assert close(rate, wanted[name]), name
    assert (cell.time_unit, cell.potential_unit, cell.calcium_unit) == ("ms", "mV", "μM")
    assert cell.calcium == prefix.get("Ca_i", "Ca_i")
    assert (cell.range, cell.threshold) == ((-90.0, 50.0), -40.0)
    assert (cell.resting_potential(), cell.resting_states()) == (-84.0, (0.02, 0.9, 0.1))
    ms.membranes.check_membrane(cell)
    reaction = Reaction(cell)
    before = np.array(states)
    step = Step(length=0.01, weight=100.0, history=-100.0 * before, before=before, potential=V)
    after, current, _, bad = reaction.solve(V, before, step)
    assert bad == -1
    assert close(current, cell.current(V, after))


def test_cellml(made):
    """FitzHugh and Nagumo's model in CellML, without its stimulus."""
    cell = made(CELLML, "cell.cellml")
    v, w = RNG.uniform(-0.2, 1.2, (2, 40))
    wanted = cellml_in_python(v, w)
    assert (cell.potential, cell.states, cell.time_unit) == ("cell.v", ("cell.w",), "ms")
    assert close(-cell.current(v, [w]), wanted["cell.v"])
    assert close(cell.rates(v, [w])[0], wanted["cell.w"])
    assert cell.range == (0.0, 1.0)
    assert cell.stimulus == ("cell.i_stim",)


X = RNG.uniform(0.1, 0.9, 30) * np.where(np.arange(30) % 2, 1, -1)
A = abs(X)
ODE_FORMULAS = {
    "-v**2 + 2**3**2": -(X**2) + 512,
    "v - 1 - 2/4/2*3": X - 1 - 0.75,
    "1e-3*v + 2.5E2 - .5": 1e-3 * X + 249.5,
    "sin(v) + cos(v)*tan(v) + pi": np.sin(X) + np.cos(X) * np.tan(X) + np.pi,
    "asin(v) + acos(v) - atan(v)": np.arcsin(X) + np.arccos(X) - np.arctan(X),
    "exp(v)*log(Abs(v)) + ln(2)*sqrt(abs(v))": np.exp(X) * np.log(A) + np.log(2) * np.sqrt(A),
    "floor(10*v) + Mod(v, 0.3) + Mod(7, -4)": np.floor(10 * X) + np.mod(X, 0.3) - 1,
    "Min(v, 0.2, 0.1) + 10*Max(v, 0)": np.minimum(X, 0.1) + 10 * np.maximum(X, 0),
    "Conditional(Or(Lt(v, -0.5), Not(Le(v, 0.5))), 1, v)": np.where((X < -0.5) | (X > 0.5), 1, X),
    "Conditional(And(Ge(v, 0), Eq(floor(v), 0)), 3, 4) + 2*Gt(v, 0)": np.where(X > 0, 5.0, 4.0),
    "ContinuousConditional(Gt(v, 0.2), 5, 1, 0.1)": 1 + 4 / (1 + np.exp(-(X - 0.2) / 0.1)),
    "ContinuousConditional(Le(v, 0.2), 5, 1, 0.1)": 1 + 4 / (1 + np.exp((X - 0.2) / 0.1)),
    "1 - exp(v) - (exp(2*v) - 1)": 2 - np.exp(X) - np.exp(2 * X),
}
MMT_FORMULAS = {
    "-v^2 + 2^3": 8 - X**2,
    "v % 0.3 + v // 0.3": np.mod(X, 0.3) + np.floor(X / 0.3),
    "log(abs(v), 3) + log10(abs(v)) + log(2)": np.log(A) / np.log(3) + np.log10(A) + np.log(2),
    "sin(v) + cos(v) * tan(v) - +v": np.sin(X) + np.cos(X) * np.tan(X) - X,
    "asin(v) + acos(v) - atan(v)": np.arcsin(X) + np.arccos(X) - np.arctan(X),
    "ceil(10 * v) + sqrt(abs(v)) * exp(v)": np.ceil(10 * X) + np.sqrt(A) * np.exp(X),
    "if(v < -0.5 or not (v <= 0.5), 1, v)": np.where((X < -0.5) | (X > 0.5), 1, X),
    "piecewise(v > 0.5, 1, v > 0, 2, v >= -0.5, 3, 4)": np.select(
        [X > 0.5, X > 0, X >= -0.5], [1, 2, 3], 4.0
    ),
    "if(floor(v) == 0 and v != 2, 1, 0)": (X > 0) * 1.0,
}


@pytest.mark.parametrize("formula", ODE_FORMULAS)
def test_operations_of_ode(made, formula):
    """Each operation of the language, as NumPy does it."""
    cell = made(f"states(v=0.0)\ndv_dt = {formula}\n")
    assert close(-cell.current(X, []), ODE_FORMULAS[formula])


@pytest.mark.parametrize("formula", MMT_FORMULAS)
def test_operations_of_mmt(made, formula):
    """Each operation of the language, as NumPy does it."""
    cell = made(f"[[model]]\nx.v = 0\n[x]\ndot(v) = {formula}\nt = 0 bind time\n", "cell.mmt")
    assert close(-cell.current(X, []), MMT_FORMULAS[formula])


def test_gaps_are_closed(made):
    """x/(1 − e^−x) has its limit where it is 0/0, and beside it no noise, nor has its derivative."""
    cell = made(ODE)
    v = np.array([-47.0, -47.0 + 1e-9, -47.0 - 1e-9, -47.0 + 1e-4])
    rate = cell.rates(v, [np.zeros(4)] * 2 + [np.ones(4)])[0]  # alpha
    x = (v + 47) / 10
    assert np.abs(rate - (1 + x / 2 + x**2 / 12)).max() < 3e-6
    other = made("states(v=0.0)\ndv_dt = -(exp(v/5) - 1)/(2*v)\n")
    assert np.abs(other.current(np.array([0.0, 1e-9, 0.5]), []) - [0.1, 0.1, np.expm1(0.1)]).max() < 1e-6


def test_names_of_a_file(made, tmp_path):
    """Parameters and first values are set by the file's names; a name that is also ours is the file's."""
    cell = made(ODE, parameters={"g_Na": 0.0, "range": 0.0}, initial_states={"V": -70.0, "h": 0.5})
    assert (cell.resting_potential(), cell.resting_states()) == (-70.0, (0.02, 0.5, 0.1))
    assert close(cell.current(V, STATES), np.maximum(abs(V), 1) / 2 + (V > 0))
    assert cell.parameters == {"g_Na": 0.0, "E_Na": 40.0, "range": 0.0}
    dotted = made(MMT, "cell.mmt", parameters={"ina.gmax": 0.0, "leak.range": 0.0})
    assert close(dotted.current(V, STATES), cell.current(V, STATES))
    named = made(SMALL.replace("a=2.0", "_contents=2.0, current=0").replace("-a*v", "-_contents*v"))
    assert close(named.current(V, [V]), 3 * V)
    other = made(SMALL, potential="w", range=(0.0, 1.0))
    assert (other.potential, other.states, other.resting_potential()) == ("w", ("v",), 0.5)


def case_of(tmp_path, text, name, cell=None, **sections):
    (tmp_path / name).write_text(text, encoding="utf-8")
    data = {**LINE, "initial": {"potential": 0.9, "center": [0.0], "radius": 5.0}, **sections}
    return write_case(
        tmp_path / "case.toml", {**data, "cell": {"model": "file", "path": name, **(cell or {})}}
    )


def test_a_case_names_parameters_in_three_ways(tmp_path):
    """Keys of [cell], tables, quoted keys, --set; the resolved case has all, and is read back the same."""
    path = case_of(
        tmp_path, MMT, "cell.mmt", {"ina": {"gmax": 3.0}, "leak.range": 0.5, "parameters": {"ina.E": 41.0}}
    )
    case = Case.from_file(path)
    assert case.cell.parameters == {"ina.gmax": 3.0, "ina.E": 41.0, "leak.range": 0.5}
    again = Case.from_dict(tomllib.loads(case.to_toml()))
    assert again.parameters == {**case.parameters, "name": again.name, "title": again.title} | {
        k: case.parameters[k] for k in ("name", "title")
    }
    assert again.cell.path == tmp_path / "cell.mmt"
    (tmp_path / "resolved.toml").write_text(case.to_toml(), encoding="utf-8")
    for key in ("cell.ina.gmax=7", "cell.parameters.ina.gmax=7"):
        assert Case.from_file(tmp_path / "resolved.toml", [key]).cell.parameters["ina.gmax"] == 7.0
    with pytest.raises(
        InputError, match=r"cell.parameters.ina.gmx: the file has no such name; did you mean 'ina.gmax'"
    ):
        Case.from_file(path, ["cell.ina.gmx=7"])
    with pytest.raises(InputError, match=r"cell\.parameters\S*: give a number, not 'much'"):
        Case.from_file(path, ["cell.ina.gmax=much"])


def test_a_stimulus_of_the_file_is_switched_off(made, caplog):
    """With a note, once for a file; its parameters are none; a pulse of another name is named, or refused."""
    text = ODE + "# of its own\n"
    with caplog.at_level(logging.WARNING, "myostrain"):
        assert made(text).stimulus == ("i_Stim",)
    assert "stimulus of cell.ode is switched off: i_Stim = 0" in caplog.text
    assert made(MMT, "cell.mmt").stimulus == ("engine.pace",)
    with pytest.raises(InputError, match=r"stim_amplitude: this is of the file's own stimulus.*stimulus"):
        made(text, parameters={"stim_amplitude": 1.0})
    pulse = text.replace("i_Stim", "i_pulse").replace("stim_", "p_")
    with pytest.raises(InputError, match=r"cell.path: .*the rate of V → dV_dt → i_pulse → time"):
        made(pulse)
    assert close(made(pulse, stimulus=("i_pulse",)).current(V, STATES), made(text).current(V, STATES))
    # Of a stimulus that lies in the parameters only.
    assert made(SMALL.replace("b=1.0", "b=1.0, I_stim=3.0").replace("- w", "- w + I_stim")).stimulus == (
        "I_stim",
    )


def test_units(made, tmp_path):
    """What the file says holds; what it does not may be said, and the range has to be where nothing tells."""
    assert made(SMALL).time_unit is None
    assert made(SMALL, time_unit="s", potential_unit="V").range == (-0.09, 0.05)
    assert made(SMALL, range=(-1.0, 3.0)).threshold == 1.0
    with pytest.raises(InputError, match=r"cell.time_unit: the file says ms, not s"):
        made(ODE, time_unit="s")
    minutes = CELLML.replace(' prefix="milli"/>', ' multiplier="60"/>')
    with pytest.raises(InputError, match=r"time_unit is '.*'; a membrane counts time in \"ms\", in \"s\""):
        ms.membranes.check_membrane(made(minutes, "minutes.cellml"))
    with pytest.raises(InputError, match=r"cell.range: the potential starts at -1.2.*give range"):
        made(SMALL.replace("v=0.0", "v=-1.2"))
    with pytest.raises(InputError, match=r"units.time: FileMembrane counts the time in ms, not s"):
        Case.from_file(case_of(tmp_path, ODE, "cell.ode", units={"time": "s"}))


STRANGE = """
parameters("Was für ein Kanal?", lambda = 0.5, if_ = ScalarParam(2.0, unit="mS/uF", description="a, (b) = c"))
parameters(class = 3.0, E = 1.0, J = 0.0, np = 4.0, step = 1.0, order = 0.25, N1_2_ = 1.5, exp_ = 2.0)
states("x", u = 0.125, _m = 0.5, None = 0.25, import = 0.5, I = 0.1)
expressions("x")
def = lambda*u*(1 - u)*(u - order) # a comment = with ( brackets
print = def - import*exp_*np*0.05
du_dt = print - E*J + 0*N1_2_
d_m_dt = step*(u - _m)/if_
dNone_dt = class*(u - None)
dimport_dt = 0.01*(u - import*lambda)
dI_dt = -I*pi*0.01
"""


def test_strange_names(made):
    """Words of Python, of C, of SymPy, and of this program are names like others; so are constants."""
    cell = made(STRANGE, "strange.ode", potential="u")
    assert cell.states == ("_m", "None", "import", "I")
    v, states = np.array([0.3, 0.6]), np.array([[0.5, 0.4], [0.2, 0.3], [0.5, 0.7], [0.1, 0.2]])
    rates = (v - states[0]) / 2, 3 * (v - states[1]), 0.01 * (v - states[2] / 2), -0.01 * np.pi * states[3]
    assert close(-cell.current(v, states), 0.5 * v * (1 - v) * (v - 0.25) - 0.4 * states[2])
    assert close(np.array(cell.rates(v, states)), np.array(rates))
    step = Step(length=0.01, weight=100.0, history=-100 * states, before=states, potential=v)
    assert Reaction(cell).solve(v, states, step)[3] == -1


def test_the_integrator_of_files():
    """Exponential, as cells have gates, although it is not said which states are gates."""
    assert isinstance(default_integrator(ms.membranes.FileMembrane), GeneralizedRushLarsen)


UNREADABLE = {
    "a name that is not defined": (SMALL.replace("-a*v", "-aa*v"), "cell.ode", "aa, of which dv_dt is made"),
    "a state without a rate": (SMALL.replace("dw_dt", "dw_dx"), "cell.ode", "the state w has no rate"),
    "no language": ("PK\x03\x04 rubbish {", "cell.ode", "cannot be understood from line 1"),
    "defined twice": (SMALL + "dw_dt = 1.0\n", "cell.ode", "dw_dt is defined twice"),
    "a circle": (SMALL + "x = y\ny = x\n", "cell.ode", "in a circle: x → y → x"),
    "no states": ("parameters(a=1)\n", "cell.ode", "no states"),
    "no number": (SMALL.replace("a=2.0", "a=2.0*q"), "cell.ode", "value of a is not a number: it needs q"),
    "too many arguments": (SMALL.replace("-a*v", "exp(v, w)"), "cell.ode", "exp takes 1 arguments, not 2"),
    "a long sum": (SMALL + "x = " + "+".join(["v"] * 400) + "\n", "cell.ode", "too deep"),
    "deep brackets": (SMALL + "x = " + "(1/" * 3000 + "v" + ")" * 3000 + "\n", "cell.ode", "too deep"),
    "space": ("\n \n", "cell.ode", "no states"),
    "empty": ("", "cell.ode", "has 0 bytes"),
    "another kind": (SMALL, "cell.txt", "should end with one of .ode, .mmt, .cellml"),
    "mmt": ("[[model]]\nx.y = 1\n[x]\ndot(y) = z\n", "cell.mmt", "Myokit cannot read it: .*z"),
    "mmt without a model": ("[[script]]\nprint(1)\n", "cell.mmt", "has no .*model"),
    "no XML": ("<model", "cell.cellml", "Myokit cannot read it: Unable to parse XML"),
    "no initial value": (
        CELLML.replace(' initial_value="0.01"', "", 1), "cell.cellml", "has no initial value",
    ),
    "no CellML": ("<svg xmlns='http://www.w3.org/2000/svg'/>", "cell.cellml", "it is not CellML"),
    "CellML with an unknown name": (CELLML.replace("<ci>cubic</ci><ci>w</ci>", "<ci>cubic</ci><ci>q</ci>"),
                                    "cell.cellml", "Myokit cannot read it"),
}  # fmt: skip


@pytest.mark.parametrize("text, name, words", UNREADABLE.values(), ids=UNREADABLE)
def test_files_that_cannot_be_read(made, text, name, words):
    """One message with the key and what is wrong."""
    with pytest.raises(InputError, match=words) as caught:
        made(text, name)
    assert caught.value.key == "cell.path"
    assert len(str(caught.value)) < 700


def test_no_file(tmp_path):
    """A folder, nothing, no text."""
    (tmp_path / "binary.ode").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "folder.ode").mkdir()
    for name, words in (
        ("folder.ode", "is a folder"),
        ("none.ode", "there is no file"),
        ("binary.ode", "cannot be read"),
    ):
        with pytest.raises(InputError, match=words) as caught:
            ms.membranes.FileMembrane(path=tmp_path / name)
        assert caught.value.key == "cell.path"


def test_unknown_names(made):
    """States and parameters apart; what is computed cannot be set; roles are states."""
    for given, words in (
        ({"parameters": {"g_na": 1.0}}, r"cell.parameters.g_na: .*did you mean 'g_Na'"),
        ({"parameters": {"V": 1.0}}, "this is a state: .*initial_states"),
        ({"parameters": {"i_Na": 1.0}}, "computed from others"),
        ({"initial_states": {"mm": 1.0}}, "cell.initial_states.mm: .*did you mean"),
        ({"potential": "u"}, "cell.potential: 'u' is not a state"),
        ({"calcium": "V"}, "cell.calcium: 'V' is the potential"),
        ({"calcium": "Cai"}, "cell.calcium: 'Cai' is not a state of the file; did you mean 'Ca_i'"),
        ({"stimulus": ("i_N",)}, "cell.stimulus: .*did you mean 'i_Na'"),
        ({"parameters": {"g_Na": float("nan")}}, "finite"),
    ):
        with pytest.raises(InputError, match=words):
            made(ODE, **given)
    with pytest.raises(InputError, match=r"cell.potential: which state is the potential cannot be told"):
        made(SMALL.replace("v", "x"))


@pytest.mark.parametrize("text, name", [(ODE, "cell.ode"), (MMT, "cell.mmt"), (CELLML, "cell.cellml")])
def test_nothing_in_a_file_is_run(made, tmp_path, monkeypatch, text, name):
    """No text is evaluated, whatever it says; a script in a file stays text."""
    made(text, name)  # what is imported may be compiled
    file_membrane._parsed.cache_clear()
    monkeypatch.chdir(tmp_path)

    def refused(*arguments, **named):
        raise AssertionError("text was run")

    with mock.patch.multiple(builtins, eval=refused, exec=refused, compile=refused):
        cell = made(text, name)
        cell.current(V, np.resize(STATES, (len(cell.states), 50)))
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("call", ["__import__('os').system('touch ran')", "open('ran', 'w')", "v.__class__"])
def test_calls_are_no_formulas(made, tmp_path, monkeypatch, call):
    """Python in the place of a formula is refused, in both languages."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError):
        made(SMALL.replace("-a*v", call))
    with pytest.raises(InputError):
        made(f"[[model]]\nx.v = 1\n[x]\ndot(v) = {call}\nt = 0 bind time\n", "cell.mmt")
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("package, name, text", [
    ("gotranx.parser", "cell.ode", ODE), ("myokit", "cell.mmt", MMT), ("myokit", "cell.cellml", CELLML),
])  # fmt: skip
def test_a_package_is_missing(made, monkeypatch, package, name, text):
    """The message says how to get it."""
    monkeypatch.setitem(sys.modules, package, None)
    file_membrane._parsed.cache_clear()
    ode._parser.cache_clear()
    with pytest.raises(InputError, match=r"cell.path: .*pip install 'myostrain\[cellfiles\]'"):
        made(text, name)


@pytest.mark.parametrize("name, text", [("cell.mmt", MMT), ("cell.cellml", CELLML)])
def test_a_home_that_cannot_be_written(made, monkeypatch, tmp_path, name, text):
    """Myokit makes a folder there when it is imported; root may write anywhere, but not below a file."""
    for module in [m for m in sys.modules if m.split(".")[0] == "myokit"]:
        monkeypatch.delitem(sys.modules, module)
    (tmp_path / "home").write_text("a file")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    file_membrane._parsed.cache_clear()
    with pytest.raises(InputError, match=r"cell.path: .*could not write .*set HOME"):
        made(text, name)


def test_a_run_and_its_resume(tmp_path):
    """A case runs with a file beside it; it goes on with the same file only."""
    path = case_of(tmp_path, SMALL, "cell.ode", output={"every": 2e-3, "checkpoint_every": 2e-3})
    out = tmp_path / "out"
    assert command_line("run", path, "--out", out).status == 0
    kept = tomllib.loads((out / "case.toml").read_text(encoding="utf-8"))["cell"]
    assert kept["model"] == "file"
    assert kept["path"] == str(tmp_path / "cell.ode")
    assert kept["parameters"] == {"a": 2.0, "b": 1.0}
    (tmp_path / "cell.ode").write_text(SMALL.replace("a=2.0", "a=3.0"), encoding="utf-8")
    found = command_line("run", "--resume", "--out", out, "--set", "time.end=0.012")
    assert found.status == 2
    assert "cell.path" in found.err


def test_parameters_of_a_file_vary_over_a_body(made):
    """Node by node the rates of each half are those of its own file, also of a name that all files have."""
    place = ms.Place(box=((1.5,), (9.0,)))
    said = {"g_Na": 3.0, "range": 4e-2}
    cell, other = made(ODE), made(ODE, parameters=said)
    body = ms.build(ms.geometry.Line(length=3.0, spacing=1.0), comm=ALONE)
    potential = ms.Potential(body, membrane=cell, variations=[ms.Variation(where=place, parameters=said)])
    right = potential.v.function_space.tabulate_dof_coordinates()[:, 0] > 1.5
    assert set(potential.varying) == {"g_Na", "file.range"}
    v, states = np.linspace(-80.0, 20.0, 4), potential.states.copy()
    step = Step(0.05, 20.0, states, states.copy(), v - 1.0, 2)
    both, here, there = (
        Reaction(c, varying=varying).solve(v, states.copy(), step)[:3]
        for c, varying in ((cell, potential.varying), (cell, None), (other, None))
    )
    for found, first, second in zip(both, here, there, strict=True):
        np.testing.assert_array_equal(found, np.where(right, second, first))
    assert (here[1] != there[1]).all()
    for name, words in (
        ("g_N", "no such parameter; did you mean 'g_Na'"),
        ("m", "no number|is no parameter|no such"),
    ):
        wrong = ms.Variation(where=place, parameters={name: 1.0})
        with pytest.raises(InputError, match=f"cell.variation.1.{name}: .*({words})"):
            ms.Potential(body, membrane=cell, variations=[wrong])
