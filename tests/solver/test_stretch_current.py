"""The current that stretch opens: its closed form on every body, where it is not, what it does to a wave."""

import myostrain as ms
from myostrain import Case
from myostrain.transfer import SameMesh

import numpy as np
import pytest

from small_cases import ALONE, LINE, REMOVED, SHEET, changed


class Passive(ms.membranes.Membrane):
    """A membrane without a current of its own."""

    def current(self, v, states):
        return 0.0 * v


class Millivolts(Passive):
    potential_unit, time_unit = "mV", "ms"
    range, threshold = (-90.0, 40.0), -20.0

    def resting_potential(self):
        return -85.0


FIBRES = {2: (1.0, 2.0), 3: (1.0, 2.0, -1.0)}


def held(stretch, *currents, levels=0, membrane=None):
    """A body that is held at stretches along its axes."""
    dim = len(stretch)
    if dim == 1:
        body, kinematics = ms.build(ms.geometry.Line(length=3.0)), ms.kinematics.Line()
    elif dim == 2:
        rectangle = ms.geometry.Rectangle(size=(2.0, 1.0), spacing=0.5)
        body = ms.build(rectangle, ms.UniformFibres(direction=FIBRES[2]))
        kinematics = ms.kinematics.PlaneStress()
    else:
        body = ms.build(ms.geometry.Slab(size=(2.0, 1.0, 1.0)), ms.UniformFibres(direction=FIBRES[3]))
        kinematics = ms.kinematics.Solid()
    mechanics = ms.Mechanics(
        body,
        kinematics=kinematics,
        material=ms.materials.Spring() if dim == 1 else ms.materials.NeoHookean(),
        imposed_stretch=ms.ImposedStretch(value=stretch, until=float("inf")),
    )
    fine = ms.geometry.refined(body, levels)
    transfer = ms.NestedMesh(mechanics, fine) if levels else SameMesh(mechanics)
    potential = ms.Potential(
        fine,
        membrane=membrane or Passive(),
        deformation=transfer.deformation,
        balance="advective",
        stretch_currents=currents,
        options={"ksp_rtol": 1e-14},
    )
    return ms.Electromechanics(potential, mechanics, transfer=transfer, scheme=ms.Staggered())


def fibre(stretch):
    direction = np.array(FIBRES[len(stretch)])
    return np.linalg.norm(np.array(stretch) * direction / np.linalg.norm(direction))


WIDE, LONG = (1.3, 0.9), (1.25, 0.8, 1.0)
MEASURED = {
    "line": ((1.2,), None, 1.2),
    "fibre of a line": ((1.2,), "fibre", 1.2),
    "area": (WIDE, None, 1.3 * 0.9),
    "fibre of a sheet": ((0.9, 1.3), "fibre", fibre((0.9, 1.3))),
    "fibre of a solid": ((0.8, 1.25, 1.0), None, fibre((0.8, 1.25, 1.0))),
}


@pytest.mark.parametrize("levels", [0, 1])
@pytest.mark.parametrize("conductance", [0.7, 1e6])
@pytest.mark.parametrize("name", MEASURED)
def test_the_current_of_a_held_body(name, conductance, levels):
    """StretchCurrent: dv/dt = −g (√C − 1) (v − 1), implicit: one step of backward Euler, however large g."""
    stretch, measure, root = MEASURED[name]
    assert root > 1.01
    model = held(stretch, ms.StretchCurrent(conductance=conductance, measure=measure), levels=levels)
    model.potential.v.x.array[:] = 0.2
    model.start()
    model.step(0.5)
    rate = conductance * (root - 1)
    np.testing.assert_allclose(model.potential.v.x.array, (0.2 / 0.5 + rate) / (1 / 0.5 + rate), rtol=1e-9)


def test_the_current_in_millivolts():
    """StretchCurrent: −10 mV, and the whole conductance at a stretch of 1.15, for a membrane in mV."""
    current = ms.StretchCurrent(conductance=0.3)
    model = held((1.06,), current, membrane=Millivolts())
    model.start()
    model.step(0.5)
    rate = 0.3 * 0.06 / 0.15
    np.testing.assert_allclose(
        model.potential.v.x.array, (-85 / 0.5 - 10 * rate) / (1 / 0.5 + rate), rtol=1e-9
    )


