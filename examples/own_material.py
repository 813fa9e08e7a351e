"""A passive material, an activation law and a membrane model of your own, on a sheet."""

from dataclasses import dataclass

import myostrain as ms

import ufl


@dataclass(frozen=True)
class FibreReinforced:
    """Neo-Hookean with stiff fibres: W = μ/2 (I₁ − 3) + κ/4 (I₄ − 1)², where I₄ = |Fe f₀|²."""

    mu: float = 1.0
    kappa: float = 2.0
    tensor_dim = 3  # Fe is 3 × 3; 1 on a line

    def energy(self, Fe, fibres):
        fibre = Fe * fibres.f0
        return self.mu / 2 * (ufl.inner(Fe, Fe) - 3) + self.kappa / 4 * (ufl.dot(fibre, fibre) - 1) ** 2


@dataclass(frozen=True)
class Saturating:
    """γ = −β v² / (v² + h²): half of β at v = h."""

    beta: float = 0.2
    half: float = 0.3
    drivers = ("potential",)

    def activation(self, states, drivers):
        v = drivers["potential"]
        return -self.beta * v**2 / (v**2 + self.half**2)


@dataclass(frozen=True)
class AlievPanfilov:
    """R. R. Aliev, A. V. Panfilov, Chaos, Solitons & Fractals 7(3), 1996; its unit of time is 12.9 ms."""

    k: float = 8.0
    a: float = 0.15
    eps: float = 0.002
    mu_1: float = 0.2
    mu_2: float = 0.3
    states = ("recovery",)

    def resting_potential(self):
        return 0.0

    def resting_states(self):
        return (0.0,)

    def current(self, v, states):
        return self.k * v * (v - self.a) * (v - 1) + v * states[0]

    def rates(self, v, states):
        (r,) = states
        return ((self.eps + self.mu_1 * r / (self.mu_2 + v)) * (-r - self.k * v * (v - self.a - 1)),)


body = ms.build(ms.geometry.Rectangle(size=(30, 15), spacing=0.5), ms.UniformFibres(direction=(1, 1)))
mechanics = ms.Mechanics(
    body,
    kinematics=ms.kinematics.PlaneStress(),
    material=FibreReinforced(),
    supports=ms.Supports(fixed=["left"]),
)
potential = ms.Potential(
    body,
    membrane=AlievPanfilov(),
    diffusivity=(1.0, 0.25),
    deformation=mechanics.deformation,
    initial=[ms.InitialValues(where=ms.Place(center=(0, 0), radius=4), potential=1.0)],
)
model = ms.Electromechanics(potential, mechanics, law=Saturating())
probes = {"near": (10, 5), "far": (20, 10)}
simulation = ms.Simulation(model, step=0.05, end=30, probes=probes, out="runs/own-material", force=True)
results = simulation.run()
print(results["metrics"])
