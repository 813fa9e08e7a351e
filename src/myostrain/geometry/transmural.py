"""What varies through the wall of a body."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

from myostrain.engine import fem
from myostrain.errors import InputError
from myostrain.geometry.body import Body
from myostrain.geometry.harmonic import harmonic

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

KEY = "activation.transmural_between"

#: Depths at the nodes of meshes that are in use, by the sides of the wall: several layers are of one depth.
_known: WeakKeyDictionary[Any, dict[Any, Array]] = WeakKeyDictionary()


def transmural(body: Body, ends: tuple[float, float], between: tuple[str, str] | None = None) -> Array:
    """A factor that is linear in the depth of the wall, at the nodes of P1 (nodes,).

    Args:
        body: The body.
        ends: The factor at the endocardium and at the epicardium.
        between: Parts of the boundary to take for them; see :func:`depth`.

    Raises:
        InputError: The body has not these parts, or they meet.
    """
    return ends[0] + (ends[1] - ends[0]) * nodal_depth(body, between)


def nodal_depth(body: Body, between: tuple[str, str] | None = None, key: str = KEY) -> Array:
    """The depth in the wall at the nodes of P1 (nodes,), not to be changed; see :func:`depth`."""
    known = _known.setdefault(body.mesh, {})
    if between not in known:
        nodal = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1)))
        nodal.interpolate(depth(body, between, key))
        known[between] = nodal.x.array.copy()
        known[between].flags.writeable = False
    return known[between]


def depth(body: Body, between: tuple[str, str] | None = None, key: str = KEY) -> fem.Function:
    """The depth in the wall, P2: harmonic, 0 at the endocardium and 1 at the epicardium.

    Args:
        body: The body.
        between: Parts of the boundary to take for them; all whose names begin with "endocardium" and
            "epicardium" unless given.
        key: Key of a case file that names them, for the message.

    Raises:
        InputError: The body has not these parts, or they meet.
    """
    known = body.meshed.boundaries
    names = [[name] for name in between or ()]
    if not names:
        names = [[n for n in known if n.startswith(start)] for start in ("endocardium", "epicardium")]
        if not all(names):
            raise InputError(
                f"name the two sides of the wall: this body has the boundaries {', '.join(known) or 'none'}",
                key,
            )
    space = fem.functionspace(body.mesh, ("Lagrange", 2))
    dofs = [
        fem.locate_dofs_topological(space, body.dim - 1, body.boundary_facets(side, key)) for side in names
    ]
    if body.comm.allreduce(len(np.intersect1d(*dofs))):
        raise InputError(f"the parts {names[0]} and {names[1]} of the boundary meet: there is no wall", key)
    found = harmonic(space, [(0.0, dofs[0]), (1.0, dofs[1])])
    found.name = "depth"
    return found
