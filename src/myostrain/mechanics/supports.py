"""What holds a body: parts that are fixed, that slide in a plane, that are moved, or that are on springs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from myostrain.course import Course, FunctionOfTime
from myostrain.engine import fem
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.geometry.body import range_of
from myostrain.mechanics.functions import check_with_functions
from myostrain.mechanics.rigid_motions import surface
from myostrain.mechanics.support_factors import SupportProfile, checked_factors
from myostrain.validation import NonNegative

import numpy as np
import numpy.typing as npt

#: How far nodes of a plane part may be off their plane, of the body's diagonal: coordinates in single
#: precision are off by some 1e-7.
FLAT = 1e-6


AXES = "xyz"

Normals = Literal["smooth", "facets"]
"""Which normals supports along the normal take."""


@dataclass(frozen=True)
class Supports:
    """What holds a body: parts of its boundary that do not move, that are moved, or that are on springs.

    Stiffness and prescribed displacement may be functions of the time.

    Args:
        fixed: Named parts of the boundary where u = 0.
        sliding: Named parts, each in a plane across an axis, that slide in it.
        displacement: Prescribed displacement by named part and component, each a number or points
            (time, value): ``{"right": {"x": 0.3}}``. Components that are not named are free.
        robin: Stiffness k of the elastic support P N = −k u (7.8), zero or more; one, or by named part of
            the boundary.
        robin_boundary: Named parts of the boundary that a single ``robin`` acts on; all of it unless given.
        robin_normal: Stiffness of supports P N = −k (u·N) N, which let the body slide, by named part.
        damping: Coefficient c of dampers P N = −c v, v the velocity, by named part of the boundary.
        damping_normal: Coefficient of dampers P N = −c (v·N) N, by named part.
        normals: N of the supports along it: "smooth", of the surface that the facets stand for, or "facets",
            the facets' own, which hold a body that slides on a curved part wherever facets meet.
        support_factor: Factor on all springs and dampers of a part, by its name, where they vary within it: a
            :class:`SupportProfile`, or in a script a function that takes points X (n, dim) at rest and gives
            factors (n,), zero or more. It is linear between the nodes of the mesh.

    Raises:
        InputError: A value does not fit its type, or a factor is on a part without springs and dampers.
    """

    fixed: tuple[str, ...] = ()
    sliding: tuple[str, ...] = ()
    displacement: Mapping[str, Mapping[Literal["x", "y", "z"], Course]] = field(default_factory=dict)
    robin: NonNegative | Mapping[str, NonNegative] = 0.0
    robin_boundary: tuple[str, ...] | None = None
    robin_normal: Mapping[str, NonNegative] = field(default_factory=dict)
    damping: Mapping[str, NonNegative] = field(default_factory=dict)
    damping_normal: Mapping[str, NonNegative] = field(default_factory=dict)
    normals: Normals = "smooth"
    support_factor: Mapping[str, SupportProfile | Callable[[Any], Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the values."""
        factors = self.support_factor
        object.__setattr__(self, "support_factor", {})
        check_with_functions(self, {"displacement": None, "robin": 0.0, "robin_normal": 0.0})
        own = self.robin if isinstance(self.robin, Mapping) else {}
        parts = {*own, *self.robin_normal, *self.damping, *self.damping_normal}
        object.__setattr__(self, "support_factor", checked_factors(factors, parts))
        if self.robin_boundary is not None and isinstance(self.robin, Mapping):
            raise InputError("robin names its parts itself; leave this key out", "mechanics.robin_boundary")

    def springs(self) -> Iterator[tuple[Sequence[str] | None, float | FunctionOfTime, bool, str]]:
        """Parts (None for all), stiffness, whether along the normal only, and key of each elastic support.

        Raises:
            InputError: Parts are named that no spring is on.
        """
        if isinstance(self.robin, Mapping):
            for part, stiffness in self.robin.items():
                yield [part], stiffness, False, f"mechanics.robin.{part}"
        else:
            key = "robin" if self.robin_boundary is None else "robin_boundary"
            some = isinstance(self.robin, FunctionOfTime) or self.robin > 0
            if self.robin_boundary is not None and not (self.robin_boundary and some):
                raise InputError(
                    f"{list(self.robin_boundary)} has no effect: name parts and give robin > 0, or leave it "
                    "out",
                    "mechanics.robin_boundary",
                )
            yield self.robin_boundary, self.robin, False, f"mechanics.{key}"
        for part, stiffness in self.robin_normal.items():
            yield [part], stiffness, True, f"mechanics.robin_normal.{part}"

    def dampers(self) -> Iterator[tuple[str, float, bool, str]]:
        """Part, coefficient, whether along the normal only, and key of each damper that resists."""
        for name, coefficients in (("damping", self.damping), ("damping_normal", self.damping_normal)):
            for part, coefficient in coefficients.items():
                if coefficient > 0:
                    yield part, coefficient, name == "damping_normal", f"mechanics.{name}.{part}"


