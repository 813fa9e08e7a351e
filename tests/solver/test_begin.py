"""What a run begins with: what a script sets is taken, and what it leaves alone begins as before."""

import myostrain as ms

import numpy as np
import pytest

from coupled import coordinates, line

STEP, END = 1e-3, 8e-3


def run(model, end=END):
    """One simulation of the model; its fields at the end, as copies."""
    ms.Simulation(model, step=STEP, end=end).run()
    found = {name: values.copy() for name, values in model.potential.field_values().items()}
    return {**found, "displacement": model.mechanics.u.x.array.copy()}


def assert_same(one, other):
    assert one.keys() == other.keys()
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)


def differ(one, other, name="potential"):
    return np.abs(one[name] - other[name]).max() > 1e-3


def placed(scheme=None):
    """A contracting line whose initial values are given."""
    body = ms.build(ms.geometry.Line(length=20.0))
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.Line(),
        material=ms.materials.Spring(),
        supports=ms.Supports(fixed=["left"]),
    )
    values = dict(potential=0.9, states={"recovery": 0.05})
    potential = ms.Potential(
        body,
        membrane=ms.membranes.FitzHughNagumo(),
        diffusivity=100.0,
        deformation=mechanics.deformation,
        initial=[ms.InitialValues(where=ms.Place(center=(0.0,), radius=5.0), **values)],
    )
    return ms.Electromechanics(potential, mechanics, scheme=scheme)


@pytest.mark.parametrize("scheme", [ms.Implicit(), ms.Staggered(), ms.SecondOrder(every=2)], ids=str)
def test_running_twice_gives_the_same_bits(scheme):
    """A second simulation of one model, and a second run of one simulation, repeat the first one."""
    model = placed(scheme)
    first = run(model)
    assert_same(run(model), first)
    simulation = ms.Simulation(model, step=STEP, end=END)
    metrics = [simulation.run()["metrics"] for _ in range(2)]
    assert metrics[0] == metrics[1]
    assert_same(run(placed(scheme)), first)


def test_what_a_script_sets_once_is_kept_for_later_runs():
    """The potential, set by hand before the first run only."""
    model = line(ms.SecondOrder(), length=20.0)
    first = run(model)
    assert first["potential"].max() > 0.5
    assert_same(run(model), first)


def test_states_that_a_script_sets_are_taken():
    """Potential: "A script may change ``v`` and ``states`` before a run"."""
    model = placed()
    first = run(model)
    fresh = placed()
    fresh.potential.states[:] = 0.2
    changed = run(fresh)
    assert differ(changed, first, "recovery")
    # Between runs too; the potential, which is left alone, begins as the last run began.
    model.potential.states[:] = 0.2
    assert_same(run(model), changed)
    assert_same(run(model), changed)
    # And back: one node of it is enough.
    model.potential.states[:] = placed().potential.states
    assert_same(run(model), first)


def test_a_potential_that_a_script_sets_between_runs():
    """The states, which are left alone, begin as the last run began, not as it ended."""
    model = placed()
    run(model)
    X = coordinates(model.potential)[:, 0]
    model.potential.v.x.array[:] = 0.7 * (X > 15.0)
    other = placed()
    other.potential.v.x.array[:] = 0.7 * (X > 15.0)
    assert_same(run(model), run(other))


def test_a_run_that_goes_on_by_hand():
    """What a script sets to the end of a run as a copy with a change somewhere is what it begins with."""
    model = placed()
    found = run(model)
    model.potential.v.x.array[:] = found["potential"] + 1e-9
    model.potential.states[0][:] = found["recovery"] + 1e-9
    model.start()
    np.testing.assert_array_equal(model.potential.v.x.array, found["potential"] + 1e-9)
    np.testing.assert_array_equal(model.potential.states[0], found["recovery"] + 1e-9)


def test_reset():
    """Potential.reset: rest and the initial values, whatever is there."""
    model, fresh = placed(), placed()
    first = run(fresh)
    model.potential.v.x.array[:] = 0.3
    model.potential.states[:] = 0.4
    run(model)
    model.potential.reset()
    for name, values in placed().potential.field_values().items():
        np.testing.assert_array_equal(model.potential.field_values()[name], values)
    assert_same(run(model), first)


def test_a_longer_run_has_the_shorter_one_in_it():
    """A second simulation with another end begins anew, not where the first one ended."""
    model = placed()
    run(model, END)
    longer = run(model, 2 * END)
    assert_same(run(placed(), 2 * END), longer)
