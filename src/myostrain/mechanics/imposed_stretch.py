"""A stretch that holds the body, the experiment of figure 2."""

from __future__ import annotations

from typing import Annotated

from myostrain.errors import InputError
from myostrain.validation import Positive, description

from pydantic import Field


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
        """Refuse an ``until`` that is no time."""
        if not self.until > 0:
            raise InputError(
                f"{self.until} is no time after the start; give a positive number or inf",
                "mechanics.imposed_stretch.until",
            )
