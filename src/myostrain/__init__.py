"""myostrain: cardiac electromechanics by active strain.

The public names. What describes is frozen and validated, what solves owns its state, and one
:class:`Simulation` runs the coupled problem::

    import myostrain as ms

    body = ms.build(ms.geometry.Ellipse(size=(130.0, 180.0)), ms.UniformFibres(direction=(1.0, -1.0)))
"""

from myostrain import activation, geometry, kinematics, materials, membranes, theory
from myostrain import engine as _engine  # first: it orders the imports of MPI and DOLFINx
from myostrain.case import Case, run_case
from myostrain.coupling import Electromechanics, Implicit, SecondOrder, Staggered
from myostrain.electrics import BoundaryBump, Bump, Drive, GivenPotential, Potential
from myostrain.errors import ComputationError, InputError, MyostrainError
from myostrain.geometry import UniformFibres, build
from myostrain.mechanics import ImposedStretch, Mechanics
from myostrain.run import Simulation

__version__ = _engine.versions()["myostrain"]

__all__ = [
    "BoundaryBump",
    "Bump",
    "Case",
    "ComputationError",
    "Drive",
    "Electromechanics",
    "GivenPotential",
    "Implicit",
    "ImposedStretch",
    "InputError",
    "Mechanics",
    "MyostrainError",
    "Potential",
    "SecondOrder",
    "Simulation",
    "Staggered",
    "UniformFibres",
    "activation",
    "build",
    "geometry",
    "kinematics",
    "materials",
    "membranes",
    "run_case",
    "theory",
]
