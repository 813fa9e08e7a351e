"""Kinematics: what a line, a plane-stress or a plane-strain sheet and a solid mean in three dimensions.

A kinematics object turns the gradient of the unknown displacement (1 × 1 to 3 × 3) into the deformation
gradient F that the energy sees (1.1), says what det F is in the balance of the potential (2.8), whether a
pressure is unknown, and what pressure the Cauchy stress has. Materials never see the dimension of the mesh.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Protocol

from myostrain.errors import InputError
from myostrain.validation import Flag, NonNegative, Positive, description

import ufl

Constraint = Literal["total", "elastic"]
"""What is isochoric: the body, J = 1 (3.8), or the elastic part, det Fe = 1 (Cherubini et al. 2008)."""


#: Augmentation of an incompressible solid in multiples of the material's modulus. Problem 2 of Land et al. is
#: solved with 0.4 to 10 of them, and fails with none; the more, the less a coarse beam bends.
AUGMENTATION = 1.0

#: How far det F of a held body may be from the one that its constraint keeps: stretches are given in digits.
HELD = 1e-4


class Kinematics(Protocol):
    """What the mechanics asks of a kinematics."""

    dim: ClassVar[int]
    """Dimension of the mesh."""
    tensor_dim: ClassVar[int]
    """Dimension of the F that materials see: 1 (line) or 3."""
    degree: ClassVar[int]
    """Polynomial degree of the displacement."""
    free_thickness: ClassVar[bool]
    """Whether λ₃ makes up for what happens in the plane, so that it depends on all of F there."""

    @property
    def has_pressure(self) -> bool:
        """Whether the constraint is enforced by an unknown pressure (P1)."""
        ...

    @property
    def follows_activation(self) -> bool:
        """Whether J changes with the activation: where it is not kept at, or near, one."""
        ...

    def lift(self, F: Any, Jo: Any) -> Any:
        """Deformation gradient that the energy sees, from the gradient on the mesh and Jo = det Fo."""
        ...

    def volume_ratio(self, F: Any, Jo: Any) -> Any:
        """J = det F as the balance of the potential uses it (2.8); 1.0 where it is one by constraint."""
        ...

    def held_volume_ratio(self, stretches: Sequence[float]) -> float:
        """J of a body that is held at a homogeneous stretch, whatever its activation.

        Args:
            stretches: The stretches along the axes of the mesh.

        Raises:
            InputError: They contradict the constraint.
        """
        ...

    def pressure(self, sigma: Any, unknown: Any) -> Any:
        """The pressure p in σ − p 1, where σ is the Cauchy stress of the energy: what the constraint adds.

        Args:
            sigma: The Cauchy stress that energy and viscosity give, in the dimension that materials see.
            unknown: The pressure among the unknowns, None where there is none.
        """
        ...

    def constraint_residual(self, F: Any, Jo: Any) -> Any:
        """What the pressure drives to zero (only where ``has_pressure``)."""
        ...

    def pressure_energy(self, F: Any, Jo: Any, p: Any) -> Any:
        """What an unknown pressure p adds to the energy, stationary where the constraint holds.

        Only where ``has_pressure``; −p times the residual of the constraint where that is exact.
        """
        ...

    def scaled_by(self, modulus: float) -> Kinematics:
        """The same with what is to fit the material's modulus."""
        ...

    def distortion(self, F: Any, Jo: Any) -> Any:
        """What of the lifted F the passive energy sees."""
        ...

    def volume_energy(self, F: Any, Jo: Any) -> Any:
        """Energy of a change of volume per reference volume."""
        ...


class _SeesF:
    """A kinematics whose passive energy sees all of F, and nothing else."""

    free_thickness: ClassVar[bool] = False

    def constraint_residual(self, F: Any, Jo: Any) -> Any:
        """None."""
        raise NotImplementedError(f"{type(self).__name__} has no pressure unknown")

    def pressure_energy(self, F: Any, Jo: Any, p: Any) -> Any:
        """−p times the residual of the constraint."""
        return -p * self.constraint_residual(F, Jo)

    def scaled_by(self, modulus: float) -> Any:
        """Itself: nothing is to fit the material."""
        return self

    def distortion(self, F: Any, Jo: Any) -> Any:
        """F itself."""
        return F

    def volume_energy(self, F: Any, Jo: Any) -> Any:
        """None: the constraint holds, or there is none."""
        return 0.0

    def pressure(self, sigma: Any, unknown: Any) -> Any:
        """The unknown one; none where there is no constraint."""
        return 0.0 if unknown is None else unknown


@description
class Line(_SeesF):
    """One-dimensional continuum (section 4): F = J = x′, no transverse direction, no constraint.

    The displacement is quadratic, so that x′ can follow 1 + γ at every point where v is linear (4.3).
    """

    dim: ClassVar[int] = 1
    tensor_dim: ClassVar[int] = 1
    has_pressure: ClassVar[bool] = False
    follows_activation: ClassVar[bool] = True
    degree: ClassVar[int] = 2

    def lift(self, F: Any, Jo: Any) -> Any:
        """F itself, 1 × 1."""
        return F

    def volume_ratio(self, F: Any, Jo: Any) -> Any:
        """J = x′ (4.4)."""
        return F[0, 0]

    def held_volume_ratio(self, stretches: Sequence[float]) -> float:
        """The stretch itself."""
        return math.prod(stretches)


