"""FitzHugh–Nagumo membrane."""

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

from myostrain.validation import Flag, NonNegative, Positive, description

from pydantic import Field


@description
class FitzHughNagumo:
    """The paper's membrane, (2.1)–(2.2): current A [v (v − α)(v − 1) + w], dw/dt = v − w/τ.

    Args:
        alpha: Excitation threshold α, between 0 and 1; 0.1 in the paper.
        tau: Recovery time τ, positive; 0.2 in the paper.
        A: Rate A of the reaction, zero or more; 100 in the paper. Zero leaves pure diffusion.
        recovery: Whether w, the state called "recovery", exists; without it fronts travel instead of
            pulses (section 4.1).
    """

    alpha: Annotated[float, Field(gt=0, lt=1, strict=True)] = 0.1
    tau: Positive = 0.2
    A: NonNegative = 100.0
    recovery: Flag = True
    time_unit: ClassVar[str | None] = None
    potential_unit: ClassVar[str | None] = None
    range: ClassVar[tuple[float, float]] = (0.0, 1.0)
    threshold: ClassVar[float] = 0.5
    calcium: ClassVar[str | None] = None
    calcium_unit: ClassVar[str | None] = None
    gates: ClassVar[tuple[str, ...]] = ()
    pacing: ClassVar[tuple[float, float] | None] = (50.0, 0.01)

    @property
    def states(self) -> tuple[str, ...]:
        """The recovery variable, if there is one."""
        return ("recovery",) if self.recovery else ()

    @property
    def conserved(self) -> tuple[str, ...]:
        """The recovery variable: J w is balanced, as J v is."""
        return self.states

    def resting_potential(self) -> float:
        """Zero."""
        return 0.0

    def resting_states(self) -> tuple[float, ...]:
        """Zero recovery."""
        return (0.0,) if self.recovery else ()

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """A [v (v − α)(v − 1) + w]."""
        cubic = v * (v - self.alpha) * (v - 1)
        return self.A * (cubic + states[0]) if self.recovery else self.A * cubic

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """v − w/τ."""
        return (v - states[0] / self.tau,) if self.recovery else ()
