"""Whether what mechanics is given fits together: body, kinematics, material, supports, loads."""

from __future__ import annotations

from collections.abc import Sequence

from myostrain import materials
from myostrain.course import value_at
from myostrain.engine import MPI
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.kinematics import Kinematics
from myostrain.materials import Material
from myostrain.mechanics.cavities import Cavities, CavityPressures
from myostrain.mechanics.external_forces import ExternalForces
from myostrain.mechanics.imposed_stretch import ImposedStretch
from myostrain.mechanics.loads import Loads, times_of, vector_at
from myostrain.mechanics.motion import Drift, Inertia
from myostrain.mechanics.rigid_motions import RigidMotions, surface
from myostrain.mechanics.supports import AXES, FLAT, Hold, Supports, plane_axis

import numpy as np


def free_motions(
    body: Body,
    holds: Sequence[Hold],
    external: ExternalForces,
    supports: Supports,
    loads: Loads,
    mixed: bool,
    motion: Drift | None,
    cavities: CavityPressures,
) -> RigidMotions:
    """The rigid motions that supports leave free, with what is given checked against them.

    Args:
        body: The reference body.
        holds: Components of the displacement that are held.
        external: What acts from outside, elastic supports among it.
        supports: What holds the body.
        loads: What pushes and pulls it.
        mixed: Whether a pressure is unknown.
        motion: What the balance of forces has of the motion.
        cavities: Pressures of cavities.

    Raises:
        InputError: A free body is loaded or damped without inertia, or begins loaded; or the pressure is not
            determined.
    """
    on_springs = [
        (parts, range(body.dim) if normal is None else None) for _, parts, normal in external.springs
    ]
    if mixed and not on_springs:
        check_room(body, supports, holds)
    motions = RigidMotions(body, [*(([hold.part], [hold.axis]) for hold in holds), *on_springs])
    if not isinstance(motion, Inertia):
        check_held(motions, loads, cavities.cavities)
        if motion is not None and motions.free.shape[1]:
            raise InputError(
                "dampers do not hold a body without inertia: fix a part, give robin > 0, or density > 0",
                next(key for *_, key in supports.dampers()),
            )
    elif cavities.loaded and motions.free.size:
        raise InputError(
            "the body begins in equilibrium with it, and rigid motions are free: fix a part of the boundary, "
            "give robin > 0, or a preload of 0",
            "circulation.preload",
        )
    return motions


def check_room(body: Body, supports: Supports, holds: Sequence[Hold]) -> None:
    """Refuse an incompressible body held all around: nothing would determine its pressure.

    Raises:
        InputError: It is.
    """
    parts = {*supports.fixed, *supports.sliding}
    for part in supports.displacement:
        axes = {hold.axis for hold in holds if hold.part == part}
        if len(axes) == body.dim or _flat_axis(body, part) in axes:
            parts.add(part)
    boundary = body.boundary_facets(None)
    held = np.intersect1d(body.boundary_facets(sorted(parts)), boundary)
    if parts and body.comm.allreduce(len(held)) == body.comm.allreduce(len(boundary)):
        raise InputError(
            "the pressure of an incompressible body held all around is not determined; leave a part free",
            "mechanics.fixed",
        )


def _flat_axis(body: Body, part: str) -> int | None:
    """The axis across which a part of the boundary is plane, if there is one."""
    try:
        return plane_axis(body, part)
    except InputError:
        return None


