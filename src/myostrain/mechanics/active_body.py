"""The equations of the active body, in UFL: F = Fe Fo, its energy, its viscosity, its stress."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.activation import ActiveDeformation, ActiveTension, Fibre, Yield
from myostrain.engine import fem
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.kinematics import Kinematics
from myostrain.materials import Material
from myostrain.validation import with_constants

import ufl


class ActiveBody:
    """Kinematics, passive energy, activation and viscosity of a body put together, each written once.

    The viscosity is that of Kelvin and Voigt, its stress scaled by the material's ``modulus`` times the
    relaxation time λ, and its strain measured from the intermediate configuration:

    - on a line (4.14), λ d/dt[(x′ − 1)/(1 + γ)] beside the spring's x′/(1 + γ) − 1;
    - else by the second Piola stress S = 2 λ μ Fo⁻ᵀ Ė Fo⁻¹ of the intermediate configuration, where
      E = (FᵀF − 1)/2. It is frame-indifferent, as E is; its power per reference volume,
      2 λ μ Jo |Fo⁻ᵀ Ė Fo⁻¹|², is never negative; and to first order in strain it relaxes as (4.14) does.

    A viscosity η stands for 2 λ μ where it is given: that of the dissipation potential η/2 tr Ė².

    Args:
        body: The reference body.
        kinematics: What the mesh's dimension means in three dimensions.
        material: Passive material W(Fe).
        active: Active deformation Fo(γ), or what a tension does.
        relaxation_time: λ, zero for an elastic body.
        viscosity: η in place of 2 λ μ, where it is not zero.

    Throughout, ``a`` is the activation, a UFL scalar: γ, or the tension.
    """

    def __init__(
        self,
        body: Body,
        kinematics: Kinematics,
        material: Material,
        active: ActiveDeformation | ActiveTension,
        relaxation_time: float,
        viscosity: float = 0.0,
    ) -> None:
        mesh = body.mesh
        modulus = getattr(material, "modulus", None)
        fitting = kinematics.scaled_by(modulus if isinstance(modulus, float) else 0.0)
        self.kinematics, self._dim = with_constants(fitting, mesh), body.dim
        self._material = with_constants(material, mesh)
        found: Any = with_constants(active, mesh)
        strains = hasattr(found, "tensor")
        self._deformation: ActiveDeformation = found if strains else Fibre()
        self._tension: ActiveTension | None = None if strains else found
        self.name = type(active).__name__
        self._fibres = body.fibres.lifted(body.dim, kinematics.tensor_dim)
        self._dashpot: Any = None  # λ μ, or η/2
        if viscosity > 0:
            self._dashpot = fem.Constant(mesh, float(viscosity)) / 2
        elif relaxation_time > 0:
            self._dashpot = fem.Constant(mesh, float(relaxation_time)) * self._material.modulus  # type: ignore[attr-defined]

    def displacement(self, u: fem.Function) -> Any:
        """The displacement in the unknown, which may hold a pressure too."""
        return ufl.split(u)[0] if self.kinematics.has_pressure else u

    def gradient(self, u: fem.Function) -> Any:
        """F on the mesh (dim × dim)."""
        return ufl.Identity(self._dim) + ufl.grad(self.displacement(u))

    @property
    def yields(self) -> Yield:
        """What the activation is: "strain" or "tension"."""
        return "strain" if self._tension is None else "tension"

    def active(self, a: Any) -> Any:
        """Fo, in the dimension that materials see; 1 under a tension."""
        return self._deformation.tensor(a if self._tension is None else 0.0, self._fibres)

    def lifted(self, u: fem.Function, a: Any) -> Any:
        """F in the dimension that materials see."""
        return self.kinematics.lift(self.gradient(u), ufl.det(self.active(a)))

    def stored(self, F: Any, a: Any) -> Any:
        """Jo W(F Fo⁻¹) per reference volume for the lifted F, the energies of volume and active stress."""
        Fo = self.active(a)
        Jo = ufl.det(Fo)
        whole = getattr(self._material, "sees_volume", False)
        passive = F if whole else self.kinematics.distortion(F, Jo)
        W = self._material.energy(passive * ufl.inv(Fo), self._fibres)
        if shape := getattr(W, "ufl_shape", ()):
            name = type(self._material).__name__
            raise InputError(f"{name}.energy is of shape {shape}: give a scalar of UFL", "mechanics.material")
        density = Jo * W
        density += self.kinematics.volume_energy(F, Jo)
        if self._tension is not None:
            density += self._tension.energy(F, self._fibres, a)
        return density

    def energy(self, u: fem.Function, a: Any) -> Any:
        """Energy per reference volume, with the pressure's part if there is one (3.3)."""
        density = self.stored(self.lifted(u, a), a)
        if self.kinematics.has_pressure:
            Jo = ufl.det(self.active(a))
            density += self.kinematics.pressure_energy(self.gradient(u), Jo, ufl.split(u)[1])
        return density

    def stabilization(self, unknown: fem.Function, a: Any, dx: Any) -> Any:
        """What the preconditioner of a large incompressible solid has beside the tangent, on the mixed space.

        The modulus is the mean of ∂²W/∂F² over the components of F, whatever the material. See
        :mod:`myostrain.solvers.saddle_point`.

        Args:
            unknown: Displacement and pressure.
            a: The activation.
            dx: The volume's measure.
        """
        space = unknown.function_space
        w, u = ufl.TestFunction(space), ufl.TrialFunction(space)
        F = ufl.variable(self.lifted(unknown, a))
        stress = ufl.diff(self.stored(F, a), F)
        n = F.ufl_shape[0]
        modulus = abs(sum(ufl.diff(stress[i, j], F)[i, j] for i in range(n) for j in range(n))) / n**2
        Jo = ufl.det(self.active(a))
        constraint = self.kinematics.constraint_residual(self.gradient(unknown), Jo)
        volume = ufl.derivative(constraint, unknown, w) * ufl.derivative(constraint, unknown, u)
        return (modulus * volume - ufl.split(w)[1] * ufl.split(u)[1] / (2 * modulus)) * dx

    # Viscosity.

    def _strain(self, u: fem.Function, a: Any) -> Any:
        """What the viscosity takes the rate of: E, or (x′ − 1)/(1 + γ) on a line."""
        F = self.lifted(u, a)
        if self.kinematics.tensor_dim == 1:
            return (F - ufl.Identity(1)) / self.active(a)[0, 0]
        return (F.T * F - ufl.Identity(3)) / 2

    def strain_rate(self, weights: Sequence[Any], fields: Sequence[tuple[fem.Function, Any]]) -> Any:
        """The rate of that strain by a backward difference over pairs of u and a, newest first."""
        terms = [w * self._strain(u, a) for w, (u, a) in zip(weights, fields, strict=True)]
        return sum(terms[1:], terms[0])

    def viscous_stress(self, rate: Any, a: Any) -> Any:
        """What does the power on the rate of that strain, per reference volume."""
        if self.kinematics.tensor_dim == 1:
            return self._dashpot * rate
        back = ufl.inv(self.active(a))
        return 2 * self._dashpot * ufl.det(self.active(a)) * back * back.T * rate * back * back.T

    def viscous_power(self, rate: Any, u: fem.Function, a: Any, test: Any) -> Any:
        """Virtual power of the viscous stress per reference volume.

        On a line the stress acts on x′ itself, as in (4.14); else on the rate of E.
        """
        F = self.lifted(u, a)
        virtual = ufl.derivative(F, u, test)
        if self.kinematics.tensor_dim > 1:
            virtual = (F.T * virtual + virtual.T * F) / 2
        return ufl.inner(self.viscous_stress(rate, a), virtual)

    # Stress, for output.

    def cauchy(self, u: fem.Function, a: Any, rate: Any = None) -> Any:
        """Cauchy stress σ = J⁻¹ P Fᵀ in three dimensions (1 × 1 on a line).

        Args:
            u: The unknown.
            a: The activation.
            rate: Rate of the viscous strain, None for an elastic body.
        """
        sigma = self.cauchy_without_pressure(u, a, rate)
        return sigma - self._pressure(sigma, u) * ufl.Identity(self.kinematics.tensor_dim)

    def pressure(self, u: fem.Function, a: Any, rate: Any = None) -> Any:
        """The pressure in :meth:`cauchy` that the constraint adds, zero where there is none."""
        return self._pressure(self.cauchy_without_pressure(u, a, rate), u)

    def _pressure(self, sigma: Any, u: fem.Function) -> Any:
        return self.kinematics.pressure(sigma, ufl.split(u)[1] if self.kinematics.has_pressure else None)

    def cauchy_without_pressure(self, u: fem.Function, a: Any, rate: Any = None) -> Any:
        """The Cauchy stress that energy and viscosity give, without pressure."""
        F = ufl.variable(self.lifted(u, a))
        sigma = ufl.diff(self.stored(F, a), F) * F.T / ufl.det(F)
        if rate is None or self._dashpot is None:
            return sigma
        S = self.viscous_stress(rate, a)
        return sigma + (S if self.kinematics.tensor_dim == 1 else F * S * F.T / ufl.det(F))
