"""Curves of a material: stress of an incompressible point that is stretched or sheared."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from myostrain.engine import MPI, fem, jit_options
from myostrain.errors import InputError
from myostrain.geometry import Microstructure
from myostrain.output.figures.style import COLOURS, GREY, new_figure, save, style
from myostrain.validation import with_constants

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import mesh as dmesh

Array = npt.NDArray[np.float64]

#: The axes of the point: fibre, sheet direction, normal of the sheet.
AXES = "fsn"
LABELS = {"f": "fibre f", "s": "sheet s", "n": "normal n"}
#: Bisections for the lateral stretch; the interval is below round-off after 60.
BISECTIONS = 60
#: What files of pictures may end in.
SUFFIXES = (".png", ".pdf", ".svg")


def uniaxial(material: Any, stretch: Array) -> dict[str, Array]:
    """Cauchy stress under tension or compression along each axis, the other two free.

    The lateral stretches multiply to 1/λ, and their ratio makes both lateral stresses equal, which the
    pressure then takes away: found by bisection, at all stretches at once.

    Args:
        material: Passive material for three dimensions.
        stretch: Stretches λ along the axis, (n,).

    Returns:
        Stress (n,) along the axis, for "f", "s" and "n".
    """
    curves = {}
    evaluate = _stress(material, len(stretch))
    for axis, name in enumerate(AXES):
        one, other = (i for i in range(3) if i != axis)

        def point(share: Array, along: int = axis, one: int = one, other: int = other) -> Array:
            F = np.zeros((len(stretch), 3, 3))
            F[:, along, along] = stretch
            F[:, one, one], F[:, other, other] = stretch**-share, stretch ** (share - 1)
            return F

        # One of the sides takes a share of 1/λ between none and all: the more it takes, the less is its
        # stress where λ > 1 makes it thinner, and the other way round.
        low, high = np.zeros_like(stretch), np.ones_like(stretch)
        sign = np.sign(1 - stretch)
        for _ in range(BISECTIONS):
            share = (low + high) / 2
            sigma = evaluate(point(share))
            more = sign * (sigma[:, one, one] - sigma[:, other, other]) < 0
            low, high = np.where(more, share, low), np.where(more, high, share)
        sigma = evaluate(point((low + high) / 2))
        curves[name] = sigma[:, axis, axis] - (sigma[:, one, one] + sigma[:, other, other]) / 2
    return curves


def equibiaxial(material: Any, stretch: Array) -> dict[str, Array]:
    """Cauchy stresses under equal stretches along fibre and sheet direction, the normal free.

    Args:
        material: Passive material for three dimensions.
        stretch: Stretches λ, (n,).

    Returns:
        Stress (n,) along the fibre, "f", and along the sheet direction, "s".
    """
    F = np.zeros((len(stretch), 3, 3))
    F[:, 0, 0] = F[:, 1, 1] = stretch
    F[:, 2, 2] = stretch**-2
    sigma = _stress(material, len(stretch))(F)
    return {name: sigma[:, i, i] - sigma[:, 2, 2] for i, name in enumerate("fs")}


def simple_shear(material: Any, amount: Array) -> dict[str, Array]:
    """Shear stress in the six modes of simple shear of Dokos and others 2002, F = 1 + κ j⊗i for "ij".

    Args:
        material: Passive material for three dimensions.
        amount: Amounts of shear κ, (n,).

    Returns:
        Cauchy shear stress σ_ij (n,), for "ij": the face across i is shifted along j.
    """
    evaluate, curves = _stress(material, len(amount)), {}
    for i, j in ((0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)):
        F = np.broadcast_to(np.eye(3), (len(amount), 3, 3)).copy()
        F[:, j, i] = amount
        curves[AXES[i] + AXES[j]] = evaluate(F)[:, i, j]
    return curves


def draw_material(
    material: Any,
    path: str | Path,
    *,
    stretch: tuple[float, float] = (0.85, 1.15),
    shear: float = 0.4,
    unit: str = "",
) -> Path:
    """Draw the curves of a material for three dimensions, as ``myostrain material`` does.

    Three panels show Cauchy stress: :func:`uniaxial`, :func:`equibiaxial` and :func:`simple_shear`, which
    give the numbers too. The material is incompressible and passive; it may be one of a script's own::

        draw_material(ms.materials.Guccione1995(C=2.0, bf=8.0), "guccione.png", unit="kPa")

    Args:
        material: The passive material.
        path: Where to, a .png, .pdf or .svg file, replaced if it exists.
        stretch: Range of the stretches.
        shear: Largest amount of shear.
        unit: Unit of its stiffness, such as "kPa"; none by default.

    Returns:
        The path.

    Raises:
        InputError: It cannot be written, or the material is that of a line.
    """
    path = Path(path)
    if material.tensor_dim != 3:
        raise InputError(f"{type(material).__name__} is for a line; curves are of materials for 3D", "NAME")
    if path.suffix not in SUFFIXES:
        raise InputError(f"'{path}' is not a picture: end its name in {', '.join(SUFFIXES)}", "--out")
    lam, kappa = np.linspace(*stretch, 61), np.linspace(0.0, shear, 41)
    of = f" ({unit})" if unit else ""
    panels = (
        ("Uniaxial", r"stretch $\lambda$", lam, uniaxial(material, lam)),
        ("Equibiaxial", r"stretch $\lambda$ of fibre and sheet", lam, equibiaxial(material, lam)),
        ("Simple shear", r"amount of shear $\kappa$", kappa, simple_shear(material, kappa)),
    )
    with style():
        figure = new_figure(10.5, 3.6, _title(material))
        for panel, (title, label, x, curves) in zip(figure.subplots(1, 3), panels, strict=True):
            for i, (names, y) in enumerate(_distinct(curves)):
                panel.plot(x, y, color=COLOURS[i], label=", ".join(LABELS.get(name, name) for name in names))
            panel.axhline(0, color=GREY, linewidth=0.5, zorder=1)
            panel.set(title=title, xlabel=label, ylabel=rf"Cauchy stress{of}")
            panel.margins(x=0)
            panel.legend()
        return save(figure, path)


def _title(material: Any) -> str:
    space = "\N{NO-BREAK SPACE}"
    numbers = {name: value for name, value in vars(material).items() if isinstance(value, float)}
    values = ", ".join(f"{name}{space}={space}{value:g}" for name, value in numbers.items())
    return f"{type(material).__name__}: {values}" if values else type(material).__name__


def _distinct(curves: dict[str, Array]) -> list[tuple[list[str], Array]]:
    """Curves with their names, those together that are the same to a thousandth of the largest."""
    size = max(float(np.abs(y).max()) for y in curves.values()) or 1.0
    groups: list[tuple[list[str], Array]] = []
    for name, y in curves.items():
        same = next((names for names, other in groups if np.abs(y - other).max() < 1e-3 * size), None)
        if same is None:
            groups.append(([name], y))
        else:
            same.append(name)
    return groups


def _stress(material: Any, count: int) -> Callable[[Array], Array]:
    """Prepare σ = (∂W/∂F) Fᵀ, without pressure, at ``count`` deformations (count, 3, 3) with det F = 1.

    One cell of a mesh is one deformation, so that one evaluation serves them all.
    """
    mesh = dmesh.create_interval(MPI.COMM_SELF, count, [0.0, 1.0])
    given = fem.Function(fem.functionspace(mesh, ("DG", 0, (3, 3))))
    F = ufl.variable(given)
    axes = Microstructure(*(ufl.as_vector([float(i == j) for j in range(3)]) for i in range(3)))
    sigma = ufl.diff(with_constants(material, mesh).energy(F, axes), F) * F.T
    compiled = fem.Expression(sigma, np.array([[0.5]]), jit_options=jit_options())
    cells = np.arange(count, dtype=np.int32)
    dofs = given.function_space.dofmap.list[:, 0]

    def evaluate(deformation: Array) -> Array:
        given.x.array.reshape(count, 9)[dofs] = deformation.reshape(count, 9)
        return compiled.eval(mesh, cells).reshape(count, 3, 3)

    return evaluate
