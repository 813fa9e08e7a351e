"""Equilibrium of the active body: its energy, loads, supports, and the checks of what is given and found."""

from myostrain.mechanics.bestel_2001_pressure import Bestel2001Pressure
from myostrain.mechanics.cavities import Cavities
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.mechanics.imposed_stretch import ImposedStretch
from myostrain.mechanics.loads import Loads
from myostrain.mechanics.support_factors import SupportProfile
from myostrain.mechanics.supports import Supports
from myostrain.mechanics.unloading import unloaded

__all__ = [
    "Bestel2001Pressure",
    "Cavities",
    "ImposedStretch",
    "Loads",
    "Mechanics",
    "SupportProfile",
    "Supports",
    "unloaded",
]