MEMBRANES = [name for name in ms.membranes.__all__ if hasattr(getattr(ms.membranes, name), "pacing")]


@pytest.mark.parametrize("name", [n for n in MEMBRANES if n not in ("Membrane", "FileMembrane")])
def test_the_current_beside_every_membrane(name):
    """StretchCurrent: "beside the membrane's current": each is driven from its rest towards the reversal."""
    membrane = getattr(ms.membranes, name)()
    rest, ends = membrane.resting_potential(), {}
    for conductance in (0.0, 2.0):
        model = held((1.1,), ms.StretchCurrent(conductance=conductance), membrane=membrane)
        reversal = model.potential.made_from["stretch_currents"][0].fitting(membrane, 1).reversal
        model.start()
        for number in range(1, 4):
            model.step(number * 1e-3)
        ends[conductance] = model.potential.v.x.array.copy()
    # As a rate that acts for 3e-3, beside which the membrane has hardly changed.
    opened = 2.0 * 0.1 / (0.15 if membrane.potential_unit == "mV" else 1.0)
    wanted = opened * 3e-3 * (reversal - rest)
    np.testing.assert_allclose(ends[2.0] - ends[0.0], wanted, rtol=0.15)


def test_what_is_shortened_has_no_current():
    """StretchCurrent: "what is shortened has no such current"."""
    for stretch in ((1.0,), (0.8,), (0.9, 1.05)):
        model = held(stretch, ms.StretchCurrent(conductance=5.0))
        model.potential.v.x.array[:] = 0.2
        model.start()
        model.step(0.5)
        np.testing.assert_allclose(model.potential.v.x.array, 0.2, rtol=1e-14)


def test_the_conductance_by_place():
    """StretchCurrent, where: "Several currents add up"; a script may give nodal values."""
    left = ms.Place(center=(0.0,), radius=1.0)
    currents = (
        ms.StretchCurrent(conductance=1.0),
        ms.StretchCurrent(conductance=2.0, where=left, reversal=0.5),
        ms.StretchCurrent(conductance=np.array([0.0, 0.0, 0.0, 4.0])),
    )
    model = held((1.2,), *currents)
    slope, offset = (getattr(_updated(model), name) for name in ("slope", "offset"))
    np.testing.assert_allclose(slope, [0.6, 0.6, 0.2, 1.0], rtol=1e-12)
    np.testing.assert_allclose(offset, [0.4, 0.4, 0.2, 1.0], rtol=1e-12)


def _updated(model):
    model.start()
    return model.potential._stretch


@pytest.mark.parametrize(
    "given, said",
    [
        ({"conductance": -1.0}, "conductance: this should be finite and zero or more"),
        ({"conductance": np.nan}, "conductance: this should be finite"),
        ({"conductance": "much"}, "conductance: give a number"),
        ({"conductance": np.ones(3)}, r"conductance has the shape \(3,\); give a number or \(4,\)"),
        ({"conductance": 1.0, "measure": "area"}, "'area' is none of a body of 1 dimensions; .* line, fibre"),
        ({"conductance": 1.0, "span": 0.0}, "span"),
    ],
)
def test_wrong_currents_are_refused(given, said):
    """StretchCurrent, Potential: what does not fit is one message."""
    with pytest.raises(ms.InputError, match=said):
        held((1.2,), ms.StretchCurrent(**given))


def test_a_rigid_body_has_no_stretch():
    """Potential: a stretch-activated current of a rigid body is refused."""
    body = ms.build(ms.geometry.Line(length=3.0))
    with pytest.raises(ms.InputError, match="a rigid body is not stretched") as caught:
        ms.Potential(body, membrane=Passive(), stretch_currents=[ms.StretchCurrent(conductance=1.0)])
    assert caught.value.key == "cell.stretch_current"


# In cases.

