"""A current that the stretch of the tissue opens."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from myostrain.electrics.place import Place
from myostrain.engine import compile_form, fem
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.kinematics import Deformation
from myostrain.solvers.linear import assemble_nodal
from myostrain.validation import Finite, Positive, description

import numpy as np
import numpy.typing as npt
import ufl
from pydantic import PlainValidator

Array = npt.NDArray[np.float64]

Measure = Literal["fibre", "area", "line"]

#: Stretches up to here are what iterating the equilibrium leaves; they open nothing.
NOISE = 1e-6

KEY = "cell.stretch_current"


def _conductance(value: Any) -> float | Array:
    """A number, or nodal values of a script."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.floating, np.ndarray)):
        raise ValueError("give a number")
    found = np.asarray(value, dtype=float)
    if found.ndim > 1 or not (np.isfinite(found) & (found >= 0)).all():
        raise ValueError("this should be finite and zero or more")
    return found if found.ndim else float(found)


@description
class StretchCurrent:
    """I = g (√C − 1)₊/span (v − E), a rate of v in addition to the membrane's, where the body is stretched.

    √C is the stretch of a line, the root of det C of a sheet (its area), or the fibre's; where it is below 1
    there is no current. It drives v to E: with E at rest it excites nothing. A. V. Panfilov,
    R. H. Keldermann, M. P. Nash, Phys. Rev. Lett. 95 (2005) 258104, doi 10.1103/PhysRevLett.95.258104, have
    it with E = 1 for a potential between 0 and 1; for a membrane in mV it is usual with E = −10 mV, open at a
    stretch of 1.15.

    Args:
        conductance: g where √C − 1 is the span, a rate: per unit of time of the membrane. A script may give
            nodal values (nodes,).
        reversal: E, in the membrane's unit; unless given 1, or −10 for a membrane in mV.
        measure: What stretches: "fibre", |F f0|; "area" of a sheet, √det C; "line". Unless given "line" on a
            line, "area" on a sheet and "fibre" in a solid.
        span: The √C − 1 at which the current has its full conductance; it grows linearly, also beyond. Unless
            given 1, or 0.15 for a membrane in mV.
        where: Where it is; everywhere unless given. Several currents add up.
    """

    conductance: Annotated[float, PlainValidator(_conductance)]
    reversal: Finite | None = None
    measure: Measure | None = None
    span: Positive | None = None
    where: Place | None = None

    def fitting(self, membrane: Any, dim: int | None) -> StretchCurrent:
        """The same with what is not given as this membrane and a body of this dimension need it.

        Raises:
            InputError: The body has no such measure.
        """
        allowed = {1: ("line", "fibre"), 2: ("area", "fibre"), 3: ("fibre",)}[dim or 3]
        if self.measure not in (None, *allowed):
            raise InputError(
                f"'{self.measure}' is none of a body of {dim} dimensions; allowed: {', '.join(allowed)}",
                f"{KEY}.measure",
            )
        millivolts = getattr(membrane, "potential_unit", None) == "mV"
        usual: dict[str, Any] = {"measure": allowed[0], "reversal": 1.0, "span": 1.0}
        if millivolts:
            usual |= {"reversal": -10.0, "span": 0.15}
        return dataclasses.replace(self, **{k: v for k, v in usual.items() if getattr(self, k) is None})


class StretchCurrents:
    """The currents at the nodes of the potential, for the body that it sees.

    At a node √C is the mean over the cells around it, weighted by the node's basis function.

    Args:
        currents: The currents.
        body: The potential's body.
        space: P1 space of the potential.
        deformation: F of the body that the potential sees; None for a rigid one.
        membrane: The membrane.

    Raises:
        InputError: The body is rigid or has no such measure, or a place or nodal values do not fit.

    Attributes:
        slope: Derivative of the current in v (nodes,).
        offset: What the current is short of slope · v (nodes,).
    """

    def __init__(
        self,
        currents: Sequence[StretchCurrent],
        body: Body,
        space: fem.FunctionSpace,
        deformation: Deformation | None,
        membrane: Any,
    ) -> None:
        self._size = len(fem.Function(space).x.array)
        self.slope: Array = np.zeros(self._size)
        self.offset: Array = np.zeros(self._size)
        if currents and deformation is None:
            raise InputError("a rigid body is not stretched: leave it out", KEY)
        self._currents = [current.fitting(membrane, body.dim) for current in currents]
        self._conductances = [self._at_nodes(current, body, space) for current in self._currents]
        self._forms: dict[str, Any] = {}
        if deformation is None or not currents:
            return
        test = ufl.TestFunction(space)
        dx = ufl.dx(metadata={"quadrature_degree": 2})
        self._weight = assemble_nodal(compile_form(test * dx))
        for measure in {str(current.measure) for current in self._currents}:
            stretch = _stretch(measure, deformation.F, body.f0)
            self._forms[measure] = compile_form(stretch * test * dx)

    def _at_nodes(self, current: StretchCurrent, body: Body, space: fem.FunctionSpace) -> Array:
        """g/span (nodes,)."""
        given = np.asarray(current.conductance)
        if given.shape not in ((), (self._size,)):
            raise InputError(
                f"conductance has the shape {given.shape}; give a number or ({self._size},), one a node", KEY
            )
        share = 1.0 if current.where is None else current.where.share(body, space, KEY)
        assert current.span is not None
        return np.broadcast_to(given * share / current.span, (self._size,))

    def added(self, v: Array, current: Array, slope: Array) -> tuple[Array, Array]:
        """The membrane's current and its derivative at v, with these beside it, (nodes,) each."""
        if not self._currents:
            return current, slope
        return current + self.slope * v - self.offset, slope + self.slope

    def update(self) -> None:
        """Take the stretch of the body that the potential sees now."""
        if not self._currents:
            return
        stretches = {name: assemble_nodal(form) / self._weight for name, form in self._forms.items()}
        self.slope, self.offset = np.zeros(self._size), np.zeros(self._size)
        for current, conductance in zip(self._currents, self._conductances, strict=True):
            reversal = float(current.reversal or 0.0)  # given: see fitting
            beyond = stretches[str(current.measure)] - 1
            opened = conductance * np.where(beyond > NOISE, beyond, 0.0)
            self.slope += opened
            self.offset += opened * reversal


def _stretch(measure: str, F: Any, f0: Any) -> Any:
    """√C, UFL."""
    if measure == "fibre":
        along = F * f0
        return ufl.sqrt(ufl.dot(along, along))
    return ufl.det(F)  # positive; on a line F itself
