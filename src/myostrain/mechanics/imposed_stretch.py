"""A stretch that holds the body, the experiment of figure 2."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.validation import Positive, description

import numpy as np
import numpy.typing as npt
from pydantic import Field

Array = npt.NDArray[np.float64]


@description
class ImposedStretch:
    """A homogeneous stretch that holds the body for an initial time, the experiment of figure 2.

    Args:
        value: The stretch, one number or one for each direction; 1 holds the reference configuration.
        until: The simulated time at which the body is let go; ``inf`` holds it for ever (a rigid body).
    """

    value: Positive | tuple[Positive, ...] = 1.0
    until: Annotated[float, Field(strict=True)] = float("inf")

    def __post_init__(self) -> None:
        """Refuse an ``until`` that is not a time."""
        if not self.until > 0:
            raise InputError(
                f"{self.until} is not a time after the start; give a positive number or inf",
                "mechanics.imposed_stretch.until",
            )

    def holds(self, time: float) -> bool:
        """Whether it holds the body at a time."""
        return bool(np.isinf(self.until)) or time < self.until * (1 - 1e-9)

    def displacement(self, body: Body) -> Callable[[Array], Array]:
        """The displacement (dim, points) of points (3, points) of a body, from its lowest corner."""
        low, _ = body.extent()
        stretch = np.broadcast_to(np.asarray(self.value, dtype=float), (body.dim,))
        return lambda x: (stretch[:, None] - 1) * (x[: body.dim] - low[:, None])
