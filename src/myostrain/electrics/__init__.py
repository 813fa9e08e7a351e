"""The potential on the deforming body: its balance, initial values, and a potential that is given."""

from myostrain.electrics.given_potential import Drive, GivenPotential
from myostrain.electrics.initial_values import BoundaryBump, Bump
from myostrain.electrics.potential import Potential

__all__ = ["BoundaryBump", "Bump", "Drive", "GivenPotential", "Potential"]
