"""Problems 2 and 3 of Land et al. 2015 as what they are: axisymmetric, with a twist (see axisymmetric.py).

The energy is that of the material, the active stress Ta f⊗f and an augmentation, which is zero where J = 1.
"""

import sys
from dataclasses import dataclass

import numpy as np
import ufl

from reference import axisymmetric

WALL = axisymmetric.Ventricle(helix=(90.0, -90.0))


@dataclass(frozen=True)
class Guccione:
    """C, bf, bt, bfs and tension, kPa; the active strain of the fibre, and whether it is isochoric."""

    C: float
    bf: float
    bt: float
    bfs: float
    tension: float = 0.0
    strain: float = 0.0
    isochoric: bool = True

    def __call__(self, F, fibre, across, outwards, load):
        """Energy per reference volume."""
        along, one = ufl.outer(fibre, fibre), ufl.Identity(3)
        gamma = load * self.strain
        Fo = (1 + gamma) * along + ((1 + gamma) ** -0.5 if self.isochoric else 1) * (one - along)
        Fe = F * ufl.inv(Fo)
        E = (Fe.T * Fe - one) / 2
        stretch = ufl.dot(fibre, E * fibre)
        shear = 2 * (ufl.dot(E * fibre, E * fibre) - stretch**2)
        rest = ufl.inner(E, E) - stretch**2 - shear
        Q = self.bf * stretch**2 + self.bfs * shear + self.bt * rest
        # Where there is a tension there is no active strain, and E is that of F.
        return ufl.det(Fo) * self.C / 2 * (ufl.exp(Q) - 1) + load * self.tension * stretch


PROBLEMS = {
    2: axisymmetric.Problem(Guccione(10.0, 1.0, 1.0, 1.0), pressure=10.0),
    3: axisymmetric.Problem(Guccione(2.0, 8.0, 2.0, 4.0, tension=60.0), pressure=15.0),
}


def at_rest(t, s):
    """(R, Z) of the parameters."""
    return WALL.at_rest(t, s)[:2]


def solve(number, layers, along, degree=3, step=0.05):
    """Solve a problem; returns a function of t and s (n,) that gives r, φ and z (n, 3)."""
    return axisymmetric.solve(WALL, PROBLEMS[number], layers, along, degree, step)


if __name__ == "__main__":  # NUMBER LAYERS ALONG [DEGREE]: the lines of cases/land, on this mesh
    found = solve(*map(int, sys.argv[1:]))
    for name, t in (("endocardium", 0.0), ("midwall", 0.5), ("epicardium", 1.0)):
        s = np.linspace(0, 1, 11)
        (R, Z), (r, turn, z) = at_rest(t, s), found(np.full(11, t), s).T
        print(f"\n[lines.{name}]")
        for key, (x, y, height) in (
            ("points", (R, 0 * R, Z)),
            ("converged", (r * np.cos(turn), r * np.sin(turn), z)),
        ):
            print(f"{key} = [")
            for row in np.round(np.stack([x, y, height], axis=1), 4) + 0.0:
                print(f"    {row.tolist()},")
            print("]")
