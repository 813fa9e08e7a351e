"""Shared by the tests of segments: a body whose displacement and stress are prescribed, and its measures."""

from types import SimpleNamespace

import myostrain as ms
from myostrain.engine import fem
from myostrain.kinematics import Solid
from myostrain.output.measures import Measures

import numpy as np
import ufl

from small_cases import ALONE

#: The stress at every point; the fibre goes along Y.
STRESS = np.diag([2.0, 5.0, 1.0])


def prescribed(geometry, septum):
    """A stand-in for the mechanics of a body, with the measures of its segments."""
    body = ms.build(geometry, ms.UniformFibres(direction=(0.0, 1.0, 0.0)), ALONE)
    u = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1, (3,))))
    nodal = SimpleNamespace(cauchy=ufl.as_matrix(STRESS.tolist()))
    found = SimpleNamespace(
        body=body, u=u, kinematics=Solid(bulk_modulus=1.0), nodal=nodal, displacement=lambda: u
    )
    found.measures = Measures(found, septum)
    return found


def deformed(body, displacement):
    """Measures by name after a displacement of points (3, n)."""
    body.u.interpolate(displacement)
    return body.measures.values()
