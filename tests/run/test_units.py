"""Units and titles: what a membrane declares, what a case or a script says, what pictures make of it."""

import dataclasses

import myostrain as ms
from myostrain.errors import InputError
from myostrain.output.figures.data import Recording

import pytest

from small_cases import LINE, changed


@dataclasses.dataclass(frozen=True)
class Millivolts(ms.membranes.FitzHughNagumo):
    """The paper's membrane as if it were in mV and ms: rest −80, peak about 20."""

    time_unit = "ms"
    potential_unit = "mV"
    range = (-90.0, 40.0)
    threshold = -30.0

    def resting_potential(self):
        return -80.0

    def current(self, v, states):
        return 100 * super().current((v + 80) / 100, states)

    def rates(self, v, states):
        return super().rates((v + 80) / 100, states)


def run(out=None, **options):
    body = ms.build(ms.geometry.Line(length=40.0, spacing=1.0))
    bump = ms.InitialValues(where=ms.Place(center=(0.0,), radius=5.0), potential=10.0)
    potential = ms.Potential(body, membrane=Millivolts(), diffusivity=100.0, initial=[bump])
    model = ms.Electromechanics(potential)
    return ms.Simulation(
        model, step=5e-3, end=0.9, probes={"a": (10.0,), "b": (30.0,)}, out=out, **options
    ).run()


def test_a_scripts_title_and_units_are_in_its_folder(tmp_path):
    """The membrane's units need not be said; labels, threshold, rest and range follow."""
    results = run(tmp_path, title="A strip in $", units={"length": "mm"})
    assert results["units"] == {"length": "mm", "time": "ms", "potential": "mV"}
    recording = Recording(tmp_path)
    (tmp_path / "case.toml").unlink(missing_ok=True)
    assert recording.title == "A strip in $"
    assert recording.label("$v$", "potential") == "$v$ (mV)"
    assert recording.label("$t$", "time") == "$t$ (ms)"
    assert recording.label("trace", "stress") == "trace"
    assert recording.rate_label("speed", "length", "time") == "speed (mm/ms)"
    assert recording.when(-1) == "$t$ = 0.9 ms"
    assert (recording.rest, recording.threshold) == (-80.0, -30.0)
    assert recording.potential_range(recording.field("potential")) == (-90.0, 40.0)


def test_without_units_labels_say_so(tmp_path):
    """Nothing is invented for a model without dimension; the title is the folder's name."""
    body = ms.build(ms.geometry.Line(length=10.0, spacing=1.0))
    model = ms.Electromechanics(ms.Potential(body, membrane=ms.membranes.FitzHughNagumo()))
    results = ms.Simulation(model, step=1e-3, end=2e-3, out=tmp_path / "quiet").run()
    assert results["units"] == {}
    recording = Recording(tmp_path / "quiet")
    assert recording.title == "quiet"
    assert recording.rate_label("speed", "length", "time") == "speed"


def test_a_potential_without_a_unit_is_not_in_millivolts():
    """Pictures would say mV beside values from 0 to 1."""
    with pytest.raises(InputError, match=r"FitzHughNagumo has no unit, it lies between .* leave it out"):
        ms.Case.from_dict(changed(LINE, {"units": {"potential": "mV"}}))


@pytest.mark.parametrize(
    "units, words",
    [
        ({"time": "s"}, "Millivolts counts the time in ms, not s"),
        ({"lenght": "mm"}, "units.lenght.*'length'"),
        ({"length": ""}, "units.length.*short text"),
    ],
)
def test_units_that_cannot_be(units, words):
    """One message, before the first step."""
    with pytest.raises(InputError, match=words):
        run(units=units)
