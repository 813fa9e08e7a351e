"""Whether what mechanics is given fits together: body, kinematics, material, loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain import materials
from myostrain.course import Course, value_at
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.kinematics import Kinematics
from myostrain.materials import Material
from myostrain.mechanics.imposed_stretch import ImposedStretch
from myostrain.mechanics.supports import RigidMotions

import numpy as np


def check_room(body: Body, fixed: Sequence[str]) -> None:
    """Refuse an incompressible body fixed all around: nothing would determine its pressure.

    Raises:
        InputError: It is.
    """
    boundary = body.boundary_facets(None)
    held = np.intersect1d(body.boundary_facets(fixed, "mechanics.fixed"), boundary)
    if fixed and body.comm.allreduce(len(held)) == body.comm.allreduce(len(boundary)):
        raise InputError(
            "the pressure of an incompressible body held all around is not determined; leave a part free",
            "mechanics.fixed",
        )


def check_held(motions: RigidMotions, pressure: Mapping[str, Course], body_force: Any) -> None:
    """Refuse loads on a body that is free to follow them.

    Raises:
        InputError: They are.
    """
    if not motions.free.shape[1]:
        return
    if body_force is not None:
        raise InputError("a loaded body must be held: fix a part of it, or give robin > 0", "mechanics.fixed")
    pushes = {part: motions.push(part) for part in pressure}
    points = [point for course in pressure.values() if isinstance(course, Sequence) for point in course]
    for time in {point[0] for point in points} or {0.0}:
        values = {part: value_at(course, time) for part, course in pressure.items()}
        none = np.zeros(motions.free.shape[1])
        total = sum((values[part] * force for part, (force, _) in pushes.items()), none)
        scale = sum(abs(values[part]) * area for part, (_, area) in pushes.items())
        if np.abs(total).max() > 1e-6 * scale:
            raise InputError(
                "pressures push the body along a motion that nothing holds: fix a part of the boundary, let "
                "one slide in its plane, or give robin > 0",
                f"mechanics.pressure.{next(iter(pressure))}",
            )


def check_fit(
    body: Body,
    kinematics: Kinematics,
    material: Material,
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
        exported = (getattr(materials, name) for name in materials.__all__)
        fitting = [m.__name__ for m in exported if getattr(m, "tensor_dim", 0) == kinematics.tensor_dim]
        raise InputError(
            f"{type(material).__name__} does not fit {type(kinematics).__name__}; take one of "
            f"{', '.join(fitting)}",
            "material.model",
        )
    if stretch is not None and isinstance(stretch.value, tuple) and len(stretch.value) != body.dim:
        raise InputError(
            f"{list(stretch.value)}: give one number, or {body.dim}", "mechanics.imposed_stretch"
        )
    if not relaxation_time >= 0:
        raise InputError(f"{relaxation_time}: give zero or a positive time", "mechanics.relaxation_time")
    if relaxation_time > 0 and not hasattr(material, "modulus"):
        raise InputError(
            f"viscosity is scaled by a material's modulus at rest, and {type(material).__name__} has no "
            "attribute 'modulus'; add one, or give 0",
            "mechanics.relaxation_time",
        )
