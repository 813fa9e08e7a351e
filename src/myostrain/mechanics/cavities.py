"""Cavities whose pressures are unknowns, tied to their volumes by what they are connected to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from myostrain.circulation import Circuit, Isovolumetric
from myostrain.engine import compile_form, fem
from myostrain.errors import ComputationError, InputError
from myostrain.geometry import Body
from myostrain.mechanics.active_body import ActiveBody
from myostrain.mechanics.cavity import Cavity, check_closed
from myostrain.mechanics.external_forces import ExternalForces
from myostrain.solvers.linear import assemble_nodal
from myostrain.state import State
from myostrain.validation import Count, NonNegative, check_fields

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Volume of a cavity at rest, as a share of the cube of the body's diagonal, below which it encloses nothing.
NOTHING = 1e-9


@dataclass(frozen=True)
class Cavities:
    """Cavities of a solid, and what they are connected to.

    Args:
        names: Parts of the boundary that are the walls of the cavities.
        circulation: What they are connected to, such as :class:`~myostrain.circulation.Windkessel`.
        preload: Pressure at the beginning, in all or one a cavity; zero unless given. Where the circulation
            prescribes volume or pressure there is none.
        beats: Number of beats, of equal length, that the run is meant to have; numbers are of the last one.

    Raises:
        InputError: A value does not fit its type, or the circulation has another number of cavities.
    """

    names: tuple[str, ...]
    circulation: Any
    preload: NonNegative | tuple[NonNegative, ...] | None = None
    beats: Count = 1

    def __post_init__(self) -> None:
        """Check the values."""
        check_fields(self, "circulation")
        circuit, count = self.circuit(), len(self.names)
        if count != len(set(self.names)) or count != circuit.cavities:
            raise InputError(
                f"{list(self.names)}: {type(self.circulation).__name__} has {circuit.cavities} cavities; "
                "give as many parts of the boundary, each once",
                "circulation.cavity",
            )

    def circuit(self) -> Circuit:
        """The circulation at its beginning."""
        return Circuit(self.circulation, None if self.preload is None else np.array(self.preload))


class CavityPressures:
    """The pressures of cavities as unknowns beside the displacement.

    Each has an equation, between its cavity's volume and the pressures, from the circulation. They act as
    follower pressures on the walls.

    Args:
        body: The reference body.
        cavities: The cavities, and what they are connected to; None for none.
        active: The equations of the body.
        u: The unknown.
        external: The loads, which have the pressures in them.

    Raises:
        InputError: A part of the boundary is not there, or encloses no volume.

    Attributes:
        cavities: Names of the cavities.
        beats: Number of beats in the run.
        circuit: The circulation along the run.
        names: Names of the values, "volume_NAME", "pressure_NAME" by cavity, then the circulation's states.
    """

    def __init__(
        self,
        body: Body,
        cavities: Cavities | None,
        active: ActiveBody,
        u: fem.Function,
        external: ExternalForces,
    ) -> None:
        self.cavities: tuple[str, ...] = () if cavities is None else cavities.names
        self.beats = 1 if cavities is None else cavities.beats
        self.circuit = Circuit(Isovolumetric(cavities=0)) if cavities is None else cavities.circuit()
        displacement, degree = active.displacement(u), active.kinematics.degree
        self._cavities = [Cavity(body, name, displacement, degree, u) for name in self.cavities]
        self._pressures = [external.pressures[name] for name in self.cavities]
        self._columns = [compile_form(external.unit_pressures[name]) for name in self.cavities]
        self.names = [f"{what}_{name}" for name in self.cavities for what in ("volume", "pressure")]
        self.names += self.circuit.names
        low, high = body.extent()
        size = float(np.linalg.norm(high - low)) ** 3
        self._at_rest = self._volumes = self.volumes()
        for name, volume in zip(self.cavities, self._at_rest, strict=True):
            if not volume > NOTHING * size:
                raise InputError(
                    f"'{name}' is not the wall of a cavity: it, and plane caps over its rims, enclose "
                    f"{volume:.4g}. Name the inner surface alone, whose normal out of the body points into "
                    "the cavity",
                    "circulation.cavity",
                )
            check_closed(body, name, "circulation.cavity")
        self._share = 1.0

    @property
    def loaded(self) -> bool:
        """Whether there is a preload: the body begins in equilibrium with it."""
        return bool((self.circuit.preload > 0).any())

    @property
    def numbers(self) -> Array:
        """The pressures (cavities,)."""
        return np.array([float(pressure.value) for pressure in self._pressures])

    def put(self, values: Array) -> None:
        """Take these pressures (cavities,)."""
        for pressure, value in zip(self._pressures, values, strict=True):
            pressure.value = value

    def columns(self) -> list[Array]:
        """Derivative of the residual by each pressure (collective)."""
        return [assemble_nodal(column) for column in self._columns]

    def equations(self) -> tuple[Array, Array, Array]:
        """The circulation's equations at the present state, and their derivatives (collective)."""
        volumes, pressures = self.volumes(), self.numbers
        values, by_volumes, by_pressures = self.circuit.tied(volumes, pressures)
        if self._share < 1:
            of_volume = by_volumes.any(axis=1)
            reached = self.circuit.volumes
            volumes_before = self._at_rest if reached is None else reached
            begun = np.where(of_volume, volumes - volumes_before, pressures - self.circuit.pressures)
            values = self._share * values + (1 - self._share) * begun
            by_volumes = self._share * by_volumes + (1 - self._share) * np.diag(of_volume * 1.0)
            by_pressures = self._share * by_pressures + (1 - self._share) * np.diag(~of_volume * 1.0)
        gradients = np.array([cavity.gradient() for cavity in self._cavities])
        return values, by_volumes @ gradients, by_pressures

    def volumes(self) -> Array:
        """The present volumes (cavities,) (collective)."""
        return np.array([cavity.volume() for cavity in self._cavities])

    def check(self) -> None:
        """Refuse a cavity that was turned inside out (collective).

        Raises:
            ComputationError: A volume is not positive.
        """
        for name, volume in zip(self.cavities, self.volumes(), strict=True):
            if not volume > 0:
                raise ComputationError(
                    f"the walls of the cavity '{name}' went through each other, and enclose {volume:.4g}",
                    advice="less activation, a smaller time step, or a circulation that leaves more in it.",
                )

    def said(self) -> str:
        """What the walls reached and what the circulation asked of them, in words (collective)."""
        if not self.cavities:
            return ""
        volumes, pressures, who = self.volumes(), self.numbers, type(self.circuit.model).__name__
        values, by_volumes, _ = self.circuit.tied(volumes, pressures)
        parts = []
        if self.circuit.lost is not None:
            shown = ", ".join(f"{pressure:.4g}" for pressure in self.circuit.lost)
            parts = [f"the circulation, {who}, has no states for the pressures in the cavities, {shown}"]
            if not np.isfinite(values).all():
                return parts[0]
        for name, V, p, value, of_volume in zip(
            self.cavities, volumes, pressures, values, by_volumes.any(axis=1), strict=True
        ):
            asked = f"a volume of {V - value:.4g}" if of_volume else f"a pressure of {p - value:.4g}"
            parts.append(
                f"the wall of '{name}' held {V:.4g} at a pressure of {p:.4g}, {who} asked for {asked}"
            )
        return "; ".join(parts)

    def begin(self, time: float) -> None:
        """Begin anew, and get ready for the preload, or what is prescribed at ``time``."""
        self.circuit.clear()
        self.put(self.circuit.prepare(time, 1))

    def prepare(self, end: float, order: int) -> None:
        """Get ready for a step to the time ``end``, by backward differences of an order."""
        self.put(self.circuit.prepare(end, order))

    def go(self, share: float) -> None:
        """Ask for this share of the step's change: none is what was accepted last, one all of it."""
        self._share = share

    def go_back(self) -> None:
        """Take the pressures that were accepted last."""
        self.put(self.circuit.pressures)

    def accept(self, time: float) -> None:
        """Take the present volumes and pressures as those at ``time`` (collective)."""
        self._volumes = self.volumes()
        self.circuit.accept(time, self._volumes, self.numbers)

    def values(self) -> dict[str, float]:
        """Volumes, pressures and states at the last accepted time, by name."""
        pairs = zip(self._volumes, self.circuit.pressures, strict=True)
        found = [value for pair in pairs for value in pair]
        return dict(zip(self.names, map(float, [*found, *self.circuit.states]), strict=True))

    def state(self) -> State:
        """The circulation's past, the present pressures, and the volumes that were accepted last."""
        present = {"pressures": self.numbers.tolist(), "volumes": self._volumes.tolist()}
        return {"circuit": self.circuit.state(), **present}

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self.circuit.restore(state["circuit"])
        self.put(np.array(state["pressures"]))
        self._volumes = np.array(state["volumes"])
        self._share = 1.0
