"""Aliev–Panfilov membrane."""

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

from myostrain.validation import NonNegative, Positive, description

from pydantic import Field


@description
class AlievPanfilov1996:
    """Aliev and Panfilov 1996: two variables with a restitution of the pulse's duration; non-dimensional.

    The current is k v (v − a)(v − 1) + v r; the recovery r has
    dr/dt = (ε0 + μ1 r/(v + μ2))(−r − k v (v − a − 1)). One unit of time is about 12.9 ms, and the potential
    about 100 v − 80 mV. As implemented in public codes that cite the paper, doi:10.1016/0960-0779(95)00089-5.

    Args:
        k: Rate k of the reaction.
        a: Excitation threshold a, between 0 and 1.
        eps0: Rate ε0 of the recovery.
        mu1: μ1 of the recovery's rate; zero leaves a constant rate.
        mu2: μ2 of the recovery's rate.
    """

    k: Positive = 8.0
    a: Annotated[float, Field(gt=0, lt=1, strict=True)] = 0.15
    eps0: Positive = 0.002
    mu1: NonNegative = 0.2
    mu2: Positive = 0.3
    states: ClassVar[tuple[str, ...]] = ("recovery",)
    time_unit: ClassVar[str | None] = None
    potential_unit: ClassVar[str | None] = None
    range: ClassVar[tuple[float, float]] = (0.0, 1.0)
    threshold: ClassVar[float] = 0.5
    calcium: ClassVar[str | None] = None
    calcium_unit: ClassVar[str | None] = None
    gates: ClassVar[tuple[str, ...]] = ()
    conserved: ClassVar[tuple[str, ...]] = ()
    pacing: ClassVar[tuple[float, float] | None] = (0.8, 0.5)

    def resting_potential(self) -> float:
        """Zero."""
        return 0.0

    def resting_states(self) -> tuple[float, ...]:
        """Zero recovery."""
        return (0.0,)

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """k v (v − a)(v − 1) + v r."""
        (recovery,) = states
        return self.k * v * (v - self.a) * (v - 1) + v * recovery

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """(ε0 + μ1 r/(v + μ2))(−r − k v (v − a − 1))."""
        (recovery,) = states
        pace = self.eps0 + self.mu1 * recovery / (v + self.mu2)
        return (pace * (-recovery - self.k * v * (v - self.a - 1)),)
