"""``--set`` with texts and paths; what is data stays data; plain words for wrong types."""

import contextlib
import math
from pathlib import Path

from myostrain import Case, InputError
from myostrain.case.overrides import override
from myostrain.solvers.options import check_options

import pytest

from small_cases import ALONE, LINE, SHEET, changed, write_case

FILE = changed(SHEET, {"geometry": {"kind": "file", "path": "in_file.msh"}})


@pytest.mark.parametrize(
    "given, found",
    [
        ([], "cases/in_file.msh"),
        (["geometry.path=mesh.msh"], "here/mesh.msh"),
        (["geometry.path='mesh.msh'"], "here/mesh.msh"),
        (["geometry.path=../other/my-mesh_2.msh"], "other/my-mesh_2.msh"),
        (['geometry={kind="file", path="mesh.msh"}'], "here/mesh.msh"),
        (["geometry.path=/tmp/mesh.msh"], "/tmp/mesh.msh"),
    ],
)
def test_a_path_is_relative_to_where_it_is_said(tmp_path, monkeypatch, given, found):
    """Requirements, "Input": in a case file, relative to that; on the command line, to the current folder."""
    for name in ("cases", "here", "other"):
        (tmp_path / name).mkdir()
    file = write_case(tmp_path / "cases" / "case.toml", FILE)
    monkeypatch.chdir(tmp_path / "here")
    for path in (file, Path("../cases/case.toml")):
        case = Case.from_file(path, given)
        assert case.geometry.path == (tmp_path / found).resolve()
        assert case.parameters["geometry"]["path"] == str((tmp_path / found).resolve())


@pytest.mark.parametrize("text", ["a.b", "1.2.3", "v1.0", "./x/y.msh", "~/x", "é"])
def test_a_bare_word_is_a_text(tmp_path, text):
    """A shell takes the quotes away."""
    assert Case.from_file(write_case(tmp_path / "case.toml", LINE), [f"title={text}"]).title == text


@pytest.mark.parametrize(
    "assignment",
    ["title=a b", "title=a\nb", "title=\udcff", "title=[1", "a.b.c.d.e.f.g.h.i=1", "title=" + "[" * 5000],
)
def test_what_is_no_assignment(tmp_path, assignment):
    """Interface: exit status 2, that is InputError, of --set."""
    with pytest.raises(InputError, match=r"^--set.*") as caught:
        Case.from_file(write_case(tmp_path / "case.toml", LINE), [assignment])
    str(caught.value).encode()


def test_a_decimal_comma_is_known(tmp_path):
    """It is half of the world's way to write a number."""
    with pytest.raises(InputError, match=r"'0,2' is not a number.*: write 0\.2, or \[0,2\] for a list"):
        Case.from_file(write_case(tmp_path / "case.toml", LINE), ["activation.beta=0,2"])


@pytest.mark.parametrize(
    "changes, key, words",
    [
        ({"initial.center": 3.0}, "initial.center", "give a list of numbers, such as [2.0, 1.0], not 3.0"),
        (
            {"mechanics.fixed": "left"},
            "mechanics.fixed",
            "give a list of texts, such as [\"left\"], not 'left'",
        ),
        ({"output.fields": "potential"}, "output.fields", "give a list of texts"),
        ({"potential.diffusivity": [1.0, 2.0, 3.0]}, "potential.diffusivity", "give a shorter list"),
        ({"cell.alpha": "0.1"}, "cell.alpha", "give a number, not '0.1'"),
        ({"cell.recovery": 1}, "cell.recovery", "give a boolean, true or false, not 1"),
        ({"mechanics.every": 1.5}, "mechanics.every", "give an integer, not 1.5"),
        ({"mechanics.imposed_stretch": 1.0}, "mechanics.imposed_stretch", "give a table"),
        ({"mechanics.fixed": [3]}, "mechanics.fixed.0", "give a text, not 3"),
        ({"cell.alpha": [0] * 1000}, "cell.alpha", "..."),
        ({"name": "../elsewhere"}, "name", "give a short word"),
        ({"name": ""}, "name", "give a short word"),
    ],
)
def test_plain_words(changes, key, words):
    """A message says what to give, in the words of a case file, and is short."""
    with pytest.raises(InputError) as caught:
        Case.from_dict(changed(LINE, changes))
    message = str(caught.value)
    assert message.startswith(f"{key}: ")
    assert words in message
    assert "input should" not in message
    assert len(message) < 300


@pytest.mark.parametrize(
    "option",
    [
        {"pc_type": "python", "pc_python_type": "os.path"},
        {"ksp_type": "python"},
        {"pc_python_type": "os.path"},
        {"ksp_view": ":stolen.txt"},
        {"ksp_view": "binary"},
        {"ksp_monitor": "ascii:x"},
        {"ksp_max_it": 10**30},
        {"ksp type": "cg"},
        {"ksp_converged_reason": "binary"},
        {"ksp_converged_reason": "ascii"},
        {"ksp_monitor_solution": True},
        {"mat_view": True},
        {"pc_view": True},
        {"ksp_view_mat": True},
        {"ksp_rtol": math.nan},
        {"ksp_rtol": -1.0},
        {"ksp_max_it": 2.5},
        {"ksp_max_it": True},
        {"ksp_gmres_restart": 2**31},
        {"pc_gamg_threshold": "0.1,inf"},
        {"pc_type": "composite"},
        {"pc_mg_galerkin": "both"},
        {"sub_pc_type": "python"},
        {"fieldsplit_u_mg_levels_3_ksp_view": ":x"},
        {"mat_mumps_icntl_1": 6},
        {"mat_mumps_icntl_3": 6},
        {"mat_mumps_icntl_4": 3},
        {"mat_mumps_icntl_22": 1},
        {"mat_mumps_cntl_1": "x"},
        {"options_file": "x"},
        {"log_view": True},
    ],
    ids=str,
)
def test_options_of_petsc_run_no_code_and_write_no_files(option):
    """Requirements, "Input": case files are data. PETSc would import a class or write files."""
    with pytest.raises(InputError, match=r"^solver\.potential\."):
        Case.from_dict(changed(LINE, {"solver.potential": option}))
    with pytest.raises(InputError, match=r"^solver\.mechanics\."):
        check_options("mechanics", option)


