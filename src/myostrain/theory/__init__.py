"""Closed forms the model can be judged against: no mesh, no solver, only NumPy."""

from myostrain.theory.fronts import profile, spatial_coordinate, speed, steepness

__all__ = ["profile", "spatial_coordinate", "speed", "steepness"]