def check_held(motions: RigidMotions, loads: Loads, cavities: Sequence[str] = ()) -> None:
    """Refuse loads, and pressures of cavities, on a body that is free to follow them.

    Raises:
        InputError: They are.
    """
    if not motions.free.shape[1]:
        return
    if loads.body_force is not None:
        raise InputError("a loaded body must be held: fix a part of it, or give robin > 0", "mechanics.fixed")
    if any(np.abs(force).max() > 1e-6 * area for force, area in map(motions.push, cavities)):
        raise InputError(
            "the pressure in a cavity pushes the body along a motion that nothing holds: fix a part of the "
            "boundary, let the base slide in its plane, or give robin > 0",
            "mechanics.sliding",
        )
    pressed = {part: motions.push(part) for part in loads.pressure}
    pulled = {
        part: [motions.push(part, axis) for axis in np.eye(len(motions.middle))] for part in loads.traction
    }
    for time in times_of(loads):
        total, scale = np.zeros(motions.free.shape[1]), 0.0
        for part, (force, area) in pressed.items():
            value = value_at(loads.pressure[part], time)
            total, scale = total + value * force, scale + abs(value) * area
        for part, pushes in pulled.items():
            for value, (force, area) in zip(vector_at(loads.traction[part], time), pushes, strict=True):
                total, scale = total + value * force, scale + abs(value) * area
        if np.abs(total).max() > 1e-6 * scale:
            key = "pressure" if loads.pressure else "traction"
            raise InputError(
                "the loads push the body along a motion that nothing holds: fix a part of the boundary, let "
                "one slide in its plane, or give robin > 0",
                f"mechanics.{key}.{next(iter(getattr(loads, key)))}",
            )


def check_cavities(
    cavities: Cavities | None,
    kinematics: Kinematics,
    loads: Loads,
    stretch: ImposedStretch | None,
) -> None:
    """Refuse cavities where there are none, or whose pressures are given twice.

    Raises:
        InputError: It names the key.
    """
    if cavities is None:
        return
    if kinematics.dim != 3:
        raise InputError("only a solid has cavities: leave the section out", "circulation")
    if stretch is not None:
        raise InputError(
            "an imposed stretch leaves a cavity no volume of its own; leave it out", "circulation"
        )
    for part in cavities.names:
        if part in loads.pressure:
            raise InputError(
                "the circulation finds this pressure; leave it out, or give it as [circulation] with "
                'kind = "pressure"',
                f"mechanics.pressure.{part}",
            )


def check_stretch(body: Body, kinematics: Kinematics, stretch: ImposedStretch, supports: Supports) -> float:
    """Refuse an imposed stretch that contradicts the constraint, or moves what supports hold.

    Returns:
        J of the held body.

    Raises:
        InputError: It does, with the numbers.
    """
    key = "mechanics.imposed_stretch"
    if isinstance(stretch.value, tuple) and len(stretch.value) != body.dim:
        raise InputError(f"{list(stretch.value)}: give one number, or {body.dim}", key)
    stretches = np.broadcast_to(np.asarray(stretch.value, dtype=float), (body.dim,))
    ratio = kinematics.held_volume_ratio(stretches.tolist())
    low, high = body.extent()
    if supports.displacement and not (np.isinf(stretch.until) and (stretches == 1).all()):
        raise InputError("a prescribed displacement contradicts it; give one of the two", key)
    held = [(part, tuple(range(body.dim))) for part in supports.fixed]
    held += [(part, (plane_axis(body, part) if body.dim > 1 else 0,)) for part in supports.sliding]
    for part, axes in held:
        points, _ = surface(body, [part])
        moved = np.abs((stretches - 1) * (points.reshape(-1, body.dim) - low)).max(axis=0, initial=0.0)
        most = np.array([body.comm.allreduce(float(value), op=MPI.MAX) for value in moved])
        axis = max(axes, key=lambda i: most[i])
        if most[axis] > FLAT * np.linalg.norm(high - low):
            raise InputError(
                f"the stretch of {stretches[axis]:g} from the lowest corner moves '{part}' by "
                f"{most[axis]:.4g} along {AXES[axis]}, where it is held; hold parts that stay in place (at "
                f"{AXES[axis]} = {low[axis]:g}), or give 1 along this axis",
                key,
            )
    return ratio


def check_fit(
    body: Body,
    kinematics: Kinematics,
    material: Material,
    relaxation_time: float,
    viscosity: float,
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
    if relaxation_time > 0 and viscosity > 0:
        raise InputError(
            "viscosity and relaxation_time say the same thing (η = 2 λ μ); give one of the two",
            "mechanics.viscosity",
        )
    if relaxation_time > 0 and not hasattr(material, "modulus"):
        raise InputError(
            f"viscosity is scaled by a material's modulus at rest, and {type(material).__name__} has no "
            "attribute 'modulus'; add one, or give 0",
            "mechanics.relaxation_time",
        )
