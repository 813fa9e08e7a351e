"""Small coupled problems, and orders observed on them."""

from __future__ import annotations

import myostrain as ms

import numpy as np

#: The linear solver of the potential at round-off; its default stops at a relative residual of 1e-10.
TIGHT = {"ksp_rtol": 1e-14}

#: Bands for an observed order: from both sides, and narrower than the distance to the next order.
BANDS = {1: (0.85, 1.2), 2: (1.85, 2.3)}


def line(
    scheme=None,
    *,
    length=40.0,
    spacing=1.0,
    beta=0.3,
    law=None,
    membrane=None,
    balance="conservative",
    relaxation_time=0.0,
    held=None,
    initial=None,
    options=TIGHT,
):
    """The paper's line (D = A = 100), fixed at X = 0, mechanics solved far below the errors measured.

    ``held`` is the imposed stretch, (value, until); ``initial`` a function of X, a bump unless given.
    """
    body = ms.build(ms.geometry.Line(length=length, spacing=spacing))
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.Line(),
        material=ms.materials.Spring(),
        relaxation_time=relaxation_time,
        imposed_stretch=None if held is None else ms.ImposedStretch(value=held[0], until=held[1]),
        tolerance=1e-13,
        supports=ms.Supports(fixed=["left"]),
    )
    potential = ms.Potential(
        body,
        membrane=membrane or ms.membranes.FitzHughNagumo(),
        diffusivity=100.0,
        balance=balance,
        deformation=mechanics.deformation,
        options=options,
    )
    law = law or ms.activation.Proportional(beta=beta)
    model = ms.Electromechanics(potential, mechanics, law=law, scheme=scheme)
    potential.v.x.array[:] = (initial or gaussian)(coordinates(potential)[:, 0])
    return model


def sheet(scheme=None, *, kinematics=None, diffusivity=100.0, relaxation_time=0.0, cells=11, options=TIGHT):
    """A square sheet of side 30 on the elastic support (7.8), a bump in one corner, fibres along (1, −1)."""
    body = ms.build(
        ms.geometry.Rectangle(size=(30.0, 30.0), spacing=30.0 / cells),
        ms.UniformFibres(direction=(1.0, -1.0)),
    )
    mechanics = ms.Mechanics(
        body,
        kinematics=kinematics or ms.kinematics.PlaneStress(),
        material=ms.materials.NeoHookean(),
        relaxation_time=relaxation_time,
        tolerance=1e-11,
        supports=ms.Supports(robin=1.0),
    )
    potential = ms.Potential(
        body,
        membrane=ms.membranes.FitzHughNagumo(),
        diffusivity=diffusivity,
        deformation=mechanics.deformation,
        options=options,
    )
    model = ms.Electromechanics(potential, mechanics, scheme=scheme)
    potential.v.x.array[:] = 0.9 * np.exp(-((coordinates(potential) / 9) ** 2).sum(axis=1))
    return model


def gaussian(X, height=0.9):
    """A smooth bump around X = 0, symmetric there as the zero flux wants it."""
    return height * np.exp(-((X / 6) ** 2))


def coordinates(potential):
    """Material coordinates (nodes, dim) of the nodal values."""
    dim = potential.body.dim
    return potential.v.function_space.tabulate_dof_coordinates()[:, :dim]


def advance(model, step, end):
    """Run from time 0 to ``end`` in equal steps; returns the fields there by name."""
    model.start()
    for number in range(1, round(end / step) + 1):
        model.step(number * step)
    return fields(model)


def fields(model):
    """Copies of potential, states and displacement by name."""
    found = {name: values.copy() for name, values in model.potential.field_values().items()}
    if model.mechanics is not None:
        found["displacement"] = model.mechanics.u.x.array.copy()
    return found


def rms(values):
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def observed_orders(errors):
    """Orders between successive errors, each at half the step (or spacing) of the one before."""
    errors = np.asarray(errors, dtype=float)
    return np.log2(errors[:-1] / errors[1:])
