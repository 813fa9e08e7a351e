"""The energy of the potential over time, and what changes it: (5.1) and its start (5.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import myostrain as ms
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.cases import resolved
from myostrain.theory import startup

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: D = A and τ, α, β of the paper's figures.
RATE, TAU, ALPHA, BETA = 100.0, 0.2, 0.1, 0.3


def identity(body: str, scheme: str, steps: Sequence[float], end: float) -> Found:
    """How far (5.1), integrated over time by the trapezoidal rule, is from closing.

    The reaction is summed at the nodes, as the scheme does it, so that nothing but the time step remains.

    Args:
        body: "sheet" (plane stress, J = 1) or "line" (elastic, J = x′).
        scheme: Name of the scheme.
        steps: Time steps, each half the one before.
        end: Simulated time to which is integrated.

    Returns:
        Numbers, a list by steps each: ``printed``, the defect of (5.1) as it is printed; ``weighted``, with
        the weight J; ``whole``, with −½∫ J_t (v² + A w²) too; all relative to the sum of the sizes of
        the terms. ``change``: relative change of the energy over the time.
    """
    rows = [_defects(body, scheme, step, end) for step in steps]
    return Found({name: [row[name] for row in rows] for name in rows[0]})


def initial_rate(body: str, stretch: Sequence[float], amplitudes: Sequence[float], width: float) -> Found:
    """dE/dt at t = 0 on a held body, by two short steps, beside what (5.2) says.

    Args:
        body: "sheet" or "line".
        stretch: The homogeneous stretch that holds it, one a direction.
        amplitudes: Heights of the bump a exp(−|X|²/width²).
        width: Its width.

    Returns:
        Numbers, a list by amplitudes each: ``rate``, measured; ``gain`` and ``loss``, the sides of (5.2).
    """
    numbers: dict[str, Any] = {"rate": [], "gain": [], "loss": []}
    for amplitude in amplitudes:
        model = _model(body, "implicit", amplitude, width, stretch)
        energy = _Energy(model)
        J = float(np.prod(stretch)) if body == "line" else 1.0
        model.start()
        mesh, v = (energy.X, energy.cells), energy.v.copy()
        gain = startup.reaction_power(*mesh, v, alpha=ALPHA, A=RATE, J=J)
        loss = startup.diffusion_loss(*mesh, v, F=np.diag(stretch), diffusivity=RATE, J=J)
        rates = []
        for step in (2e-6, 1e-6):
            model.potential.v.x.array[:] = v
            model.start()
            before = J * energy.amount(1.0)
            model.step(step)
            rates.append((J * energy.amount(1.0) - before) / step)
        numbers["rate"].append(2 * rates[1] - rates[0])
        numbers["gain"].append(gain)
        numbers["loss"].append(loss)
    return Found(numbers)


#: Small bodies, solved far below the errors in time.
BODIES = {
    "line": ("startup-1d", "geometry.length=40.0", "mechanics.tolerance=1e-13", "probes={a=[5.0]}"),
    "sheet": ("sheet-2d", 'geometry={kind="rectangle", size=[24.0, 24.0], spacing=2.0}',
              "probes={a=[5.0, 5.0]}", "initial={potential=0.0, center=[0.0, 0.0], radius=5.0}",
              'potential.mass="lumped"', "mechanics.every=1", "mechanics.tolerance=1e-12"),
}  # fmt: skip
#: Cells of a body that is held, to see its first moments.
FINE = {"line": 0.25, "sheet": 0.5}


def _model(
    body: str, scheme: str, amplitude: float, width: float, stretch: Sequence[float] | None = None
) -> ms.Electromechanics:
    """A small body with a smooth bump in its corner."""
    name, *settings = BODIES[body]
    settings += [f"time.scheme={scheme}", "solver.potential={ksp_rtol=1e-13}"]
    if stretch is not None:
        held = f"mechanics.imposed_stretch={{value={list(stretch)}, until=inf}}"
        settings += [f"geometry.spacing={FINE[body]}", held]
    model = ms.Case.from_dict(resolved(name, settings)).build()
    X = model.potential.v.function_space.tabulate_dof_coordinates()[:, : model.potential.body.dim]
    model.potential.v.x.array[:] = amplitude * np.exp(-((X / width) ** 2).sum(axis=1))
    return model


class _Energy:
    """The terms of (5.1) on the present state of a model, in NumPy."""

    def __init__(self, model: ms.Electromechanics) -> None:
        space = model.potential.v.function_space
        self._model = model
        self.X = space.tabulate_dof_coordinates()[:, : model.potential.body.dim]
        self.cells = np.asarray(space.dofmap.list)
        self._weight = model.potential.weight
        edges = self.X[self.cells[:, 1:]] - self.X[self.cells[:, :1]]
        self._inverse = np.linalg.inv(edges)

    @property
    def v(self) -> Array:
        """The potential at the nodes."""
        return np.asarray(self._model.potential.v.x.array)

    @property
    def w(self) -> Array:
        """The recovery at the nodes."""
        return self._model.potential.states[0]

    def J(self) -> tuple[Array, Array]:
        """Volume ratio at the nodes and in the cells; (4.3) on the line."""
        if self.X.shape[1] == 2:
            return np.ones(len(self.X)), np.ones(len(self.cells))
        return 1 - BETA * self.v, self.F()[:, 0, 0]

    def F(self) -> Array:
        """Gradient of the deformation at the centres of the cells (m, dim, dim), from the nodes of u."""
        mechanics = self._model.mechanics
        assert mechanics is not None
        dim = self.X.shape[1]
        u = mechanics.displacement().x.array.reshape(-1, dim)
        rises = u[self.cells[:, 1:]] - u[self.cells[:, :1]]
        return np.eye(dim) + np.swapaxes(self._inverse @ rises, 1, 2)

    def amount(self, J: Array | float) -> float:
        """∫ J (v² + A w²)/2."""
        return float(np.sum(self._weight * J * (self.v**2 + RATE * self.w**2)) / 2)

    def terms(self, J: Array, J_cells: Array) -> Array:
        """What changes it: by diffusion, by reaction, by recovery (3,)."""
        v, w, weight = self.v, self.w, self._weight * J
        diffusion = startup.diffusion_loss(self.X, self.cells, v, F=self.F(), diffusivity=RATE, J=J_cells)
        reaction = RATE * np.sum(weight * v**2 * (v - ALPHA) * (v - 1))
        return -np.array([diffusion, reaction, RATE * np.sum(weight * w**2) / TAU])

    def read(self) -> Mapping[str, Any]:
        """Everything that enters the identities."""
        J, J_cells = self.J()
        one, one_cells = np.ones_like(J), np.ones_like(J_cells)
        return {
            "plain": self.amount(one),
            "weighted": self.amount(J),
            "plain terms": self.terms(one, one_cells),
            "weighted terms": self.terms(J, J_cells),
            "J": J,
            "density": self._weight * (self.v**2 + RATE * self.w**2),
        }


def _defects(body: str, scheme: str, step: float, end: float) -> dict[str, float]:
    model = _model(body, scheme, 0.9, 6.0)
    energy = _Energy(model)
    model.start()
    reads = [energy.read()]
    for number in range(1, round(end / step) + 1):
        model.step(number * step)
        reads.append(energy.read())

    def integral(name: str) -> Array:
        values = np.array([read[name] for read in reads])
        return np.asarray(step * (values[1:] + values[:-1]).sum(axis=0) / 2)

    def change(name: str) -> float:
        return float(reads[-1][name] - reads[0][name])

    plain, weighted = integral("plain terms"), integral("weighted terms")
    # −½∫ J_t (v² + A w²), by the trapezoidal rule in J.
    swelling = -sum(
        float((after["J"] - before["J"]) @ (after["density"] + before["density"])) / 4
        for before, after in pairwise(reads)
    )
    return {
        "printed": float((change("plain") - plain.sum()) / np.abs(plain).sum()),
        "weighted": float((change("weighted") - weighted.sum()) / np.abs(weighted).sum()),
        "whole": float((change("weighted") - weighted.sum() - swelling) / np.abs(weighted).sum()),
        "change": change("plain") / reads[0]["plain"],
    }
