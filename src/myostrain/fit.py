"""Whether what mechanics is given fits together: body, kinematics, material, loads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.kinematics import Kinematics
from myostrain.materials import Material

import numpy as np

if TYPE_CHECKING:
    from myostrain.mechanics import ImposedStretch


def check_room(body: Body, fixed: Sequence[str]) -> None:
    """Refuse an incompressible body fixed all around: nothing would determine its pressure.

    Raises:
        InputError: It is.
    """
    boundary = body.boundary_facets(None)
    held = np.intersect1d(body.boundary_facets(fixed, "mechanics.fixed"), boundary)
    if fixed and body.comm.allreduce(len(held)) == body.comm.allreduce(len(boundary)):
        raise InputError(
            "the pressure of an incompressible body fixed all around is not determined; leave a part free",
            "mechanics.fixed",
        )


def check_fit(
    body: Body,
    kinematics: Kinematics,
    material: Material,
    robin: float,
    relaxation_time: float,
    stretch: ImposedStretch | None,
) -> None:
    """Refuse a material, a load or a viscosity that the kinematics of this body has no place for.

    Raises:
        InputError: It names the key, and what fits.
    """
    if kinematics.dim != body.dim:
        raise InputError(
            f"{type(kinematics).__name__} describes a body of dimension {kinematics.dim}, "
            f"this mesh has dimension {body.dim}",
            "mechanics.kinematics",
        )
    if material.tensor_dim != kinematics.tensor_dim:
        fitting = "Spring" if kinematics.tensor_dim == 1 else "NeoHookean or MooneyRivlin"
        raise InputError(
            f"{type(material).__name__} does not fit {type(kinematics).__name__}; take {fitting}",
            "material.model",
        )
    if stretch is not None and isinstance(stretch.value, tuple) and len(stretch.value) != body.dim:
        raise InputError(
            f"{list(stretch.value)}: give one number, or {body.dim}", "mechanics.imposed_stretch"
        )
    if not 0 <= robin < np.inf:
        raise InputError(f"{robin} is no stiffness: give zero or a positive number", "mechanics.robin")
    if not relaxation_time >= 0:
        raise InputError(f"{relaxation_time}: give zero or a positive time", "mechanics.relaxation_time")
    if relaxation_time > 0 and not hasattr(material, "modulus"):
        raise InputError(
            f"viscosity is scaled by a material's modulus at rest, and {type(material).__name__} has no "
            "attribute 'modulus'; add one, or give 0",
            "mechanics.relaxation_time",
        )
