"""What stretch, calcium and units laws get on bodies, and what they are refused."""

import myostrain as ms
from myostrain.activation import FibreTension, GoektepeKuhl2010, Hunter1998, Rossi2014, Timed
from myostrain.mechanics.nodal_fields import NodalFields
from myostrain.transfer import SameMesh

import numpy as np
import pytest

BODIES = {
    "line": (ms.geometry.Line(length=3.0), None, ms.kinematics.Line(), (0.9,)),
    "plane stress": (
        ms.geometry.Rectangle(size=(2.0, 1.0), spacing=0.5),
        ms.UniformFibres(direction=(1.0, 2.0)),
        ms.kinematics.PlaneStress(),
        (0.9, 1.2),
    ),
    "plane strain": (
        ms.geometry.Rectangle(size=(2.0, 1.0), spacing=0.5),
        ms.UniformFibres(direction=(1.0, 2.0)),
        ms.kinematics.PlaneStrain(),
        (0.8, 1.25),
    ),
    "solid": (
        ms.geometry.Slab(size=(2.0, 1.0, 1.0)),
        ms.UniformFibres(direction=(1.0, 2.0, -1.0)),
        ms.kinematics.Solid(),
        (0.8, 1.25, 1.0),
    ),
}


class Seen:
    """A law that keeps what drives it."""

    drivers = ("stretch",)

    def activation(self, states, drivers):
        self.stretch = drivers["stretch"]
        return 0.0 * drivers["stretch"]


def coupled(body, kinematics, law, *, levels=0, held=None, membrane=None, drive=None, **parts):
    line = isinstance(kinematics, ms.kinematics.Line)
    mechanics = ms.Mechanics(
        body,
        kinematics=kinematics,
        material=ms.materials.Spring() if line else ms.materials.NeoHookean(),
        active=FibreTension() if getattr(law, "yields", "strain") == "tension" else None,
        imposed_stretch=None if held is None else ms.ImposedStretch(value=held, until=float("inf")),
        **parts,
    )
    fine = ms.geometry.refined(body, levels)
    transfer = ms.NestedMesh(mechanics, fine) if levels else SameMesh(mechanics)
    if drive is not None:
        given = ms.GivenPotential(body, drive)
        return ms.Electromechanics(given, mechanics, law=law)
    potential = ms.Potential(
        fine,
        membrane=membrane or ms.membranes.FitzHughNagumo(),
        deformation=transfer.deformation,
        balance="advective",
    )
    return ms.Electromechanics(potential, mechanics, law=law, transfer=transfer)


@pytest.mark.parametrize("levels", [0, 1])
@pytest.mark.parametrize("name", BODIES)
def test_the_stretch_at_the_nodes(name, levels):
    """ActivationLaw.drivers, "stretch": |F f0| at each node of the potential's mesh, also a finer one."""
    geometry, fibres, kinematics, held = BODIES[name]
    body, law = ms.build(geometry, fibres), Seen()
    model = coupled(body, kinematics, law, levels=levels, held=held)
    model.start()
    model.step(1e-3)
    direction = np.array(fibres.direction) if fibres else np.ones(1)
    wanted = np.linalg.norm(np.array(held) * direction / np.linalg.norm(direction))
    assert abs(wanted - 1) > 0.02
    assert len(law.stretch) == len(model.potential.v.x.array)
    np.testing.assert_allclose(law.stretch, wanted, rtol=1e-12)


def test_a_law_without_the_stretch_pays_nothing(monkeypatch):
    """The stretch is assembled only where a law declares it."""
    asked = []
    original = NodalFields.mean_fibre_stretch
    monkeypatch.setattr(NodalFields, "mean_fibre_stretch", lambda self: asked.append(1) or original(self))
    body = ms.build(ms.geometry.Line(length=3.0))
    for law, wanted in ((ms.activation.Proportional(), 0), (Seen(), 4)):
        asked.clear()
        model = coupled(body, ms.kinematics.Line(), law, supports=ms.Supports(fixed=["left"]))
        model.start()
        for number in range(1, 4):
            model.step(number * 1e-3)
        assert len(asked) == wanted


class Millimolar(ms.membranes.Membrane):
    """Calcium that stays, in mM, with time in seconds."""

    states = ("calcium",)
    calcium, calcium_unit, time_unit = "calcium", "mM", "s"

    def __init__(self, **declared):
        self.__dict__.update(declared)

    def resting_states(self):
        return (0.9e-3,)

    def current(self, v, states):
        return 0.0 * v

    def rates(self, v, states):
        return [0.0 * v]