def _held(constraint: Constraint, stretches: Sequence[float]) -> float:
    """Volume ratio of a held body, one where J = 1."""
    ratio = math.prod(stretches)
    if constraint == "elastic":
        return ratio
    if abs(ratio - 1) > HELD:
        raise InputError(
            f"the stretches {', '.join(f'{stretch:g}' for stretch in stretches)} have det F = {ratio:.6g}, "
            f"and the body keeps J = 1: give stretches whose product is 1 to {HELD:g}",
            "mechanics.imposed_stretch",
        )
    return 1.0


def _target(constraint: Constraint, Jo: Any) -> Any:
    return 1.0 if constraint == "total" else Jo


def _plane(F: Any, stretch: Any) -> Any:
    return ufl.as_tensor([[F[0, 0], F[0, 1], 0], [F[1, 0], F[1, 1], 0], [0, 0, stretch]])


@description
class PlaneStress(_SeesF):
    """Incompressible sheet with free faces (section 7): λ₃ = J / det F₂ eliminates thickness and pressure.

    "The vertical component of the strain plays the role of a diagnostic variable" (section 7).

    Args:
        constraint: "total": J = 1 (3.8); "elastic": det Fe = 1, so that J = Jo.
    """

    constraint: Constraint = "total"
    dim: ClassVar[int] = 2
    tensor_dim: ClassVar[int] = 3
    has_pressure: ClassVar[bool] = False
    free_thickness: ClassVar[bool] = True
    degree: ClassVar[int] = 1

    def lift(self, F: Any, Jo: Any) -> Any:
        """F with the out-of-plane stretch that keeps the volume, 3 × 3."""
        return _plane(F, _target(self.constraint, Jo) / ufl.det(F))

    def volume_ratio(self, F: Any, Jo: Any) -> Any:
        """J = 1, or Jo where the elastic part is isochoric."""
        return _target(self.constraint, Jo)

    @property
    def follows_activation(self) -> bool:
        """Where J = Jo."""
        return self.constraint == "elastic"

    def held_volume_ratio(self, stretches: Sequence[float]) -> float:
        """One: the thickness of a held sheet makes up for its area, λ₃ = 1/(λ₁ λ₂), and is held with it."""
        return 1.0

    def pressure(self, sigma: Any, unknown: Any) -> Any:
        """What makes the faces free, σ₃₃ = 0."""
        return sigma[2, 2]


@description
class PlaneStrain(_SeesF):
    """Incompressible sheet between rigid plates: λ₃ = 1, det F₂ = J by a pressure unknown (7.1).

    Args:
        constraint: "total": J = 1 (3.8); "elastic": det Fe = 1, so that J = Jo.
    """

    constraint: Constraint = "total"
    dim: ClassVar[int] = 2
    tensor_dim: ClassVar[int] = 3
    has_pressure: ClassVar[bool] = True
    degree: ClassVar[int] = 2

    def lift(self, F: Any, Jo: Any) -> Any:
        """F with unit out-of-plane stretch, 3 × 3."""
        return _plane(F, 1)

    def volume_ratio(self, F: Any, Jo: Any) -> Any:
        """J = 1, or Jo where the elastic part is isochoric (exactly, not as the pressure enforces it)."""
        return _target(self.constraint, Jo)

    @property
    def follows_activation(self) -> bool:
        """Where J is, or tends to, Jo."""
        return self.constraint == "elastic"

    def held_volume_ratio(self, stretches: Sequence[float]) -> float:
        """λ₁ λ₂, which J = 1 wants to be one."""
        return _held(self.constraint, stretches)

    def constraint_residual(self, F: Any, Jo: Any) -> Any:
        """det F₂ − J."""
        return ufl.det(F) - _target(self.constraint, Jo)


