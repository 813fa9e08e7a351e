"""Which runs a sweep has: grid or list, values that are lists, and what is refused before any run begins."""

import json

from myostrain import Case, InputError
from myostrain.sweeping.members import check_same, plan, read_plan

import numpy as np
import pytest

from small_cases import LINE, SHEET, write_case


@pytest.fixture
def line(tmp_path):
    return write_case(tmp_path / "line.toml", LINE)


def values(runs):
    return [tuple(member.values.values()) for member in runs.members]


def test_a_grid_is_every_value_with_all_others(line):
    """The last key runs fastest; what is no list is the same in all runs."""
    runs = plan(line, {"activation.beta": [0.0, 0.1], "cell.alpha": np.array([0.1, 0.2]), "time.end": 0.02})
    assert values(runs) == [(0.0, 0.1), (0.0, 0.2), (0.1, 0.1), (0.1, 0.2)]
    assert [member.name for member in runs.members] == ["001", "002", "003", "004"]
    for member in runs.members:
        assert member.case.law.beta == member.values["activation.beta"]
        assert member.case.cell.alpha == member.values["cell.alpha"]
        assert member.case.time.end == 0.02
    assert runs.members[1].said == "activation.beta = 0, cell.alpha = 0.2"


def test_a_list_goes_side_by_side(line):
    runs = plan(line, {"activation.beta": [0.0, 0.1], "cell.alpha": [0.1, 0.2]}, grid=False)
    assert values(runs) == [(0.0, 0.1), (0.1, 0.2)]
    runs = plan(line, {"activation.beta": [0.0, 0.0], "cell.alpha": [0.1, 0.2]}, grid=False)
    assert values(runs) == [(0.0, 0.1), (0.0, 0.2)]
    with pytest.raises(InputError, match=r"^--list: .*activation.beta has 2, cell.alpha has 1"):
        plan(line, {"activation.beta": [0.0, 0.1], "cell.alpha": [0.1]}, grid=False)


def test_values_that_are_lists(tmp_path):
    """A list holds the runs' values: a value that is a list is in a list, or a tuple in a script."""
    file = write_case(tmp_path / "sheet.toml", SHEET)
    for directions in ([[1.0, 0.0], [1.0, 1.0]], [(1.0, 0.0), (1.0, 1.0)]):
        runs = plan(file, {"fibres.direction": directions})
        assert [tuple(m.case.fibres.direction) for m in runs.members] == [(1.0, 0.0), (1.0, 1.0)]
    with pytest.raises(
        InputError, match=r"^fibres.direction.*list of its own: fibres.direction=\[\["
    ) as error:
        plan(file, {"fibres.direction": [1.0, -1.0]})
    assert error.value.key.startswith("fibres.direction")


def test_a_case_of_a_script(line):
    """The case itself is not changed."""
    case = Case.from_file(line)
    runs = plan(case, {"activation.beta": [0.0, 0.1]})
    assert [m.case.law.beta for m in runs.members] == [0.0, 0.1]
    assert case.parameters == Case.from_file(line).parameters
    assert plan("startup-1d", {"cell.alpha": [0.1]}).members[0].case.name == "startup-1d"


@pytest.mark.parametrize(
    "given, words",
    [
        ({"activation.beta": 0.1}, "a list of values"),
        ({"activation.beta": []}, "--set activation.beta: give a value"),
        ({"activation.beta": [0.1, 0.1]}, "twice"),
        ({"activation.beat": [0.1]}, "did you mean 'beta'"),
        ({"activation.beta": [0.1, -1.0]}, "activation.beta"),
        ({"cell.alpha": [*range(400)], "cell.tau": [*range(400)]}, "160000 runs"),
    ],
)
def test_what_is_refused(line, given, words):
    with pytest.raises(InputError) as error:
        plan(line, given)
    assert words in str(error.value)
    assert "list of its own" not in str(error.value)


def test_a_plan_is_read_back_and_held_to(line, tmp_path):
    """What goes on is what began: other values, or another case, are refused."""
    runs = plan(line, {"activation.beta": [0.0, 0.1], "mechanics.fixed": [["left"], []]})
    kept = tmp_path / "sweep.json"
    kept.write_text(json.dumps(runs.as_json()))
    again = read_plan(kept)
    assert again == runs
    check_same(again, runs, tmp_path)
    with pytest.raises(InputError, match="over other values"):
        check_same(again, plan(line, {"activation.beta": [0.0, 0.2]}), tmp_path)
    other = plan(line, {"activation.beta": [0.0, 0.1], "mechanics.fixed": [["left"], []], "cell.tau": 0.3})
    with pytest.raises(InputError, match=r"another case \(cell.tau is 0.3, it was 0.2\)"):
        check_same(again, other, tmp_path)
    kept.write_text("{")
    with pytest.raises(InputError, match="damaged"):
        read_plan(kept)
