"""Membrane models: one a file, equations apart from the integrator.

A model is pointwise: :class:`Membrane` says what it declares. ``current`` and ``rates`` are plain arithmetic
or NumPy functions of arrays of nodal values; derivatives are taken by the complex step, so they must be
analytic (no ``abs``; comparisons and ``numpy.where`` are fine). How its states advance is an
:class:`Integrator`'s: :class:`LinearlyImplicit` for a few states.
"""

from myostrain.membranes.checks import check_membrane
from myostrain.membranes.contracts import Integrator, Membrane, Step
from myostrain.membranes.fitzhugh_nagumo import FitzHughNagumo
from myostrain.membranes.linearly_implicit import LinearlyImplicit
from myostrain.membranes.ten_tusscher_panfilov_2006 import TenTusscherPanfilov2006
from myostrain.membranes.to_ror_d_2019 import ToRORd2019

__all__ = [
    "FitzHughNagumo",
    "Integrator",
    "LinearlyImplicit",
    "Membrane",
    "Step",
    "TenTusscherPanfilov2006",
    "ToRORd2019",
    "check_membrane",
]
