"""Activation: how the active strain γ, or a tension, follows what drives it, and what it does to the body.

An :class:`ActivationLaw` works on arrays of nodal values, in NumPy. It names its ``drivers`` and its own
``states``, and yields γ or a tension at every node. What γ does is said by an :class:`ActiveDeformation` (Fo
from γ), what a tension does by an :class:`ActiveTension` (an energy): both in UFL. Each is one class a file,
and replaceable by an object of the user's script.
"""

from myostrain.activation.active_stress import ActiveStress
from myostrain.activation.bestel_2001 import Bestel2001
from myostrain.activation.contracts import (
    ActivationLaw,
    ActiveDeformation,
    ActiveTension,
    LawWithStates,
    Yield,
)
from myostrain.activation.fibre import Fibre
from myostrain.activation.fibre_tension import FibreTension
from myostrain.activation.goektepe_kuhl_2010 import GoektepeKuhl2010
from myostrain.activation.hunter_1998 import Hunter1998
from myostrain.activation.nash_panfilov_2004 import NashPanfilov2004
from myostrain.activation.nodal_activation import NodalActivation
from myostrain.activation.orthotropic import Orthotropic
from myostrain.activation.proportional import Proportional
from myostrain.activation.relaxing import Relaxing
from myostrain.activation.rossi_2014 import Rossi2014
from myostrain.activation.timed import Timed
from myostrain.activation.transversely_isotropic import TransverselyIsotropic

__all__ = [
    "ActivationLaw",
    "ActiveDeformation",
    "ActiveStress",
    "ActiveTension",
    "Bestel2001",
    "Fibre",
    "FibreTension",
    "GoektepeKuhl2010",
    "Hunter1998",
    "LawWithStates",
    "NashPanfilov2004",
    "NodalActivation",
    "Orthotropic",
    "Proportional",
    "Relaxing",
    "Rossi2014",
    "Timed",
    "TransverselyIsotropic",
    "Yield",
]
