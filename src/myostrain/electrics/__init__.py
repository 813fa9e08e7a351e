"""The potential on the deforming body: its balance, what excites and varies it; one that is given."""

from myostrain.electrics.given_potential import Drive, GivenPotential
from myostrain.electrics.initial_values import InitialValues
from myostrain.electrics.place import Place
from myostrain.electrics.potential import Potential
from myostrain.electrics.stimulus import Stimulus
from myostrain.electrics.stretch_current import StretchCurrent
from myostrain.electrics.variation import Variation

__all__ = [
    "Drive",
    "GivenPotential",
    "InitialValues",
    "Place",
    "Potential",
    "Stimulus",
    "StretchCurrent",
    "Variation",
]
