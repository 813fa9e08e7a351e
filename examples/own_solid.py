"""A passive material and an active deformation of your own, in a solid with fibres and sheets."""

from dataclasses import dataclass

import myostrain as ms

import ufl


@dataclass(frozen=True)
class Reinforced:
    """Neo-Hookean with fibres and weaker sheets: W = μ/2 (I₁ − 3) + κ_f/4 (I₄f − 1)² + κ_s/4 (I₄s − 1)²."""

    mu: float = 1.0
    kappa_f: float = 2.0
    kappa_s: float = 0.5
    tensor_dim = 3

    @property
    def modulus(self):  # at rest, of shear: scales the augmentation, viscosity, the monitor of ellipticity
        return self.mu

    def energy(self, Fe, fibres):
        f, s = Fe * fibres.f0, Fe * fibres.s0
        W = self.mu / 2 * (ufl.inner(Fe, Fe) - 3)
        W += self.kappa_f / 4 * (ufl.dot(f, f) - 1) ** 2
        return W + self.kappa_s / 4 * (ufl.dot(s, s) - 1) ** 2


@dataclass(frozen=True)
class Biaxial:
    """Fo that shortens along the fibre by γ, along the sheet by a share of it, and keeps the volume."""

    share: float = 0.3

    def tensor(self, gamma, fibres):
        f0, s0, n0 = fibres.f0, fibres.s0, fibres.n0
        f, s = 1 + gamma, 1 + self.share * gamma
        return f * ufl.outer(f0, f0) + s * ufl.outer(s0, s0) + 1 / (f * s) * ufl.outer(n0, n0)


fibres = ms.UniformFibres(direction=(1, 0, 0), sheet=(0, 1, 0))
body = ms.build(ms.geometry.Slab(size=(12, 4, 2), spacing=1.0), fibres)
mechanics = ms.Mechanics(
    body,
    kinematics=ms.kinematics.Solid(),
    material=Reinforced(),
    active=Biaxial(),
    tolerance=1e-5,
    supports=ms.Supports(sliding=["left", "front", "bottom"]),
)
potential = ms.Potential(
    body,
    membrane=ms.membranes.FitzHughNagumo(),
    diffusivity=(100.0, 25.0),
    mass="averaged",
    deformation=mechanics.deformation,
    initial=[ms.InitialValues(where=ms.Place(center=(0, 0, 0), radius=4), potential=0.9)],
)
law = ms.activation.Proportional(beta=0.3)
model = ms.Electromechanics(potential, mechanics, law=law, scheme=ms.SecondOrder(every=4))
probes = {"near": (4, 2, 1), "far": (10, 2, 1)}
simulation = ms.Simulation(model, step=4e-3, end=0.8, probes=probes, out="runs/own-solid", force=True)
results = simulation.run()
print(results["metrics"])
