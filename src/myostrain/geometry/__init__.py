"""Reference bodies: mesh, named boundaries, fibres; one kind of geometry a file.

A geometry is a frozen description with ``mesh(comm)``, which gives a :class:`Meshed`; :func:`build` joins it
with fibres into a :class:`Body`, on which solvers are made.
"""

from myostrain.geometry.body import Body, build
from myostrain.geometry.ellipse import Ellipse
from myostrain.geometry.fibres import Fibres, Microstructure, UniformFibres
from myostrain.geometry.file import MeshFile
from myostrain.geometry.gmsh_model import readable
from myostrain.geometry.line import Line
from myostrain.geometry.meshed import Meshed
from myostrain.geometry.rectangle import Rectangle
from myostrain.geometry.slab import Slab

__all__ = [
    "Body",
    "Ellipse",
    "Fibres",
    "Line",
    "MeshFile",
    "Meshed",
    "Microstructure",
    "Rectangle",
    "Slab",
    "UniformFibres",
    "build",
    "readable",
]
