"""Membrane models: one a file, equations apart from the integrator.

A model is pointwise: :class:`Membrane` says what it declares. ``current`` and ``rates`` are plain arithmetic
or NumPy functions of arrays of nodal values. How its states advance is an :class:`Integrator`'s:
:class:`LinearlyImplicit` for a few states, :class:`RushLarsen` and :class:`GeneralizedRushLarsen` for gates.
"""

from myostrain.membranes.aliev_panfilov_1996 import AlievPanfilov1996
from myostrain.membranes.bueno_orovio_2008 import BuenoOrovio2008
from myostrain.membranes.checks import check_membrane
from myostrain.membranes.contracts import Integrator, Membrane, Step
from myostrain.membranes.exponential import GeneralizedRushLarsen, RushLarsen
from myostrain.membranes.fenton_karma_1998 import FentonKarma1998
from myostrain.membranes.files import FileMembrane
from myostrain.membranes.fitzhugh_nagumo import FitzHughNagumo
from myostrain.membranes.linearly_implicit import LinearlyImplicit
from myostrain.membranes.luo_rudy_1991 import LuoRudy1991
from myostrain.membranes.mitchell_schaeffer_2003 import MitchellSchaeffer2003
from myostrain.membranes.ten_tusscher_panfilov_2006 import TenTusscherPanfilov2006
from myostrain.membranes.to_ror_d_2019 import ToRORd2019

__all__ = [
    "AlievPanfilov1996",
    "BuenoOrovio2008",
    "FentonKarma1998",
    "FileMembrane",
    "FitzHughNagumo",
    "GeneralizedRushLarsen",
    "Integrator",
    "LinearlyImplicit",
    "LuoRudy1991",
    "Membrane",
    "MitchellSchaeffer2003",
    "RushLarsen",
    "Step",
    "TenTusscherPanfilov2006",
    "ToRORd2019",
    "check_membrane",
]
