"""What the mesh of the mechanics and that of the potential hand each other."""

from __future__ import annotations

from typing import Any, Protocol

from myostrain.kinematics import Deformation

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Transfer(Protocol):
    """What the coupling asks of a pair of meshes.

    Attributes:
        deformation: The deformation as the potential sees it, UFL on the potential's mesh.
    """

    deformation: Deformation

    def to_mechanics(self, values: Array) -> Array:
        """Values at the mechanics' nodes, of values (nodes,) at those of the potential."""
        ...

    def to_potential(self, values: Array) -> Array:
        """Values at the potential's nodes, of values (nodes,) at those of the mechanics."""
        ...

    def hand_over(self) -> None:
        """Make ``deformation`` that of the displacement which the mechanics hands over now."""
        ...


class SameMesh:
    """Potential and mechanics share their mesh: nothing is to be done.

    Args:
        mechanics: The deforming body.
    """

    def __init__(self, mechanics: Any) -> None:
        self.deformation: Deformation = mechanics.deformation

    def to_mechanics(self, values: Array) -> Array:
        """The values themselves."""
        return values

    def to_potential(self, values: Array) -> Array:
        """The values themselves."""
        return values

    def hand_over(self) -> None:
        """Nothing: the deformation is the mechanics' own."""
