"""``myostrain cell``: the result folder, and what it says of wrong input."""

import json
from unittest import mock

import myostrain as ms
from myostrain import Case, conduction, single_cell  # both, before a test replaces what one has of the other
from myostrain.single_cell.record import end_state

import numpy as np
import pytest

from cell_files import ODE
from small_cases import LINE, changed, command_line


def test_a_result_folder(tmp_path):
    """What interface and page promise is there."""
    out = tmp_path / "out"
    done = command_line(
        *("cell", "BuenoOrovio2008", "--set", "set=ENDO", "--set", "stimulus.strength=40", "--beats", "2"),
        *("--cycle", "600", "--out", out, "--quiet"),
    )
    assert done.status == 0, done.err
    assert "apd90" in done.out
    found = json.loads((out / "results.json").read_text())
    assert found["parameters"]["set"] == "ENDO"
    assert found["model"] == "BuenoOrovio2008"
    assert found["stimulus"] == {"strength": 40.0, "duration": 1.0}
    assert len(found["beats"]) == 2
    assert found["beats"][1]["apd90"] == found["apd90"]
    assert found["alternans"] == pytest.approx(abs(found["beats"][0]["apd90"] - found["apd90"]))
    assert found["units"]["apd90"] == "ms"
    assert found["units"]["peak"] == "mV"
    table = np.genfromtxt(out / "trace.csv", delimiter=",", names=True)
    assert table.dtype.names == ("time", "potential", "calcium", "v", "w", "s")
    assert (table["time"][0], table["time"][-1]) == (0.0, 1200.0)
    assert table["potential"].max() == pytest.approx(max(b["peak"] for b in found["beats"]), abs=1.0)
    assert (out / "figures" / "cell.png").stat().st_size > 10_000
    with mock.patch("myostrain.single_cell.cell", side_effect=AssertionError("the work was done")):
        again = command_line("cell", "BuenoOrovio2008", "--beats", "1", "--out", out)
    assert again.status == 2
    assert "holds something already" in again.err
    assert "--resume" not in again.err
    weak = command_line(
        *("cell", "BuenoOrovio2008", "--set", "stimulus.strength=5", "--beats", "1", "--out", out, "--force")
    )
    assert weak.status == 0
    assert "none: the stimulus did not excite" in weak.out
    assert json.loads((out / "results.json").read_text())["apd90"] is None


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["BuenoOrovio"], "MODEL: 'BuenoOrovio' is not a membrane; did you mean 'BuenoOrovio2008'?"),
        (["LuoRudy1991", "--set", "g_na=3"], "cell.g_na: no such key; did you mean 'g_Na'?"),
        (["LuoRudy1991", "--set", "stimulus.strenght=3"], "give stimulus.strength and stimulus.duration"),
        (["LuoRudy1991", "--beats", "0"], "beats: 0: give a number of beats"),
        (
            ["LuoRudy1991", "--cycle", "1e9"],
            "cycle: 1e+09: that makes 1e+11 steps of 0.01; give 2e+05 at most",
        ),
        (["LuoRudy1991", "--set", "cell.g_na=3"], "cell.g_na: no such key; did you mean 'g_Na'?"),
    ],
)
def test_wrong_input(tmp_path, arguments, message):
    done = command_line("cell", *arguments, "--out", tmp_path / "out")
    assert done.status == 2
    assert message in done.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["cell", "cable"])
def test_a_folder_that_cannot_be_made_is_said_before_the_work(tmp_path, monkeypatch, command):
    """Not after all beats; nothing is left where the folder would have been."""
    (tmp_path / "file").touch()
    monkeypatch.setattr(single_cell, "cell", None)
    monkeypatch.setattr(conduction, "cable", None)
    for out in ("/proc/new", tmp_path / "file" / "new"):
        done = command_line(command, "MitchellSchaeffer2003", "--out", out)
        assert done.status == 2, done.err
        assert f"the folder {out} cannot be written" in done.err
    assert [each.name for each in tmp_path.iterdir()] == ["file"]


def test_a_file_declares_no_stimulus(tmp_path):
    """cells.md: "one from a file declares none, so say it"; the message says how."""
    pytest.importorskip("gotranx")
    (tmp_path / "cell.ode").write_text(ODE)
    done = command_line("cell", tmp_path / "cell.ode", "--out", tmp_path / "out")
    assert done.status == 2
    assert "--set stimulus.strength=40 --set stimulus.duration=1" in done.err


