"""[[cell.variation]] of case files."""

import tomllib

import myostrain as ms
from myostrain import Case, InputError, run_case

import numpy as np
import pytest

from coupled import coordinates
from small_cases import ALONE, LINE, SHEET, changed, command_line, write_case

TWO = [
    {"box": [[5.5], [30.0]], "alpha": 0.2, "tau": 0.3},
    {"boundary": ["right"], "depth": 4.0, "parameters": {"alpha": 0.25}},
]
VARIED = changed(LINE, {"cell.variation": TWO})
BUENO = changed(
    LINE,
    {
        "cell": {"model": "BuenoOrovio2008", "variation": [{"box": [[5.5], [30.0]], "set": "M"}]},
        "initial": {"potential": 0.0, "center": [0.0], "radius": 5.0},
    },
)


def again(case):
    return Case.from_dict(tomllib.loads(case.to_toml()), name=case.name)


def test_parameters_in_places():
    """Parameters are keys of the table, or lie under parameters; the resolved case reads back the same."""
    case = Case.from_dict(VARIED)
    assert again(case) == case
    assert again(case).parameters == case.parameters
    assert case.variations == (
        ms.Variation(where=ms.Place(box=((5.5,), (30.0,))), parameters={"alpha": 0.2, "tau": 0.3}),
        ms.Variation(where=ms.Place(boundary=("right",), depth=4.0), parameters={"alpha": 0.25}),
    )
    potential = case.build(ALONE).potential
    X = coordinates(potential)[:, 0]
    alpha = np.where(X > 15.9, 0.25, np.where(X > 5.5, 0.2, 0.1))
    np.testing.assert_array_equal(potential.varying["alpha"], alpha)
    np.testing.assert_array_equal(potential.varying["tau"], np.where(X > 5.5, 0.3, 0.2))


def test_a_key_of_the_cell_holds_everywhere_else(tmp_path):
    """--set cell.X changes all but where a variation says X; --set cell.variation.1.X changes that one."""
    file = write_case(tmp_path / "case.toml", BUENO)
    resolved = tmp_path / "resolved.toml"
    resolved.write_text(Case.from_file(file).to_toml(), encoding="utf-8")
    for path in (file, resolved):
        case = Case.from_file(path, ["cell.tau_w1m=77.0", "cell.tau_vp=2.0", "cell.variation.1.tau_si=4.0"])
        potential = case.build(ALONE).potential
        right = coordinates(potential)[:, 0] > 5.5
        m = ms.membranes.BuenoOrovio2008(set="M")
        np.testing.assert_array_equal(potential.varying["tau_w1m"], np.where(right, m.tau_w1m, 77.0))
        np.testing.assert_array_equal(potential.varying["tau_vp"], np.where(right, m.tau_vp, 2.0))
        assert set(potential.varying["tau_si"][right]) == {4.0}
        other = Case.from_file(path, ['cell.variation.1.set="ENDO"']).build(ALONE).potential
        assert set(other.varying["tau_w1m"][right]) == {6.0}


def test_what_varies_is_in_the_result_folder(tmp_path):
    """The case of a result folder has it, and gives the same run again."""
    case = Case.from_dict(changed(VARIED, {"output.fields": []}))
    first = run_case(case, tmp_path / "one", comm=ALONE, figures=False)
    kept = Case.from_file(tmp_path / "one" / "case.toml")
    assert kept.variations == case.variations
    assert first["parameters"]["cell"]["variation"][1]["parameters"] == {"alpha": 0.25}
    second = run_case(kept, tmp_path / "two", comm=ALONE, figures=False)
    assert (second["metrics"], second["probes"]) == (first["metrics"], first["probes"])
    uniform = run_case(Case.from_dict(LINE), tmp_path / "three", comm=ALONE, figures=False)
    assert uniform["solver"] != first["solver"] or uniform["metrics"] != first["metrics"]


def test_a_layer_on_a_finer_mesh():
    """Depths and boxes are those of the potential's own nodes."""
    layer = {"transmural": [0.0, 0.5], "transmural_between": ["bottom", "top"], "alpha": 0.3}
    geometry = {"kind": "rectangle", "size": [4.0, 3.0], "spacing": 1.0}
    start = {"potential": 0.9, "center": [0.0, 0.0], "radius": 1.0}
    case = changed(SHEET, {"geometry": geometry, "cell.variation": [layer], "initial": start, "probes": {}})
    for refinement in (0, 2):
        model = Case.from_dict(changed(case, {"potential.refinement": refinement})).build(ALONE)
        y = coordinates(model.potential)[:, 1]
        assert len(y) > 100 or refinement == 0
        np.testing.assert_array_equal(model.potential.varying["alpha"], np.where(y < 1.501, 0.3, 0.1))