@dataclass(frozen=True)
class Hold:
    """One component of the displacement, held on a part of the boundary.

    Args:
        part: Name of the part.
        axis: The component.
        dofs: Local numbers of its degrees of freedom in the unknown.
        condition: The condition on them.
        value: What the component is there.
        course: The value over time; None for zero for ever.
    """

    part: str
    axis: int
    dofs: npt.NDArray[np.int32]
    condition: fem.DirichletBC
    value: fem.Constant
    course: Course | None = None


def holds(body: Body, space: fem.FunctionSpace, supports: Supports, mixed: bool) -> list[Hold]:
    """The components that are fixed, that slide and that are prescribed, in this order.

    Args:
        body: The reference body.
        space: Displacement space, or the mixed space whose first part it is.
        supports: What holds the body.
        mixed: Whether ``space`` is mixed.

    Raises:
        InputError: A part or component is not there, a sliding one is in no plane, or nodes that are held are
            prescribed too.
    """
    made = []

    def hold(part: str, axis: int, key: str, course: Course | None = None) -> None:
        facets = body.boundary_facets([part], key)
        parent = space.sub(0) if mixed else space
        component = parent if body.dim == 1 else parent.sub(axis)
        dofs = fem.locate_dofs_topological(component, body.dim - 1, facets)
        value = fem.Constant(body.mesh, 0.0)
        made.append(Hold(part, axis, dofs, fem.dirichletbc(value, dofs, component), value, course))

    for part in supports.fixed:
        for axis in range(body.dim):
            hold(part, axis, "mechanics.fixed")
    for part in supports.sliding:
        body.boundary_facets([part], "mechanics.sliding")
        hold(part, plane_axis(body, part) if body.dim > 1 else 0, "mechanics.sliding")
    for part, components in supports.displacement.items():
        key = f"mechanics.displacement.{part}"
        for name, course in components.items():
            if name not in AXES[: body.dim]:
                raise InputError(
                    f"this body has the components {', '.join(AXES[: body.dim])}", f"{key}.{name}"
                )
            earlier = list(made)
            hold(part, AXES.index(name), key, course)
            for other in earlier:
                common = len(np.intersect1d(other.dofs, made[-1].dofs))
                if body.comm.allreduce(common):
                    raise InputError(
                        f"nodes of '{part}' are held along {name} by '{other.part}' already; prescribe a "
                        "part that has none in common with it, or another component",
                        f"{key}.{name}",
                    )
    return made


def plane_axis(body: Body, name: str) -> int:
    """The axis across which the named part of the boundary lies in a plane.

    Raises:
        InputError: There is none.
    """
    points, _ = surface(body, [name])
    low, high = body.extent()
    least, most = range_of(points.reshape(-1, body.dim), body.comm)
    spread, size = most - least, float(np.linalg.norm(high - low))
    flat = np.flatnonzero(spread <= FLAT * size)
    if len(flat) != 1:
        raise InputError(
            f"'{name}' is in no plane across {', '.join('XYZ'[: body.dim])}, in which it could slide (it "
            f"extends over {', '.join(f'{s:.3g}' for s in spread)} along these axes; a plane may deviate by "
            f"{FLAT:g} of the body's diagonal, {FLAT * size:.3g}); fix it, or give it a stiffness along its "
            "normal in mechanics.robin_normal",
            "mechanics.sliding",
        )
    return int(flat[0])