def test_a_file_whose_stimulus_is_named(tmp_path):
    """docs/howto/cell-files.md: `--set 'stimulus=["i_pulse"]'`; `pacing` is what paces it then."""
    text = """parameters(g=1.0)
states(v=-80.0)
i_pulse = Conditional(Lt(time, 1), 40, 0)
dv_dt = -g*(v + 80)*0.01 + i_pulse
"""
    (tmp_path / "named.ode").write_text(text, encoding="utf-8")
    short = ("--beats", "1", "--cycle", "5", "--step", "0.5", "--set", "pacing=[40.0, 1.0]")
    command = ("cell", tmp_path / "named.ode", *short)
    refused = command_line(*command, "--out", tmp_path / "a")
    assert (refused.status, "name it: stimulus = [...]" in refused.err) == (2, True)
    done = command_line(*command, "--set", 'stimulus=["i_pulse"]', "--out", tmp_path / "b")
    assert done.status == 0, done.err
    found = json.loads((tmp_path / "b" / "results.json").read_text())
    assert found["parameters"]["stimulus"] == ["i_pulse"]
    with mock.patch("myostrain.single_cell.record.new_figure", side_effect=AssertionError) as drawn:
        command_line(*command, "--set", 'stimulus=["i_pulse"]', "--out", tmp_path / "c")
    assert drawn.call_args.args[2] == "named, beat 1"  # the file's name, not FileMembrane
    assert found["peak"] == pytest.approx(-80 + 40 * (1 - np.exp(-0.01)) / 0.01, abs=0.5)


def test_another_file_is_no_cell_to_begin_with(tmp_path):
    """The states of both are named, as both are of the class FileMembrane."""

    class FileMembrane:
        states = ("m", "h")

    (tmp_path / "results.json").write_text(
        '{"model": "FileMembrane", "parameters": {}, "end": {"potential": 0.0, "w": 1.0}}'
    )
    with pytest.raises(ms.InputError, match=r"states potential, w, and the membrane has potential, m, h"):
        end_state(tmp_path, FileMembrane(), "FileMembrane", {})


def test_without_a_model_they_are_listed():
    done = command_line("cell")
    assert done.status == 0
    assert "TenTusscherPanfilov2006" in done.out


def test_a_tissue_begins_where_the_cell_ended(tmp_path, caplog):
    """Rest of the body: potential and states of the cell's end; another model is refused, parameters warn."""
    out = tmp_path / "out"
    model = "MitchellSchaeffer2003"
    assert command_line("cell", model, "--beats", "2", "--cycle", "400", "--out", out).status == 0
    end = json.loads((out / "results.json").read_text())["end"]
    data = changed(LINE, {"cell": {"model": model, "initial": str(out)}})
    (tmp_path / "case.toml").write_text(Case.from_dict(data).to_toml(), encoding="utf-8")
    case = Case.from_file(tmp_path / "case.toml")
    assert case.parameters["cell"]["initial"] == str(out)
    potential = case.build().potential
    far = np.argmax(potential.v.function_space.tabulate_dof_coordinates()[:, 0])
    assert potential.v.x.array[far] == end["potential"] != 0.0
    assert (potential.states[0] == end["h"]).all()
    assert end["h"] < 0.95
    assert not caplog.records
    Case.from_dict(changed(data, {"cell.tau_in": 0.31})).build()
    assert "tau_in 0.3 there, 0.31 here" in caplog.text
    with pytest.raises(
        ms.InputError, match=r"^cell\.initial: .* is of MitchellSchaeffer2003, and the membrane"
    ):
        Case.from_dict(changed(LINE, {"cell": {"model": "LuoRudy1991", "initial": str(out)}})).build()
    with pytest.raises(ms.InputError, match=r"^cell.initial: .*results.json cannot be used: No such file"):
        Case.from_dict(changed(LINE, {"cell": {"model": model, "initial": "nowhere"}})).build()


@pytest.mark.parametrize("changes", [["--step", "5"], ["--set", "cell.stimulus.strength=1e6"]])
def test_a_potential_far_away_is_no_result(tmp_path, changes):
    """Steps too long, or a stimulus too strong: a failed computation in place of numbers."""
    done = command_line("cell", "BuenoOrovio2008", *changes, "--beats", "1", "--out", tmp_path / "out")
    assert done.status == 3
    assert "the potential is " in done.err
    assert "far out of its range (-85.0, 50.0)" in done.err
    assert not (tmp_path / "out").exists()
