"""Reference bodies: mesh, named boundaries, fibres; one kind of geometry a file.

A geometry is a frozen description with ``mesh(comm)``, which gives a :class:`Meshed`; :func:`build` joins it
with fibres into a :class:`Body`, on which solvers are made. It may say by ``counts()`` how many nodes and
cells the mesh has, about; then a case that would not fit into memory is refused before it is meshed.
"""

from myostrain.geometry.biventricle import Biventricle
from myostrain.geometry.body import Body, build
from myostrain.geometry.ellipse import Ellipse
from myostrain.geometry.ellipsoidal_fibres import EllipsoidalFibres
from myostrain.geometry.fibre_file import FileFibres
from myostrain.geometry.fibres import Fibres, Microstructure, UniformFibres
from myostrain.geometry.file import MeshFile
from myostrain.geometry.foreign import readable
from myostrain.geometry.function_fibres import FunctionFibres
from myostrain.geometry.laplace_fibres import RuleBasedFibres
from myostrain.geometry.line import Line
from myostrain.geometry.memory_model import GmshModel
from myostrain.geometry.meshed import Meshed
from myostrain.geometry.opencarp import write_opencarp
from myostrain.geometry.quality import Quality, quality
from myostrain.geometry.rectangle import Rectangle
from myostrain.geometry.refinement import RefinedBody, refined
from myostrain.geometry.slab import Slab
from myostrain.geometry.transmural import depth, transmural
from myostrain.geometry.ventricle import Ventricle
from myostrain.geometry.xdmf import XdmfFile

__all__ = [
    "Biventricle",
    "Body",
    "Ellipse",
    "EllipsoidalFibres",
    "Fibres",
    "FileFibres",
    "FunctionFibres",
    "GmshModel",
    "Line",
    "MeshFile",
    "Meshed",
    "Microstructure",
    "Quality",
    "Rectangle",
    "RefinedBody",
    "RuleBasedFibres",
    "Slab",
    "UniformFibres",
    "Ventricle",
    "XdmfFile",
    "build",
    "depth",
    "quality",
    "readable",
    "refined",
    "transmural",
    "write_opencarp",
]
