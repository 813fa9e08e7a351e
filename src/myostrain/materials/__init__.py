"""Passive materials: one energy a file.

A material is a frozen dataclass with ``energy(Fe, fibres)``: the stored energy W per volume of the
intermediate configuration as a UFL scalar (1.3), and ``tensor_dim``, the dimension of the Fe that it takes (1
for a line, else 3). ``fibres`` has the unit directions ``f0``, ``s0`` and ``n0``, UFL vectors of that
dimension (``s0`` and ``n0`` are None where a solid's fibres come without sheets). Stress and tangent follow
by differentiation; nothing else is written, but for ``modulus``, the stiffness at rest, where the material is
to be viscous. In a nearly incompressible body Fe is without change of volume, unless the material has
``sees_volume = True`` and itself says what sees it.
"""

from typing import Any, ClassVar, Protocol

from myostrain.materials.arostica_2025 import Arostica2025
from myostrain.materials.guccione_1995 import Guccione1995
from myostrain.materials.holzapfel_ogden_2009 import HolzapfelOgden2009
from myostrain.materials.mooney_rivlin import MooneyRivlin
from myostrain.materials.neo_hookean import NeoHookean
from myostrain.materials.spring import Spring
from myostrain.materials.usyk_2002 import Usyk2002


class Material(Protocol):
    """What the mechanics asks of a material."""

    tensor_dim: ClassVar[int]

    def energy(self, Fe: Any, fibres: Any) -> Any:
        """Stored energy W(Fe) per volume of the intermediate configuration, a UFL scalar."""
        ...


__all__ = [
    "Arostica2025",
    "Guccione1995",
    "HolzapfelOgden2009",
    "Material",
    "MooneyRivlin",
    "NeoHookean",
    "Spring",
    "Usyk2002",
]
