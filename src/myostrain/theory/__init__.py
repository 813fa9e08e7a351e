"""Closed forms the model can be judged against: no mesh, no solver, only NumPy."""

from myostrain.theory.fronts import profile, spatial_coordinate, speed, steepness
from myostrain.theory.springs import active_strain_force, active_stress_force, equivalent_active_force
from myostrain.theory.startup import diffusion_loss, grows, reaction_power, sufficient_stretch

__all__ = [
    "active_strain_force",
    "active_stress_force",
    "diffusion_loss",
    "equivalent_active_force",
    "grows",
    "profile",
    "reaction_power",
    "spatial_coordinate",
    "speed",
    "steepness",
    "sufficient_stretch",
]
