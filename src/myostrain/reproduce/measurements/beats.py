"""One beat of a strip that a membrane drives through its calcium, by the laws and schemes that ship."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain import activation
from myostrain.activation import FibreTension, TransverselyIsotropic
from myostrain.coupling import Electromechanics
from myostrain.electrics import InitialValues, Place, Potential
from myostrain.engine import MPI
from myostrain.errors import ComputationError
from myostrain.geometry import Rectangle, UniformFibres, build
from myostrain.kinematics import PlaneStress
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.mechanics.loads import Loads
from myostrain.mechanics.supports import Supports
from myostrain.membranes import BuenoOrovio2008
from myostrain.reproduce.jobs import Array, Found
from myostrain.reproduce.measurements.points import material
from myostrain.reproduce.measurements.staggering import SCHEMES

import numpy as np


def beat(law: Mapping[str, Any], active: Mapping[str, Any], load: float, step: float, end: float) -> Found:
    """A strip under a dead load, excited as a whole, by each scheme.

    Args:
        law: The passive law.
        active: ``kind``, a law of activation by calcium and stretch, and its parameters.
        load: The load per reference area, a pull.
        step: Length of the steps, ms.
        end: Until when, ms.

    Returns:
        Numbers by scheme: ``swing``, the largest |λₙ₊₁ − 2 λₙ + λₙ₋₁|/4, half the amplitude of what changes
        its sign from step to step, after the first twenty steps; ``reached``, the last time; ``iterations`` a
        step. Arrays: ``time`` and, by scheme, ``SCHEME`` λ and ``SCHEME activation``, every step.
    """
    others = dict(active)
    chosen = getattr(activation, others.pop("kind"))(**others)
    strain = getattr(chosen, "yields", "strain") == "strain"
    count = round(end / step)
    numbers: dict[str, Any] = {}
    arrays: dict[str, Array] = {"time": np.arange(count + 1, dtype=float) * step}
    for name, scheme in SCHEMES.items():
        body = build(
            Rectangle(size=(1.0, 1.0), spacing=1.0), UniformFibres(direction=(1.0, 0.0)), MPI.COMM_SELF
        )
        mechanics = Mechanics(
            body,
            kinematics=PlaneStress(),
            material=material(law),
            active=TransverselyIsotropic() if strain else FibreTension(),
            supports=Supports(sliding=("left", "bottom")),
            loads=Loads(traction={"right": (load, 0.0)}),
        )
        everywhere = Place(center=(0.5, 0.5), radius=2.0)
        potential = Potential(
            body,
            membrane=BuenoOrovio2008(set="EPI"),
            diffusivity=0.1,
            initial=[InitialValues(where=everywhere, potential=0.0)],
        )
        model = Electromechanics(potential, mechanics, law=chosen, scheme=scheme)
        model.start()
        stretch, values = np.full(count + 1, np.nan), np.full(count + 1, np.nan)
        for n in range(count + 1):
            if n:
                try:
                    model.step(n * step)
                except ComputationError:
                    break
            stretch[n] = mechanics.fibre_stretch().mean()
            values[n] = mechanics.activation.x.array.mean()
        reached = np.isfinite(stretch)
        curvature = np.abs(np.diff(stretch[20:], 2)) / 4
        numbers[name] = {
            "swing": float(np.nanmax(curvature)),
            "reached": float(arrays["time"][reached][-1]),
            "iterations": model.coupling_iterations / count,
            "shortest": float(np.nanmin(stretch)),
        }
        arrays |= {name: stretch, f"{name} activation": values}
    return Found(numbers, arrays)