@description
class Solid:
    """Solid, the paper's general model (3.5)–(3.8): incompressible by a pressure unknown, or nearly so.

    The pair of displacement (P2) and pressure (P1) is the stable one of Taylor and Hood. With a bulk modulus
    κ there is no pressure: the energy sees the part of F without change of volume, (J*/J)^⅓ F where J* is one
    or Jo, and κ/4 ((J/J*)² − 1 − 2 ln (J/J*)) is added to it. It tends to the incompressible body like 1/κ;
    beyond some thousand times the shear modulus quadratic displacements lock. ``mixed`` makes an unknown of
    the pressure there too, by the Legendre transform of the added energy: the same body, without locking.

    The pressure keeps the volume in the mean of each cell's neighbourhood only, and an inflated body can then
    lose its stability in what is left, though the continuous body is stable: of problem 2 of Land et al. 2015
    no equilibrium is found from about a third of the load on. The augmentation a adds a/2 (J/J* − 1)², which
    is zero where the constraint holds and so changes neither the exact solution nor the order, but makes what
    is left stiff: S. Land and others, IEEE Trans. Biomed. Eng. 62 (2015) 939–947,
    doi 10.1109/TBME.2014.2373399.

    Args:
        constraint: "total": J = 1 (3.8); "elastic": det Fe = 1, so that J = Jo.
        bulk_modulus: κ of a nearly incompressible body, a pressure; None for an incompressible one.
        mixed: Whether the pressure of a nearly incompressible body is an unknown, as that of an
            incompressible one is in any case.
        augmentation: a of an incompressible body, a pressure, zero for none; the material's modulus unless
            given (none for a material that does not say its modulus).
    """

    constraint: Constraint = "total"
    bulk_modulus: Positive | None = None
    mixed: Flag = False
    augmentation: NonNegative | None = None
    dim: ClassVar[int] = 3
    tensor_dim: ClassVar[int] = 3
    free_thickness: ClassVar[bool] = False
    degree: ClassVar[int] = 2

    def __post_init__(self) -> None:
        """Refuse an augmentation of what is not constrained."""
        if self.bulk_modulus is not None and self.augmentation is not None:
            raise InputError(
                "an augmentation is for an incompressible body; give it or bulk_modulus",
                "mechanics.augmentation",
            )

    @property
    def has_pressure(self) -> bool:
        """Whether the constraint is enforced by an unknown pressure."""
        return self.bulk_modulus is None or self.mixed

    def lift(self, F: Any, Jo: Any) -> Any:
        """F itself, 3 × 3."""
        return F

    def volume_ratio(self, F: Any, Jo: Any) -> Any:
        """J = 1, or Jo where the elastic part is isochoric (exactly, not as the pressure enforces it).

        det F where the body is nearly incompressible.
        """
        return _target(self.constraint, Jo) if self.bulk_modulus is None else ufl.det(F)

    @property
    def follows_activation(self) -> bool:
        """Where J is, or tends to, Jo."""
        return self.constraint == "elastic"

    def held_volume_ratio(self, stretches: Sequence[float]) -> float:
        """λ₁ λ₂ λ₃, which J = 1 wants to be one unless the body is nearly incompressible."""
        if self.bulk_modulus is not None:
            return math.prod(stretches)
        return _held(self.constraint, stretches)

    def pressure(self, sigma: Any, unknown: Any) -> Any:
        """The unknown one, or none: the energy holds it all."""
        return 0.0 if unknown is None else unknown

    def constraint_residual(self, F: Any, Jo: Any) -> Any:
        """det F − J, which in a nearly incompressible body is not zero."""
        return ufl.det(F) - _target(self.constraint, Jo)

    def pressure_energy(self, F: Any, Jo: Any, p: Any) -> Any:
        """−p (det F − J), or −p det F − U*(−p J), U* the Legendre transform of the energy of the volume."""
        if self.bulk_modulus is None:
            return -p * self.constraint_residual(F, Jo)
        share = -p * _target(self.constraint, Jo) / self.bulk_modulus
        ratio = share + ufl.sqrt(share**2 + 1)  # where U′ is −p J
        dual = self.bulk_modulus * (share * ratio - (ratio**2 - 1 - 2 * ufl.ln(ratio)) / 4)
        return -p * ufl.det(F) - dual

    def distortion(self, F: Any, Jo: Any) -> Any:
        """What of F the passive energy sees: all, or what does not change the volume."""
        if self.bulk_modulus is None:
            return F
        return (_target(self.constraint, Jo) / ufl.det(F)) ** (1 / 3) * F

    def scaled_by(self, modulus: float) -> Solid:
        """This kinematics with the augmentation that fits a material, unless it is given."""
        if self.bulk_modulus is not None or self.augmentation is not None:
            return self
        return dataclasses.replace(self, augmentation=AUGMENTATION * modulus)

    def volume_energy(self, F: Any, Jo: Any) -> Any:
        """Energy of the change of volume per reference volume, zero where there is none."""
        ratio = ufl.det(F) / _target(self.constraint, Jo)
        if self.bulk_modulus is not None and self.mixed:
            return 0.0  # the pressure has it
        if self.bulk_modulus is None:
            return 0.0 if self.augmentation is None else self.augmentation / 2 * (ratio - 1) ** 2
        return self.bulk_modulus / 4 * (ratio**2 - 1 - 2 * ufl.ln(ratio))


@dataclass(frozen=True)
class Deformation:
    """A deformation as the potential sees it: UFL expressions of fields that somebody else updates.

    Args:
        F: Gradient of the deformation on the mesh (dim × dim).
        J: Volume ratio in three dimensions (2.8), or the float 1.0.
        follows: The functions that F and J are made of by ``refresh``; those in them unless given.
        refresh: Makes F and J those of ``follows``.
    """

    F: Any
    J: Any = 1.0
    follows: tuple[Any, ...] | None = None
    refresh: Callable[[], None] | None = None

    @property
    def isochoric(self) -> bool:
        """Whether J is one by construction."""
        return isinstance(self.J, float) and self.J == 1.0