@pytest.mark.parametrize(
    "option, words",
    [
        ({"ksp_rtoll": 1e-3}, "did you mean 'ksp_rtol'?"),
        ({"pc_type": "gamgg"}, "did you mean 'gamg'?"),
        ({"fieldsplit_u_pc_gamg_treshold": 0.1}, "did you mean 'pc_gamg_threshold'?"),
        ({"ksp_max_it": 0.5}, "an integer below 2^31, at least 0, not 0.5"),
        ({"ksp_monitor": "true"}, "it is printed"),
    ],
    ids=str,
)
def test_options_of_petsc_say_what_is_allowed(option, words):
    """CONTRIBUTING.md: "the key, the value and what is allowed", in scripts too."""
    with pytest.raises(InputError) as caught:
        check_options("mechanics", option)
    assert words in str(caught.value)
    assert caught.value.key == f"solver.mechanics.{next(iter(option))}"


def test_what_petsc_prints_is_printed(tmp_path, capfd):
    """``true`` is the whole of it: no file is written."""
    wanted = {"ksp_type": "gmres", "ksp_monitor": True, "ksp_converged_reason": True, "ksp_view": True}
    case = Case.from_dict(changed(LINE, {"solver.potential": wanted, "time.end": 1e-3}))
    with contextlib.chdir(tmp_path):
        case.simulation(ALONE).run()
    told = capfd.readouterr().out
    assert all(words in told for words in ("KSP Residual norm", "solve converged", "type: gmres"))
    assert list(tmp_path.iterdir()) == []


def test_one_of_several_sections_is_named_by_its_number():
    """override, docstring: ``stimulus.2.strength=20``, from 1 on, but for one alone; another is refused."""
    data = {"stimulus": [{"strength": 1.0}, {"strength": 2.0}]}
    override(data, ["stimulus.2.strength=20.0", "stimulus.1={strength=3.0}"])
    assert data == {"stimulus": [{"strength": 3.0}, {"strength": 20.0}]}
    alone = {"stimulus": [{"strength": 1.0}]}
    override(alone, ["stimulus.strength=2.0", "stimulus.where.depth=1.0"])
    assert alone == {"stimulus": [{"strength": 2.0, "where": {"depth": 1.0}}]}
    for wrong in ("stimulus.3.strength=1.0", "stimulus.strength=1.0", "stimulus.0={}"):
        with pytest.raises(InputError, match="there are 2 of this section"):
            override(data, [wrong])


def test_a_model_takes_the_place_of_another_with_its_keys(tmp_path, caplog):
    """A model given by `--set` replaces what no longer fits, and says so; what fits or is given stays."""
    file = write_case(tmp_path / "case.toml", changed(SHEET, {"material.mu": 2.5, "activation.beta": 0.2}))
    case = Case.from_file(file, ["material.model=MooneyRivlin", "cell.model=AlievPanfilov1996", "cell.k=7.0"])
    assert case.parameters["material"]["model"] == "MooneyRivlin"
    assert case.parameters["cell"]["k"] == 7.0
    assert "tau" not in case.parameters["cell"]
    said = "\n".join(record.getMessage() for record in caplog.records)
    assert "cell.model is AlievPanfilov1996 now: left out of [cell] what it does not have: alpha" in said
    case = Case.from_file(file, ["activation.law=active-stress", "activation.tension=1.0"])
    assert case.law.tension == 1.0
    assert "left out of [activation] what it does not have: beta = 0.2, deformation = 'fibre'" in caplog.text
    caplog.clear()
    assert Case.from_file(file, ["material.model=NeoHookean", "activation.law=relaxing"]).law.beta == 0.2
    assert not caplog.records  # nothing had to go
    with pytest.raises(InputError, match=r"^cell.tau: no such key"):
        Case.from_file(file, ["cell.model=AlievPanfilov1996", "cell.tau=0.2"])
    with pytest.raises(InputError, match=r"^material.model: .*did you mean 'NeoHookean'"):
        Case.from_file(file, ["material.model=NeoHooke"])


@pytest.mark.parametrize(
    "assignment, words",
    [
        ("beta=0.2", "did you mean activation.beta?"),
        ("spacing=1.0", "did you mean geometry.spacing?"),
        ("relaxation_time=0.1", "did you mean mechanics.relaxation_time?"),
        ("tme=1.0", "did you mean 'time'?"),
    ],
)
def test_a_key_without_its_section_is_found(tmp_path, assignment, words):
    """Issue: "`--set beta=` suggests `activation.beta`"; keys of the case first, then those that may be."""
    with pytest.raises(InputError) as error:
        Case.from_file(write_case(tmp_path / "case.toml", LINE), [assignment])
    assert words in str(error.value)
