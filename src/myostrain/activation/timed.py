"""Active strain that is given over time."""

import math
from typing import Annotated, Any, ClassVar

from myostrain.activation.contracts import Yield
from myostrain.course import Course, value_at
from myostrain.validation import Finite, Positive, description

from pydantic import Field


@description
class Timed:
    """γ(t) = γ_min sin²(π (t − start)/(end − start)) from start to end, zero elsewhere; or a table.

    For bodies whose potential is of no interest: γ is the same everywhere, but for ``activation.transmural``.
    The form with γ_min = −0.13 from 170 to 480 ms of a cycle of 1000 ms has been used for ventricles.

    Args:
        gamma_min: γ half way between start and end, −1 < γ_min; negative contracts.
        start: When the contraction begins, in the case's unit of time.
        end: When it is over, later than start.
        table: Points (time, γ) joined by straight lines, in place of the three above.
        period: Time after which the contraction repeats; it happens once unless given.
    """

    gamma_min: Annotated[float, Field(gt=-1, allow_inf_nan=False, strict=True)] | None = None
    start: Finite | None = None
    end: Finite | None = None
    table: Course | None = None
    period: Positive | None = None
    drivers: ClassVar[tuple[str, ...]] = ("time",)
    yields: ClassVar[Yield] = "strain"

    def __post_init__(self) -> None:
        """Refuse two courses, none, or one that does not fit into its period."""
        form = (self.gamma_min, self.start, self.end)
        if self.table is not None:
            if any(value is not None for value in form):
                raise ValueError("a table takes the place of gamma_min, start and end: give one of both")
            points = self.table if isinstance(self.table, tuple) else ((0.0, self.table),)
            if not all(value > -1 for _, value in points):
                raise ValueError("γ in the table should be greater than -1")
            first, last = points[0], points[-1]
        else:
            if any(value is None for value in form):
                raise ValueError("give gamma_min, start and end, or a table [[time, γ], ...]")
            if not self.start < self.end:  # type: ignore[operator]
                raise ValueError(f"end = {self.end} should be later than start = {self.start}")
            first, last = (self.start, 0.0), (self.end, 0.0)  # type: ignore[assignment]
        if self.period is not None:
            if first[0] < 0 or last[0] > self.period:
                raise ValueError(f"times should be from 0 to the period {self.period}")
            if first[1] != last[1]:
                raise ValueError("with a period γ should end as it begins, or it jumps")

    def activation(self, states: Any, drivers: Any) -> Any:
        """γ at the time, a number for all nodes."""
        time = float(drivers["time"])
        if self.period is not None:
            time %= self.period
        if self.table is not None:
            return value_at(self.table, time)
        assert self.gamma_min is not None
        assert self.start is not None
        assert self.end is not None
        if not self.start < time < self.end:
            return 0.0
        return self.gamma_min * math.sin(math.pi * (time - self.start) / (self.end - self.start)) ** 2
