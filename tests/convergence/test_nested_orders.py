"""Orders in space where the potential has a mesh of its own: of each side with the other one fixed."""

import itertools

import myostrain as ms
from myostrain.engine import fem
from myostrain.geometry import refined
from myostrain.transfer import SameMesh

import numpy as np
import pytest

from coupled import BANDS, TIGHT, advance, coordinates, gaussian, observed_orders, rms

SIDE = 30.0


def mechanics_on(dim, cells):
    """A line, or a square sheet on the elastic support, of so many cells a side."""
    if dim == 1:
        form, kinematics, fibres = ms.geometry.Line(length=SIDE, spacing=SIDE / cells), "Line", None
    else:
        form = ms.geometry.Rectangle(size=(SIDE, SIDE), spacing=SIDE / cells)
        kinematics, fibres = "PlaneStress", ms.UniformFibres(direction=(1.0, -1.0))
    return ms.Mechanics(
        ms.build(form, fibres),
        kinematics=getattr(ms.kinematics, kinematics)(),
        material=ms.materials.Spring() if dim == 1 else ms.materials.NeoHookean(),
        supports=ms.Supports(fixed=["left"]) if dim == 1 else ms.Supports(robin=1.0),
        tolerance=1e-12,
    )


def differences(found):
    """Of successive pairs of places (n, dim) and values (n, columns), where the first of two has nodes."""
    made = []
    for (X, values), (Y, finer) in itertools.pairwise(found):
        place = {tuple(y): i for i, y in enumerate(np.round(Y, 6) + 0.0)}
        there = finer[[place[tuple(x)] for x in np.round(X, 6) + 0.0]]
        made.append([rms(column) for column in (values - there).T])
    return made


@pytest.mark.parametrize("dim", [1, 2])
def test_the_potential_on_a_body_that_is_given(dim):
    """A wave on a body whose deformation the coarse mesh holds: second order in the fine spacing."""
    mechanics = mechanics_on(dim, 10 if dim == 1 else 6)
    # Where linear displacements kink much, at the corners of coarse cells, the potential is not smooth.
    mechanics.u.interpolate(lambda x: 0.8 * np.sin(x[:dim] / 8) - x[:dim] / 10)
    mechanics.hand_over_present()
    found = []
    for level in range(1, 5):
        fine = refined(mechanics.body, level)
        transfer = ms.NestedMesh(mechanics, fine)
        transfer.hand_over()
        potential = ms.Potential(
            fine,
            membrane=ms.membranes.FitzHughNagumo(),
            diffusivity=100.0,
            deformation=transfer.deformation,
            options=TIGHT,
        )
        X = coordinates(potential)
        potential.v.x.array[:] = gaussian(np.linalg.norm(X, axis=1))
        advance(ms.Electromechanics(potential), 2e-3, 0.02)
        found.append((X, potential.v.x.array[:, None].copy()))
    orders = observed_orders(differences(found))[:, 0]
    assert BANDS[2][0] < orders[-1] < BANDS[2][1]


def activated(dim, cells, level):
    """Mechanics solved for a γ at the nodes of a finer mesh; the transfer, and those nodes' places."""
    mechanics = mechanics_on(dim, cells)
    fine = refined(mechanics.body, level)
    transfer = ms.NestedMesh(mechanics, fine) if level else SameMesh(mechanics)
    X = fem.functionspace(fine.mesh, ("Lagrange", 1)).tabulate_dof_coordinates()[:, :dim]
    mechanics.activation.x.array[:] = transfer.to_mechanics(strain(X))
    mechanics.start()
    transfer.hand_over()
    return transfer, X


def strain(X):
    """A smooth γ around the middle."""
    return -0.3 * np.exp(-(((X - SIDE / 2) / 5) ** 2).sum(axis=1))


def test_stretch_of_a_line_whose_activation_is_given():
    """x′ = 1 + γ (4.3): second order in the coarse spacing, γ being at the nodes of one fine mesh."""
    errors = []
    for level in (5, 4, 3):
        transfer, _ = activated(1, 384 // 2**level, level)
        F = transfer.deformation.F
        centres = F.function_space.tabulate_dof_coordinates()[:, :1]
        errors.append(rms(F.x.array - 1 - strain(centres)))
    orders = observed_orders(errors)
    assert BANDS[2][0] < orders[-1] < BANDS[2][1]


def test_sheet_whose_activation_is_given():
    """Second order of the displacement in the coarse spacing, γ being at the nodes of one fine mesh."""
    found = []
    for level in (3, 2, 1, 0):
        transfer, X = activated(2, 48 // 2**level, level)
        found.append((X, transfer.displacement().x.array.reshape(-1, 2).copy()))
    orders = observed_orders(differences(found))[-1]
    assert ((BANDS[2][0] < orders) & (orders < BANDS[2][1])).all()


def test_both_at_once():
    """A coupled sheet, both spacings halved together: second order of the potential and the displacement."""
    found = []
    for cells in (6, 12, 24, 48):
        mechanics = mechanics_on(2, cells)
        fine = refined(mechanics.body, 1)
        transfer = ms.NestedMesh(mechanics, fine)
        potential = ms.Potential(
            fine,
            membrane=ms.membranes.FitzHughNagumo(),
            diffusivity=100.0,
            deformation=transfer.deformation,
            options=TIGHT,
        )
        model = ms.Electromechanics(potential, mechanics, transfer=transfer)
        X = coordinates(potential)
        potential.v.x.array[:] = gaussian(np.linalg.norm(X - SIDE / 2, axis=1))
        advance(model, 5e-3, 0.03)
        u = transfer.displacement().x.array.reshape(-1, 2)
        found.append((X, np.column_stack([potential.v.x.array, u])))
    orders = observed_orders(differences(found))[-1]
    assert ((BANDS[2][0] < orders) & (orders < BANDS[2][1])).all()
