"""The fields that a run can write, by name: values at the potential's nodes, from the present state."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import combinations_with_replacement
from typing import Any, Literal, get_args

from myostrain.coupling import Electromechanics
from myostrain.engine import compile_form
from myostrain.errors import InputError, nearest, shown
from myostrain.mechanics.motion import velocity_of
from myostrain.solvers.linear import assemble_nodal

import numpy as np
import numpy.typing as npt
import ufl

Array = npt.NDArray[np.float64]

FieldName = Literal[
    "potential",
    "states",
    "calcium",
    "activation_times",
    "activation",
    "gamma",
    "tension",
    "displacement",
    "velocity",
    "J",
    "F",
    "E",
    "stretch",
    "fibre_stretch",
    "stress",
    "cauchy_stress",
    "stress_trace",
    "pressure",
]

NAMES = get_args(FieldName)

#: Numbers at a node of a solid, by name; those of "states" are the membrane's.
WIDTHS = dict.fromkeys(NAMES, 1) | {"displacement": 3, "velocity": 3, "F": 9, "E": 6}
WIDTHS |= {"stress": 6, "cauchy_stress": 6}

#: Degree of the quadrature for an expression on the mesh of the potential.
DEGREE = 4

#: Arrays by name, when they are asked for.
Source = tuple[Sequence[str], Callable[[], Sequence[Array]]]


class NodalValues:
    """Values of chosen fields at the potential's nodes.

    Stress and the stretch of the fibre are fitted in the cells around each node; other fields of the
    mechanics are means over these cells, ∫ f φ dX / ∫ φ dX. Of a tensor each component is a field:
    ``E_xx``, ``E_xy``, ...

    Args:
        model: The coupled problem.
        names: Which fields.
        expressions: UFL expressions by name, on the mesh of the potential or of the mechanics.
        activation_times: Gives the first activation time of each local node, NaN for none yet.

    Raises:
        InputError: The model has no such field, or an expression cannot be one.
    """

    def __init__(
        self,
        model: Electromechanics,
        names: Sequence[FieldName],
        expressions: Mapping[str, Any] | None = None,
        activation_times: Callable[[], Array] | None = None,
    ) -> None:
        self._model, self._times = model, activation_times
        self._sources = [source for name in dict.fromkeys(names) for source in self._of(name)]
        taken = {*NAMES, *self.names}
        for name, expression in (expressions or {}).items():
            if not name.isidentifier() or name in taken:
                raise InputError(
                    f"{shown(name)} cannot be the name of an expression: give a word of letters, digits and "
                    "_ that no other field has",
                    "expressions",
                )
            self._sources.append(self._expression(name, expression))

    @property
    def names(self) -> list[str]:
        """Names of the arrays."""
        return [name for names, _ in self._sources for name in names]

    def values(self) -> dict[str, Array]:
        """The present values by name, owned and ghosts: (nodes,), or flat (nodes × dim) of vectors."""
        return {
            name: values
            for names, arrays in self._sources
            for name, values in zip(names, arrays(), strict=True)
        }

    def _of(self, name: FieldName) -> list[Source]:
        """Where a field comes from; nowhere, if it is one of those that only some models have."""
        model = self._model
        potential, mechanics = model.potential, model.mechanics
        if name == "potential":
            return [((name,), lambda: [potential.v.x.array])]
        if name == "states":
            states = [each for each in potential.field_values() if each != "potential"]
            return [(states, lambda: [potential.field_values()[each] for each in states])] if states else []
        if name == "calcium":
            state = getattr(getattr(potential, "membrane", None), "calcium", None)
            if state is None:
                raise _missing(name, "its membrane has none")
            return [((name,), lambda: [potential.field_values()[state]])]
        if name == "activation_times":
            times = self._times
            return [] if times is None else [((name,), lambda: [times()])]
        activation = model.activation
        if name in ("activation", "gamma", "tension"):
            if activation is None:
                return []
            if name != "activation" and (name == "gamma") != (activation.yields == "strain"):
                raise _missing(name, "its law yields a " + ("tension" if name == "gamma" else "strain, γ"))
            return [((name,), lambda: [activation.values])]
        return [] if mechanics is None else [self._of_body(name, mechanics)]

    def _of_body(self, name: FieldName, mechanics: Any) -> Source:
        transfer, nodal = self._model.transfer, mechanics.nodal

        def scalar(values: Callable[[], Array]) -> Source:
            return (name,), lambda: [transfer.to_potential(values())]

        def tensor(expression: Any, pairs: Sequence[tuple[int, int]]) -> Source:
            whole = {
                (i, j): partial(nodal.scalar, f"{name} {i} {j}", expression[i, j])
                for i, j in pairs
                if dim == n or (i < dim) == (j < dim)  # nothing shears across a sheet
            }
            names = [f"{name}_{'xyz'[i]}{'xyz'[j]}" for i, j in whole]
            return names, lambda: [transfer.to_potential(mean()) for mean in whole.values()]

        def stress() -> list[Array]:
            sigma = transfer.to_potential(mechanics.stress())
            return [sigma[:, i, j] for i, j in symmetric]

        dim, n = mechanics.kinematics.dim, mechanics.kinematics.tensor_dim
        symmetric = list(combinations_with_replacement(range(n), 2))
        if name == "displacement":
            return (name,), lambda: [transfer.displacement().x.array.copy()]
        if name == "velocity":
            velocity = partial(velocity_of, mechanics.motion, mechanics.history, mechanics.u)
            return (name,), lambda: [transfer.displacement(velocity()).x.array.copy()]
        if name in ("stretch", "fibre_stretch"):
            return scalar(mechanics.fibre_stretch)
        if name in ("stress", "cauchy_stress"):
            return [f"{name}_{'xyz'[i]}{'xyz'[j]}" for i, j in symmetric], stress
        if name == "stress_trace":
            return scalar(mechanics.stress_trace)
        if name == "pressure":
            if n == 1:
                raise _missing(name, "a line has no constraint")
            return scalar(partial(nodal.scalar, name, nodal.pressure))
        F = nodal.F
        if name == "J":
            return scalar(partial(nodal.scalar, name, ufl.det(F)))
        if name == "F":
            return tensor(F, [(i, j) for i in range(n) for j in range(n)])
        return tensor((F.T * F - ufl.Identity(n)) / 2, symmetric)

    def _expression(self, name: str, expression: Any) -> Source:
        """Means of a UFL expression at the nodes."""
        model = self._model
        try:
            expression = ufl.as_ufl(expression)
            mesh = ufl.domain.extract_unique_domain(expression)
        except (TypeError, ValueError, AttributeError) as error:
            raise _not_ufl(name, f"{type(expression).__name__}: {error}") from error
        shape = expression.ufl_shape
        if len(shape) > 2 or any(not 0 < size <= 3 for size in shape):
            raise _not_ufl(name, f"its shape is {shape}; give a scalar, a vector or a matrix")
        transferred, mechanics = False, model.mechanics
        own = model.potential.v.function_space
        if mechanics is not None and mesh is not None and mesh != own.mesh.ufl_domain():
            if mesh != mechanics.body.mesh.ufl_domain():
                raise _not_ufl(name, "it lives on another mesh than the body")
            transferred = True
        if ufl.algorithms.extract_arguments(expression):
            raise _not_ufl(name, "it has a test or trial function")
        space = mechanics.activation.function_space if transferred and mechanics is not None else own
        dx = ufl.dx(space.mesh, metadata={"quadrature_degree": DEGREE})
        if mechanics is not None and space.mesh is mechanics.body.mesh:
            dx = mechanics.dx
        test = ufl.TestFunction(space)
        indices = list(np.ndindex(*shape))
        weight = assemble_nodal(compile_form(test * dx))
        forms = [compile_form((expression[i] if i else expression) * test * dx) for i in indices]

        def values() -> list[Array]:
            found = [assemble_nodal(form) / weight for form in forms]
            return [model.transfer.to_potential(each) for each in found] if transferred else found

        return [name + ("_" + "".join("xyz"[k] for k in i) if i else "") for i in indices], values


def check_fields(names: Sequence[str]) -> None:
    """Refuse names that no field has.

    Raises:
        InputError: One is not known.
    """
    for name in names:
        if name not in NAMES:
            raise InputError(f"no such field: {shown(name)}; {nearest(name, NAMES)}", "output.fields")


def _missing(name: str, why: str) -> InputError:
    return InputError(f"this model has no field '{name}': {why}; leave it out", "output.fields")


def _not_ufl(name: str, why: str) -> InputError:
    return InputError(
        f"cannot be written as a field ({why}); give a UFL expression of the model's fields, such as "
        "mechanics.deformation.J * potential.v",
        f"expressions.{name}",
    )
