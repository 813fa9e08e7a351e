"""A pointwise formula that runs: compiled where there is a compiler, else by NumPy."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

from myostrain.engine import MPI
from myostrain.pointwise.c_source import c_source
from myostrain.pointwise.compiler import library
from myostrain.pointwise.expressions import Expression
from myostrain.pointwise.operations import COMPUTE

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Nodes at a time without a compiler: what all formulas need in between then stays small.
CHUNK = 4096

_POINTER = ctypes.POINTER(ctypes.c_double)


class Program:
    """Computes outputs of a graph at many nodes.

    Args:
        inputs: What is given at the nodes.
        scalars: What is given as numbers.
        outputs: What is computed. Truth values among them are conditions that must hold at every node.
        comm: Processes that make it together: the first one compiles (collective).

    Attributes:
        compiled: Whether it runs as C.
    """

    def __init__(
        self,
        inputs: Sequence[Expression],
        scalars: Sequence[Expression],
        outputs: Sequence[Expression],
        comm: Any = MPI.COMM_SELF,
    ) -> None:
        self._inputs, self._scalars, self._outputs = list(inputs), list(scalars), list(outputs)
        self._stored = [o for o in outputs if not o.logical]
        found = library(c_source(inputs, scalars, outputs), comm)
        self.compiled = found is not None
        if found is not None:
            self._evaluate = found.evaluate
            self._evaluate.restype = ctypes.c_long
        else:
            self._nodes = outputs[0].graph.needed(outputs)

    def __call__(self, inputs: Sequence[Array], numbers: Sequence[float], outputs: Sequence[Array]) -> int:
        """Compute.

        Args:
            inputs: Nodal values (n,) each, in the order of the inputs; contiguous.
            numbers: The scalars, in their order.
            outputs: Where the outputs but for the conditions go, (n,) each, contiguous; they may be inputs.

        Returns:
            The first node where a condition does not hold, -1 if they hold everywhere.
        """
        n = len(outputs[0])
        counts = (len(inputs), len(numbers), len(outputs))
        if counts != (asked := (len(self._inputs), len(self._scalars), len(self._stored))):
            # Compiled code would read or write elsewhere.
            raise ValueError(f"inputs, numbers and outputs must be {asked}, not {counts}")
        if not self.compiled:
            return self._interpret(n, inputs, numbers, outputs)
        given = (_POINTER * max(len(inputs), 1))(*(_pointer(a, n) for a in inputs))
        found = (_POINTER * max(len(outputs), 1))(*(_pointer(a, n) for a in outputs))
        values = (ctypes.c_double * max(len(numbers), 1))(*numbers)
        return int(self._evaluate(ctypes.c_long(n), given, values, found))

    def _interpret(
        self, n: int, inputs: Sequence[Array], numbers: Sequence[float], outputs: Sequence[Array]
    ) -> int:
        places = {e.index: i for i, e in enumerate(self._inputs)}
        fixed: dict[int, Any] = {e.index: np.float64(x) for e, x in zip(self._scalars, numbers, strict=True)}
        first = -1
        for begin in range(0, n, CHUNK):
            part = slice(begin, min(begin + CHUNK, n))
            values = dict(fixed)
            with np.errstate(all="ignore"):
                for node in self._nodes:
                    if node.op == "input":
                        values[node.index] = inputs[places[node.index]][part]
                    elif node.op == "const":
                        values[node.index] = node.value
                    elif node.op != "scalar":
                        values[node.index] = COMPUTE[node.op](*(values[a.index] for a in node.args))
            good: Any = True
            for output in self._outputs:
                if output.logical:
                    good = good & values[output.index]
            wrong = np.flatnonzero(~np.broadcast_to(good, part.stop - begin))
            if first < 0 and len(wrong):
                first = begin + int(wrong[0])
            for array, output in zip(outputs, self._stored, strict=True):
                array[part] = values[output.index]
        return first


def _pointer(array: Array, n: int) -> Any:
    if array.dtype != np.float64 or array.shape != (n,) or not array.flags.c_contiguous:
        raise ValueError(f"an array of {n} contiguous doubles is needed, not {array.dtype} {array.shape}")
    return array.ctypes.data_as(_POINTER)