PULSE = changed(
    LINE,
    {
        "geometry.length": 60.0,
        "cell": {"model": "AlievPanfilov1996"},
        "potential": {"diffusivity": 1.0, "balance": "advective"},
        "time.step": 0.1,
        "time.end": 1.0,
        "probes": REMOVED,
    },
)


def test_the_key_of_a_case():
    """cell.stretch_current: what is left out is resolved by membrane and body; several, with places."""
    one = Case.from_dict(changed(PULSE, {"cell.stretch_current": {"conductance": 0.5}}))
    resolved = {"conductance": 0.5, "reversal": 1.0, "measure": "line", "span": 1.0}
    assert one.parameters["cell"]["stretch_current"] == resolved
    several = changed(
        SHEET,
        {
            "cell": {
                "model": "BuenoOrovio2008",
                "stretch_current": [
                    {"conductance": 0.1},
                    {"conductance": 0.2, "center": [10.0, 12.0], "radius": 3.0},
                ],
            },
        },
    )
    case = Case.from_dict(several)
    first, second = case.parameters["cell"]["stretch_current"]
    assert first == {"conductance": 0.1, "reversal": -10.0, "measure": "area", "span": 0.15}
    assert second["radius"] == 3.0
    assert Case.from_dict(case.parameters).stretch_currents == case.stretch_currents


@pytest.mark.parametrize(
    "given, key, said",
    [
        (0.5, "cell.stretch_current", r"give a table, such as \{ conductance = 0.5 \}"),
        ({}, "cell.stretch_current.conductance", "missing"),
        ({"conductance": 1.0, "reversl": 0.0}, "cell.stretch_current.reversl", "did you mean 'reversal'"),
        ({"conductance": 1.0, "radius": 3.0}, "cell.stretch_current", "a ball takes center and radius"),
        ({"conductance": 1.0, "measure": "area"}, "cell.stretch_current.measure", "allowed: line, fibre"),
        ([{"conductance": 1.0}, {"conductance": -1.0}], "cell.stretch_current.2.conductance", "zero or more"),
    ],
)
def test_wrong_keys(given, key, said):
    """cell.stretch_current: every message names the key."""
    with pytest.raises(ms.InputError, match=said) as caught:
        Case.from_dict(changed(PULSE, {"cell.stretch_current": given}))
    assert str(caught.value).startswith(f"{key}: ")


def wave(conductance, *, clamped, steps):
    """The potential after so many steps, and when the wave passed the middle of the line."""
    changes = {} if conductance is None else {"cell.stretch_current": {"conductance": conductance}}
    changes |= {"mechanics.fixed": ["left", "right"]} if clamped else {}
    model = Case.from_dict(changed(PULSE, changes)).build(ALONE)
    v = model.potential.v.x.array
    middle = np.abs(model.potential.v.function_space.tabulate_dof_coordinates()[:, 0] - 30.0).argmin()
    model.start()
    before, arrival = 0.0, np.inf
    for number in range(1, steps + 1):
        model.step(number * 0.1)
        if before < 0.5 <= v[middle]:
            arrival = (number - 1 + (0.5 - before) / (v[middle] - before)) * 0.1
        before = v[middle]
    return v.copy(), arrival


def test_a_free_line_never_stretches():
    """A null test: with the current and without it, the same bits."""
    without, _ = wave(None, clamped=False, steps=150)
    with_it, _ = wave(3.0, clamped=False, steps=150)
    assert without.max() > 0.9
    np.testing.assert_array_equal(with_it, without)


def test_a_clamped_line_is_excited_ahead_of_the_wave():
    """What contracts stretches the rest of a line with held ends: the larger g, the earlier."""
    arrivals = [wave(g, clamped=True, steps=200)[1] for g in (0.0, 0.5, 1.0, 2.0)]
    assert arrivals[0] == pytest.approx(19.07, rel=0.03)
    assert arrivals[1] < 0.9 * arrivals[0]
    assert arrivals[2] < 0.7 * arrivals[1]
    assert arrivals[3] < 0.7 * arrivals[2]
