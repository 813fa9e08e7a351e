"""``myostrain cable``: the result folder, and status codes."""

import json

import pytest

from picture_tools import pixels
from small_cases import command_line

MODEL = "MitchellSchaeffer2003"


def test_a_result_folder(tmp_path):
    """What the page promises is there: numbers with units, the D for a wanted velocity, the picture."""
    out = tmp_path / "out"
    done = command_line(
        *("cable", MODEL, "--set", "tau_in=0.35", "--velocity", "0.4", "--diffusivity", "0.2"),
        *("--out", out, "--quiet"),
    )
    assert done.status == 0, done.err
    for said in ("40 cm/s", "off the wanted one", "mm²/ms"):
        assert said in done.out
    found = json.loads((out / "results.json").read_text())
    assert found["velocity"] == pytest.approx(0.4, rel=1e-6)
    assert found["velocity_cm_per_s"] == pytest.approx(40.0, rel=1e-6)
    assert (found["wanted"], found["tried"][0]["diffusivity"]) == (0.4, 0.2)
    assert found["tried"][0]["velocity"] / 0.4 == pytest.approx((0.2 / found["diffusivity"]) ** 0.5, rel=1e-6)
    assert found["meshes"][0]["spacing"] == pytest.approx(2 * found["meshes"][1]["spacing"])
    assert found["error"] < 2e-3
    assert found["parameters"]["tau_in"] == 0.35
    assert found["units"]["velocity"] == "mm/ms"
    assert (pixels(out / "figures" / "cable.png") < 200).any(axis=-1).mean() > 0.01
    again = command_line("cable", MODEL, "--out", out)
    assert again.status == 2
    assert "holds something already" in again.err


@pytest.mark.parametrize(
    "arguments, status, message",
    [
        (["BuenoOrovio"], 2, "MODEL: 'BuenoOrovio' is not a membrane; did you mean 'BuenoOrovio2008'?"),
        ([MODEL, "--set", "tau_inn=3"], 2, "cell.tau_inn: no such key; did you mean 'tau_in'?"),
        ([MODEL, "--diffusivity", "-1"], 2, "diffusivity: -1: give a positive number"),
        ([MODEL, "--mass", "consistent"], 2, "mass: 'consistent' is not a mass matrix"),
        ([MODEL, "--set", "stimulus.strength=0.05"], 3, "no wave: the stimulus of 0.05 for 1 on"),
        ([MODEL, "--diffusivity", "1e-4", "--spacing", "0.5"], 3, "no wave: it stops at X ="),
        ([MODEL, "--set", "tau_out=0.1"], 3, "the computation failed: no wave: a single cell"),
    ],
)
def test_wrong_input_and_no_wave(tmp_path, arguments, status, message):
    """2 for what cannot be, 3 for a cable that does not conduct; what to try is said, nothing written."""
    done = command_line("cable", *arguments, "--out", tmp_path / "out")
    assert done.status == status
    assert message in done.err
    assert not (tmp_path / "out").exists()
