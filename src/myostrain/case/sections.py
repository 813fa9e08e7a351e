"""What a case file may say: its sections, the words that choose classes, and keys that belong to none."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from myostrain import activation, circulation, geometry, kinematics, materials, membranes
from myostrain.course import Course
from myostrain.electrics.diffusion import Mass
from myostrain.electrics.front import Current
from myostrain.electrics.potential import Balance
from myostrain.errors import InputError
from myostrain.mechanics.imposed_stretch import ImposedStretch
from myostrain.mechanics.loads import PressureCourse, VectorCourse
from myostrain.mechanics.support_factors import SupportProfile
from myostrain.mechanics.supports import Normals
from myostrain.membranes.reaction import default_integrator
from myostrain.output.nodal_values import FieldName
from myostrain.output.tips import Tip
from myostrain.run.simulation import CHECKPOINT_SECONDS
from myostrain.schemes import Implicit, SecondOrder, Staggered
from myostrain.validation import Count, Finite, Flag, Level, NonNegative, Positive, Share, description

from pydantic import Field

#: More than nothing, less than all.
Percentage = Annotated[float, Field(gt=0, lt=100, strict=True)]

GEOMETRIES = {
    "line": geometry.Line,
    "rectangle": geometry.Rectangle,
    "ellipse": geometry.Ellipse,
    "slab": geometry.Slab,
    "ventricle": geometry.Ventricle,
    "biventricle": geometry.Biventricle,
    "file": geometry.MeshFile,
    "xdmf": geometry.XdmfFile,
}
FIBRES = {
    "uniform": geometry.UniformFibres,
    "ellipsoidal": geometry.EllipsoidalFibres,
    "rule-based": geometry.RuleBasedFibres,
    "file": geometry.FileFibres,
}


@description
class Rigid:
    """A body that does not move: no mechanics is made, and its keys and sections are left out."""


KINEMATICS = {
    "line": kinematics.Line,
    "plane-stress": kinematics.PlaneStress,
    "plane-strain": kinematics.PlaneStrain,
    "solid": kinematics.Solid,
    "rigid": Rigid,
}


def _exported(module: Any, method: str) -> dict[str, Any]:
    """The descriptions that a folder exports and that have this method, by name."""
    classes = {name: getattr(module, name) for name in module.__all__}
    return {name: c for name, c in classes.items() if dataclasses.is_dataclass(c) and hasattr(c, method)}


def _lower(classes: Mapping[str, Any]) -> dict[str, Any]:
    """Classes by their names in lower case, words and years joined by "-"."""
    return {re.sub(r"(?<=[a-z])(?=[A-Z0-9])", "-", name).lower(): cls for name, cls in classes.items()}


#: Laws that yield an active strain, or a tension.
LAWS = _lower(_exported(activation, "activation"))
DEFORMATIONS = _lower(_exported(activation, "tensor"))
CELLS = {
    ("file" if cls is membranes.FileMembrane else name): cls
    for name, cls in _exported(membranes, "current").items()
}
MATERIALS = _exported(materials, "energy")
CIRCULATIONS = {
    "pressure": circulation.PrescribedPressure,
    "volume": circulation.PrescribedVolume,
    "isovolumetric": circulation.Isovolumetric,
    "windkessel": circulation.Windkessel,
    "closed-loop": circulation.ClosedLoop,
}
SCHEMES = {"implicit": Implicit, "staggered": Staggered, "second-order": SecondOrder}


@description
class CellSection:
    """[cell] but for the model and its parameters.

    Args:
        integrator: How the states advance; unless given, "generalized-rush-larsen" for a model with gates,
            "linearly-implicit" for one without.
        substeps: Steps of the membrane in each step of the potential, for the exponential integrators.
        initial: Result folder of `myostrain cell` with the same model: the body starts where the cell ended.
    """

    integrator: Literal["linearly-implicit", "rush-larsen", "generalized-rush-larsen"] | None = None
    substeps: Count = 1
    initial: Path | None = None

    def integrates(self, membrane: Any) -> Any:
        """The integrator of a membrane.

        Raises:
            InputError: Substeps of one that has none.
        """
        made: Any = {
            None: default_integrator(membrane),
            "linearly-implicit": membranes.LinearlyImplicit(),
            "rush-larsen": membranes.RushLarsen(substeps=self.substeps),
            "generalized-rush-larsen": membranes.GeneralizedRushLarsen(substeps=self.substeps),
        }[self.integrator]
        if self.substeps > 1:
            if not hasattr(made, "substeps"):
                raise InputError(
                    'the linearly implicit integrator has none: leave it out, or integrator = "rush-larsen" '
                    'or "generalized-rush-larsen"',
                    "cell.substeps",
                )
            made = dataclasses.replace(made, substeps=self.substeps)
        return made


@description
class PotentialSection:
    """[potential]: diffusivity, one number or [along, across] the fibre; balance; mesh.

    Args:
        refinement: How often each cell of the mesh is divided into 2, 4 or 8 of half the size, for the
            potential and all that lives at its nodes; mechanics keeps the mesh itself. 0: one mesh for both.
    """

    diffusivity: Positive | tuple[Positive, Positive] = 100.0
    balance: Balance = "conservative"
    mass: Mass = "lumped"
    reaction: Current = "nodal"
    refinement: Level = 0


@description
class TransmuralSection:
    """[activation] but for the law and the deformation.

    Args:
        transmural: Factors on γ, or on the active tension, at the endocardium and at the epicardium; between
            them they are linear in the depth that is the harmonic function of the wall.
        transmural_between: The parts of the boundary that take the place of endocardium and epicardium.
    """

    transmural: tuple[NonNegative, NonNegative] | None = None
    transmural_between: tuple[str, str] | None = None

    def __post_init__(self) -> None:
        """Refuse sides of a wall through which nothing varies."""
        if self.transmural is None and self.transmural_between is not None:
            raise InputError("this has no effect without transmural", "activation.transmural_between")


@description
class MechanicsSection:
    """[mechanics] but for the kinematics and its constraint, and ``every``, which is the scheme's.

    Args:
        normals: Normals of ``robin_normal`` and ``damping_normal``: "smooth", of the surface that the facets
            stand for, or "facets", their own, which hold a body that slides wherever facets meet.
        support_factor: Factor on all springs and dampers of a part, by its name, where they vary within it
            along a direction; linear between the nodes of the mesh.
        ellipticity: "warn": sample the acoustic tensor of a solid at the written frames, and warn once where
            the energy is no longer strongly elliptic; "off": do not.
    """

    robin: NonNegative | Mapping[str, NonNegative] = 0.0
    robin_boundary: tuple[str, ...] | None = None
    robin_normal: Mapping[str, NonNegative] | None = None
    damping: Mapping[str, NonNegative] | None = None
    damping_normal: Mapping[str, NonNegative] | None = None
    normals: Normals = "smooth"
    support_factor: Mapping[str, SupportProfile] | None = None
    pressure: Mapping[str, PressureCourse] | None = None
    traction: Mapping[str, VectorCourse] | None = None
    displacement: Mapping[str, Mapping[Literal["x", "y", "z"], Course]] | None = None
    fixed: tuple[str, ...] = ()
    sliding: tuple[str, ...] = ()
    relaxation_time: NonNegative = 0.0
    viscosity: NonNegative = 0.0
    density: NonNegative = 0.0
    spectral_radius: Share = 2 / 3
    imposed_stretch: ImposedStretch | None = None
    tolerance: Positive = 1e-7
    ellipticity: Literal["off", "warn"] = "off"


@description
class CirculationSection:
    """[circulation]: what cavities of a solid are connected to; their pressures are then unknowns.

    Args:
        cavity: The part of the boundary that is the wall of the cavity, or a list of them.
        preload: Pressure in the cavity at the beginning: one, or one for each cavity; unless given, that of
            the atrium where there is one, else zero. The body begins in equilibrium with it. If volume or
            pressure are given, there is no preload.
        beats: Number of beats, of equal length, in the run; stroke volume and the like are of the last beat.
        unload: Whether the geometry is that under the preload, as an image at end-diastole shows it: the
            unloaded reference is found first. Its nodes are those of the results; fibres are carried back.
    """

    cavity: str | tuple[str, ...] = "endocardium"
    preload: NonNegative | tuple[NonNegative, ...] | None = None
    beats: Count = 1
    unload: bool = False


@description
class TimeSection:
    """[time] but for the scheme: time step and end."""

    step: Positive
    end: Positive


@description
class OutputSection:
    """[output]: what is written and when.

    Args:
        every: Simulated time between written fields; a sixtieth of the run unless given.
        fields: Which fields to write, at the nodes; "activation" is γ or the tension, "stretch" that of the
            fibre, "stress" the Cauchy stress, `stress_xx`, `stress_xy`, ...; "F" and "E" likewise. Of a
            quadratic displacement the middles of the edges are kept too.
        repolarization: Percentages of repolarisation at which the end of each beat is taken at every node and
            probe: a number such as 90, for APD90, or several.
        tip: Definition of the tip of a spiral wave on a sheet; its trajectory is written into `tip.csv`.
        septum: Direction from the long axis of a left ventricle, alone or one of two, to the middle of its
            septum: strains, stretch and stress are then measured in its 17 segments.
        rigid_twin: Whether the same case is run on the rigid body too, for comparison.
        checkpoint_every: Simulated time between checkpoints; none by simulated time unless given.
        checkpoint_seconds: Seconds of wall clock between checkpoints.
    """

    every: Positive | None = None
    fields: tuple[FieldName, ...] = ("potential", "states", "displacement", "stress_trace")
    repolarization: Percentage | tuple[Percentage, ...] = (90.0,)
    tip: Tip | None = None
    septum: tuple[Finite, Finite, Finite] | None = None
    rigid_twin: Flag = False
    checkpoint_every: Positive | None = None
    checkpoint_seconds: Positive = CHECKPOINT_SECONDS


@description
class UnitsSection:
    """[units]: the units of the case's numbers, for the record and for the labels of figures.

    Nothing is converted: the numbers must be consistent with each other.

    Args:
        length: Such as "mm".
        time: Such as "ms".
        stress: Such as "kPa".
        potential: Such as "mV".
    """

    length: str | None = None
    time: str | None = None
    stress: str | None = None
    potential: str | None = None


#: Classes whose fields are keys of a section.
CLASSES: dict[str, tuple[Any, ...]] = {
    "geometry": tuple(GEOMETRIES.values()),
    "fibres": tuple(FIBRES.values()),
    "cell": (*CELLS.values(), CellSection),
    "potential": (PotentialSection,),
    "activation": (*LAWS.values(), *DEFORMATIONS.values(), TransmuralSection),
    "material": tuple(MATERIALS.values()),
    "mechanics": (MechanicsSection, *KINEMATICS.values()),
    "time": (TimeSection, *SCHEMES.values()),
    "output": (OutputSection,),
    "units": (UnitsSection,),
}

#: Sections of a case file, and whether they must be there.
SECTIONS = {
    "units": False,
    "geometry": True,
    "fibres": False,
    "cell": False,
    "potential": False,
    "initial": False,  # or [[stimulus]], or [drive]
    "stimulus": False,
    "drive": False,
    "activation": False,
    "material": False,
    "mechanics": True,
    "circulation": False,
    "time": True,
    "probes": False,
    "electrodes": False,
    "output": False,
    "solver": False,
}
TEXTS = ("name", "title", "cost")
#: Sections of which there may be several: [[initial]], [[stimulus]].
LISTS = ("initial", "stimulus")
