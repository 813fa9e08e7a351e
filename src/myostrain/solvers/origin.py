"""What a kept tangent was made of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from myostrain.engine import fem
from myostrain.state import FieldState

import numpy as np


class Origin:
    """The values that functions and constants had when the tangent that depends on them was assembled.

    Args:
        arguments: The functions and constants.
    """

    def __init__(self, arguments: Sequence[Any]) -> None:
        self._arguments = list(arguments)
        self._values: list[Any] = []

    def take(self) -> None:
        """Remember the present values."""
        self._values = self._present()

    def state(self) -> list[Any]:
        """The values."""
        return [
            FieldState(argument.function_space, value) if isinstance(argument, fem.Function) else float(value)
            for argument, value in zip(self._arguments, self._values, strict=False)
        ]

    def is_that_of(self, saved: Sequence[Any]) -> bool:
        """Whether these are the values of a state, on this process."""
        values = _of(saved)
        return len(values) == len(self._values) and all(
            old is new or np.array_equal(old, new) for old, new in zip(self._values, values, strict=True)
        )

    def fits(self, saved: Sequence[Any]) -> bool:
        """Whether the tangent of a state depends on as many functions and constants: loads may be others."""
        return len(saved) == len(self._arguments)

    @contextmanager
    def put(self, saved: Sequence[Any]) -> Iterator[None]:
        """Give functions and constants the values of a state for a while."""
        present = self._present()
        self._write(_of(saved))
        try:
            yield
        finally:
            self._write(present)

    def _present(self) -> list[Any]:
        return [
            argument.x.array.copy() if isinstance(argument, fem.Function) else float(argument.value)
            for argument in self._arguments
        ]

    def _write(self, values: Sequence[Any]) -> None:
        for argument, value in zip(self._arguments, values, strict=True):
            if isinstance(argument, fem.Function):
                argument.x.array[:] = value
            else:
                argument.value = value


def _of(saved: Sequence[Any]) -> list[Any]:
    return [entry.values if isinstance(entry, FieldState) else entry for entry in saved]
