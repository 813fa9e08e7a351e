"""Closed forms the model can be judged against: no mesh, no solver, only NumPy."""

from myostrain.theory.ellipticity import (
    critical_slope,
    kinking_stretch,
    least_with_strain,
    least_with_tension,
    line_answer,
)
from myostrain.theory.fronts import profile, spatial_coordinate, speed, steepness
from myostrain.theory.solids import active_stretches, free_stretches, uniaxial_stress
from myostrain.theory.springs import active_strain_force, active_stress_force, equivalent_active_force
from myostrain.theory.startup import diffusion_loss, grows, reaction_power, sufficient_stretch
from myostrain.theory.stretch_current import least_drive, least_drive_of_a_cubic

__all__ = [
    "active_strain_force",
    "active_stress_force",
    "active_stretches",
    "critical_slope",
    "diffusion_loss",
    "equivalent_active_force",
    "free_stretches",
    "grows",
    "kinking_stretch",
    "least_drive",
    "least_drive_of_a_cubic",
    "least_with_strain",
    "least_with_tension",
    "line_answer",
    "profile",
    "reaction_power",
    "spatial_coordinate",
    "speed",
    "steepness",
    "sufficient_stretch",
    "uniaxial_stress",
]
