"""Shared by the tests of orders in space: norms, and orders between errors on halved meshes."""

from myostrain.engine import compile_form, fem

import numpy as np
import ufl


def norm(expression, degree=8):
    """L2 norm over the body."""
    square = ufl.inner(expression, expression) * ufl.dx(metadata={"quadrature_degree": degree})
    return np.sqrt(fem.assemble_scalar(compile_form(square)))


def orders(errors):
    """Orders between successive halvings of the mesh size or step, (n − 1, quantities)."""
    return np.log2(np.asarray(errors[:-1]) / np.asarray(errors[1:]))