def on_a_line(law, membrane=None, drive=None, held=None):
    body = ms.build(ms.geometry.Line(length=3.0))
    supports = ms.Supports(fixed=["left"]) if held is None else None
    return coupled(
        body, ms.kinematics.Line(), law, membrane=membrane, drive=drive, held=held, supports=supports
    )


def test_a_law_gets_its_own_units():
    """ActivationLaw, units: "they are converted": calcium in mM and seconds give γ of μM and ms."""
    law = Rossi2014()
    model = on_a_line(law, Millimolar(), held=1.0)
    model.start()
    for number in range(1, 4):
        model.step(number * 5e-3)
    drivers = {"calcium": np.array([0.9]), "stretch": np.ones(1)}
    np.testing.assert_allclose(
        model.activation.values, law.advance(np.zeros((1, 1)), drivers, 15.0)[0, 0], rtol=1e-12
    )
    assert model.activation.values[0] < -0.005


FHN, BOCF = ms.membranes.FitzHughNagumo(), ms.membranes.BuenoOrovio2008()


class Strange(Rossi2014):
    units = "μM"  # type: ignore[misc]


class Other(Rossi2014):
    units = {"calcum": "μM"}  # noqa: RUF012


@pytest.mark.parametrize(
    "law, membrane, said",
    [
        (Rossi2014(), FHN, "'calcium' drives Rossi2014, and FitzHughNagumo has none; .* calcium: .*LuoRudy"),
        (Hunter1998(), FHN, "'calcium' drives Hunter1998"),
        (Rossi2014(), None, "a given potential has none"),
        (Rossi2014(), Millimolar(calcium_unit=None), "takes the calcium in μM, and .* without a unit"),
        (Rossi2014(), Millimolar(calcium_unit="μmol/g"), "takes the calcium in μM, .* in 'μmol/g'"),
        (GoektepeKuhl2010(), FHN, "takes the potential in mV, and this membrane has it without a unit"),
        (Strange(), BOCF, "give units by driver"),
        (Other(), BOCF, "'calcum', which does not drive it; did you mean 'calcium'"),
    ],
)  # fmt: skip
def test_other_units_are_refused(law, membrane, said):
    """Units checked: what a law cannot be given is said before the first step, with the key."""
    with pytest.raises(ms.InputError, match=said) as caught:
        on_a_line(law, membrane, drive=ms.Drive() if membrane is None else None)
    assert caught.value.key == "activation.law"


def test_a_timed_law_needs_no_electrics():
    """Timed: γ of the time in a body with a given potential, whatever that is."""
    law = Timed(gamma_min=-0.2, start=1.0, end=3.0)
    model = on_a_line(law, drive=ms.Drive())
    model.start()
    for time, gamma in ((1.5, -0.1), (2.0, -0.2), (4.0, 0.0)):
        model.step(time)
        np.testing.assert_allclose(model.mechanics.activation.x.array, gamma, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(model.mechanics.displacement().x.array.min(), 3 * gamma, atol=1e-8)


class Sudden:
    """γ that is no number from some time on."""

    drivers = ("time", "potential")

    def __init__(self, bad, when):
        self.bad, self.when = bad, when

    def activation(self, states, drivers):
        gamma = -0.1 * np.ones_like(drivers[self.drivers[1]])
        if drivers["time"] >= self.when:
            gamma[2] = self.bad
        return gamma


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_found_where_it_is(bad):
    """NodalActivation: at the start it is the input, in a step the computation; both name the place."""
    with pytest.raises(ms.InputError, match="not finite where the potential is 0"):
        on_a_line(Sudden(bad, 0.0))
    unmeasured = Sudden(bad, 0.0)
    unmeasured.drivers = ("time", "recovery")
    with pytest.raises(ms.InputError, match=rf"Sudden gives what is not finite near \[2.0\]: strain = {bad}"):
        on_a_line(unmeasured).start()
    model = on_a_line(Sudden(bad, 2e-3))
    model.start()
    model.step(1e-3)
    with pytest.raises(ms.ComputationError, match=r"not finite near \[2.0\].*Try: a smaller time step"):
        model.step(2e-3)


class Lost(Sudden):
    """A state that is no number, and does not show in γ."""

    drivers, states = ("potential",), ("hidden",)

    def initial_states(self, drivers):
        return (self.bad,)

    def advance(self, states, drivers, step):
        return states

    def activation(self, states, drivers):
        return -0.1 * drivers["potential"]


def test_a_state_that_is_not_finite_is_found():
    """The same of states."""
    with pytest.raises(ms.InputError, match="hidden = nan"):
        on_a_line(Lost(np.nan, 0.0)).start()
