"""Shared by the tests of materials: other parameters, and energies at samples of Fe."""

import dataclasses

from myostrain.geometry import Microstructure
from myostrain.validation import with_constants

import numpy as np
import ufl

from mechanics_tools import (
    at_midpoints,
    field,
    put,
    sample_mesh,
)

N = 64  # samples of each property


def changed(material):
    """The same material with other values of all its numbers."""
    numbers = {f.name: getattr(material, f.name) for f in dataclasses.fields(material)}
    return dataclasses.replace(
        material, **{name: value + 0.5 for name, value in numbers.items() if isinstance(value, float)}
    )


class Points:
    """W, P = ∂W/∂Fe and ∂(P : H)/∂Fe of a material at N samples, through UFL as in the mechanics.

    Frames (N, dim, dim) have the unit directions f0, s0 and n0 as columns.
    """

    def __init__(self, material):
        self.material, self.dim = material, material.tensor_dim
        mesh = sample_mesh(N)
        self._F, self._H = field(mesh, (self.dim,) * 2), field(mesh, (self.dim,) * 2)
        self._directions = [field(mesh, (self.dim,)) for _ in range(self.dim)]
        F = ufl.variable(self._F)
        W = with_constants(material, mesh).energy(F, Microstructure(*self._directions))
        P = ufl.diff(W, F)
        tangent = ufl.diff(ufl.inner(P, self._H), F)
        pairs = [(i, j) for i in range(self.dim) for j in range(self.dim)]
        terms = [W, *(P[i, j] for i, j in pairs), *(tangent[i, j] for i, j in pairs)]
        self._evaluate = at_midpoints(ufl.as_vector(terms), mesh)

    def __call__(self, F, frame, H=0.0):
        put(self._F, F)
        put(self._H, np.broadcast_to(H, F.shape))
        for i, direction in enumerate(self._directions):
            put(direction, frame[:, :, i])
        values, n = self._evaluate(), self.dim**2
        return values[:, 0], values[:, 1 : n + 1].reshape(F.shape), values[:, n + 1 :].reshape(F.shape)