RIGHT = {"box": [[5.5], [30.0]]}
WRONG = [
    (VARIED, {"cell.variation": {"alpha": 0.2}}, "cell.variation: give tables"),
    (VARIED, {"cell.variation": [3]}, "cell.variation: give tables"),
    (VARIED, {"cell.variation": [{**RIGHT, "alpa": 0.2}]}, r"cell.variation.1.alpa: .*did you mean 'alpha'"),
    (VARIED, {"cell.variation": [{"raduis": 2.0, "alpha": 0.2}]}, r"variation.1.raduis: .*mean 'radius'"),
    (VARIED, {"cell.variation": [TWO[0], {**RIGHT, "alpha": 1.5}]}, "cell.variation.2.alpha: .*less than 1"),
    (VARIED, {"cell.variation": [{**RIGHT, "alpha": "low"}]}, "cell.variation.1.alpha: .*number, not 'low'"),
    (VARIED, {"cell.variation": [{**RIGHT, "alpha": [0.1]}]}, "cell.variation.1.alpha: .*number"),
    (VARIED, {"cell.variation": [{**RIGHT, "set": "M"}]}, "cell.variation.1.set: .*no sets"),
    (BUENO, {"cell.variation": [{**RIGHT, "set": "MID"}]}, "cell.variation.1.set: 'MID' is not a set"),
    (BUENO, {"cell.variation": [{**RIGHT, "set": 3}]}, "cell.variation.1.set: 3 is not a set"),
    (VARIED, {"cell.variation": [{**RIGHT, "parameters": 3}]}, "cell.variation.1.parameters: give a table"),
    (VARIED, {"cell.variation": [RIGHT]}, "cell.variation.1: give parameters"),
    (VARIED, {"cell.variation": [{"alpha": 0.2}]}, "cell.variation.1: give one of center"),
    (VARIED, {"cell.variation": [{"box": [[5.5]], "alpha": 0.2}]}, r"cell.variation.1.box"),
    (VARIED, {"cell.variation": [{**RIGHT, "recovery": False}]}, "cell.variation.1.recovery: .*which states"),
    (VARIED, {"cell.variation": [{**RIGHT, "alpha": 0.2, "sampling": "mean"}]}, "variation.1: .*sampling"),
    (VARIED, {"cell.variation": [{"box": [[50.0], [60.0]], "alpha": 0.2}]}, "cell.variation.1.box: no node"),
    (VARIED, {"cell.variation": [{"region": ["scar"], "alpha": 0.2}]}, "variation.1.region: .*'scar'"),
    (VARIED, {"cell.variation": [{"boundary": ["lft"], "alpha": 0.2}]}, "variation.1.boundary: .*'left'"),
    (
        VARIED,
        {"cell.variation": [{"transmural": [0.0, 0.5], "alpha": 0.2}]},
        "transmural_between: name the two",
    ),
    (
        VARIED,
        {"cell.variation": [{"transmural": [0.5, 0.1], "alpha": 0.2}]},
        "cell.variation.1: .*lower depth",
    ),
]


@pytest.mark.parametrize("case, wrong, words", WRONG, ids=[words for _, _, words in WRONG])
def test_what_cannot_vary(case, wrong, words):
    """One message each, with the key."""
    with pytest.raises(InputError, match=words):
        Case.from_dict(changed(case, wrong)).build(ALONE)


@pytest.mark.parametrize("key", ["cell.variation.1.tau_q=1.0", "cell.variation.3.tau=1.0"])
def test_over_the_command_line(tmp_path, key):
    """Status 2 and the key, before anything is written."""
    file = write_case(tmp_path / "case.toml", VARIED)
    done = command_line("run", file, "--set", key, "--out", tmp_path / "out")
    assert done.status == 2
    assert key.partition("=")[0] in done.err
    assert not (tmp_path / "out").exists()


def test_rests_of_regions_that_begin_elsewhere(tmp_path):
    """A cell's end is the rest of all regions."""
    done = command_line("cell", "FitzHughNagumo", "--beats", "1", "--out", tmp_path / "cell")
    assert done.status == 0, done.err
    case = Case.from_dict(changed(VARIED, {"cell.initial": str(tmp_path / "cell"), "initial.center": [0.0]}))
    potential = case.build(ALONE).potential
    assert np.ndim(potential.local_rest) == 0
    assert potential.rest != 0
