"""Parameters of the membrane that differ between parts of the body."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.electrics.place import Array, Place
from myostrain.engine import MPI, lasting
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.membranes.variants import attribute, changes, differing, variant
from myostrain.validation import description

import numpy as np

KEY = "cell.variation"


@description
class Variation:
    """Other parameters of the membrane in a place; where several overlap, the later ones win.

    A node is in the place or out of it; its rest is that of its own parameters.

    Args:
        where: The place.
        set: Published set of parameters of the model, which takes the place of the parameters in it.
        parameters: Values of parameters by their names, which win over the set. In a script also arrays with
            a value for each node of the potential (nodes,) on this process.
    """

    where: Place
    set: str | None = None
    parameters: Mapping[str, Any] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what varies nothing, and means over what is in or out."""
        if self.set is None and not self.parameters:
            raise ValueError('give parameters of the membrane, or set = "..."')
        if self.where.sampling != "nodal":
            raise ValueError("a node has one set of parameters: leave sampling out")

    def check(self, membrane: Any, key: str, also: Sequence[str] = ()) -> Any:
        """The membrane as it is in the place, without the arrays.

        Args:
            membrane: The membrane of the body.
            key: What goes before the names in messages.
            also: Other names that are known where the parameters are given.

        Raises:
            InputError: A parameter or set that the membrane does not have, or does not take.
        """
        found = changes(membrane, self.set, self.parameters, key, also)
        return variant(membrane, {n: x for n, x in found.items() if not isinstance(x, np.ndarray)}, key)


class LocalMembranes:
    """The membrane of each node: one for each combination of variations that meet somewhere.

    Args:
        body: The body.
        space: The potential's P1 space.
        membrane: The membrane where nothing is said.
        variations: What is said, later ones win.

    Raises:
        InputError: A place without a node, parameters that the membrane does not have or take, an array of
            another length, or one on which the rest of the cell depends.

    Attributes:
        values: Nodal values (nodes,) of the attributes of the membrane that vary, by name.
    """

    def __init__(self, body: Body, space: Any, membrane: Any, variations: Sequence[Variation]) -> None:
        self._membrane, self.values = membrane, dict[str, Array]()
        self._members: list[tuple[Any, Any]] = []
        if not variations:
            return
        comm, keys = lasting(body.comm), [f"{KEY}.{n}" for n in range(1, len(variations) + 1)]
        said = [changes(membrane, v.set, v.parameters, key) for v, key in zip(variations, keys, strict=True)]
        inside = [v.where.share(body, space, key) > 0.5 for v, key in zip(variations, keys, strict=True)]
        nodes = len(inside[0])
        ends = [
            {name: _ends(x, nodes, comm, f"{key}.{name}") for name, x in changed.items()}
            for changed, key in zip(said, keys, strict=True)
        ]
        # Which variations hold at a node: each combination that is anywhere is a membrane of its own.
        present, which = np.unique(inside, axis=1, return_inverse=True)
        mine = [tuple(map(bool, c)) for c in present.T]
        found: list[tuple[Any, dict[str, Array], Any]] = []
        for combination in sorted(set().union(*comm.allgather(mine))):
            made, arrays = self._combined(
                [n for n, there in enumerate(combination) if there], said, ends, keys
            )
            number = mine.index(combination) if combination in mine else -1
            found.append((made, arrays, which.reshape(-1) == number))
        names = {*differing(membrane, [made for made, _, _ in found]), *(n for _, a, _ in found for n in a)}
        self.values = {name: np.full(nodes, float(getattr(membrane, name))) for name in sorted(names)}
        for made, arrays, here in found:
            for name, values in self.values.items():
                values[here] = arrays[name][here] if name in arrays else float(getattr(made, name))
            self._members.append((made, here))

    def _combined(
        self,
        numbers: Sequence[int],
        said: Sequence[Mapping[str, Any]],
        ends: Sequence[Mapping[str, tuple[Any, Any]]],
        keys: Sequence[str],
    ) -> tuple[Any, dict[str, Array]]:
        """The membrane where some variations hold, with the lowest values of arrays; and the arrays."""
        low, high, arrays = dict[str, Any](), dict[str, Any](), dict[str, Array]()
        for number in numbers:
            low |= {name: a for name, (a, _) in ends[number].items()}
            high |= {name: b for name, (_, b) in ends[number].items()}
            arrays = {name: x for name, x in arrays.items() if name not in said[number]}
            arrays |= {name: x for name, x in said[number].items() if isinstance(x, np.ndarray)}
        if not numbers:
            return self._membrane, {}
        key = keys[numbers[-1]]
        made = variant(self._membrane, low, key)
        if arrays and not _same_rest(made, variant(self._membrane, high, key)):
            raise InputError(
                f"the rest of the cell depends on one of {', '.join(arrays)}, and is found for numbers "
                "only: give numbers in places",
                key,
            )
        return made, {attribute(self._membrane, name): x for name, x in arrays.items()}

    def put_rest(self, v: Array, states: Array) -> None:
        """Set v (nodes,) and the states (states, nodes) to the rest of each node's membrane."""
        for membrane, here in self._members or [(self._membrane, slice(None))]:
            v[here] = membrane.resting_potential()
            if len(states):
                states[:, here] = np.asarray(membrane.resting_states(), dtype=float)[:, None]

    def rest(self, nodes: int) -> float | Array:
        """The potential at rest: a number where it is the same everywhere, otherwise (nodes,)."""
        found = [float(m.resting_potential()) for m, _ in self._members or [(self._membrane, None)]]
        if len(set(found)) == 1:
            return found[0]
        v = np.empty(nodes)
        self.put_rest(v, np.empty((0, nodes)))
        return v


def _ends(value: Any, nodes: int, comm: Any, key: str) -> tuple[Any, Any]:
    """Lowest and highest value of an array over all processes; a number twice (collective for arrays).

    Raises:
        InputError: The array has not one finite number for each node.
    """
    if not isinstance(value, np.ndarray):
        return value, value
    wrong = value.shape != (nodes,) or value.dtype.kind not in "fiub" or not np.isfinite(value).all()
    if comm.allreduce(wrong, MPI.LOR):
        raise InputError(
            f"give a number, or an array of {nodes} finite ones, one for each node of the potential on this "
            f"process, not {value.dtype} of shape {value.shape}",
            key,
        )
    low, high = value.min(initial=np.inf), value.max(initial=-np.inf)
    return float(comm.allreduce(float(low), MPI.MIN)), float(comm.allreduce(float(high), MPI.MAX))


def _same_rest(one: Any, other: Any) -> bool:
    """Whether two membranes rest alike, but for round-off."""
    first, second = (
        [m.resting_potential(), *(m.resting_states() if getattr(m, "states", ()) else ())]
        for m in (one, other)
    )
    return bool(np.allclose(first, second, rtol=1e-9, atol=1e-12))
