"""myostrain: cardiac electromechanics by active strain.

The public names. What describes is frozen and validated, what solves owns its state, and one
:class:`Simulation` runs the coupled problem::

    import myostrain as ms

    body = ms.build(ms.geometry.Ellipse(size=(130.0, 180.0)), ms.UniformFibres(direction=(1.0, -1.0)))

Nothing is loaded before it is used: DOLFINx and MPI start with the first name that needs them.
"""

import importlib
import sys
from typing import TYPE_CHECKING, Any

import myostrain_engine_first  # noqa: F401 - DOLFINx may be imported before or after

if TYPE_CHECKING:
    from myostrain import activation, circulation, geometry, kinematics, materials, membranes, theory
    from myostrain.case.case import Case
    from myostrain.case.running import run_case
    from myostrain.conduction import cable
    from myostrain.coupling import Electromechanics
    from myostrain.electrics import (
        Drive,
        GivenPotential,
        InitialValues,
        Place,
        Potential,
        Stimulus,
        StretchCurrent,
        Variation,
    )
    from myostrain.errors import ComputationError, InputError, MyostrainError
    from myostrain.geometry import FunctionFibres, UniformFibres, build
    from myostrain.mechanics import (
        Cavities,
        ImposedStretch,
        Loads,
        Mechanics,
        SupportProfile,
        Supports,
        unloaded,
    )
    from myostrain.output.comparing import Comparison, compare
    from myostrain.output.opening import Results, open  # noqa: A004
    from myostrain.output.tips import Tip
    from myostrain.run.schedule import Callback
    from myostrain.run.simulation import Simulation
    from myostrain.schemes import Implicit, SecondOrder, Staggered
    from myostrain.single_cell import cell
    from myostrain.sweeping import Sweep, sweep
    from myostrain.transfer import NestedMesh

    __version__: str

__all__ = [
    "Callback",
    "Case",
    "Cavities",
    "Comparison",
    "ComputationError",
    "Drive",
    "Electromechanics",
    "FunctionFibres",
    "GivenPotential",
    "Implicit",
    "ImposedStretch",
    "InitialValues",
    "InputError",
    "Loads",
    "Mechanics",
    "MyostrainError",
    "NestedMesh",
    "Place",
    "Potential",
    "Results",
    "SecondOrder",
    "Simulation",
    "Staggered",
    "Stimulus",
    "StretchCurrent",
    "SupportProfile",
    "Supports",
    "Sweep",
    "Tip",
    "UniformFibres",
    "Variation",
    "activation",
    "build",
    "cable",
    "cell",
    "circulation",
    "compare",
    "geometry",
    "kinematics",
    "materials",
    "membranes",
    "open",
    "run_case",
    "sweep",
    "theory",
    "unloaded",
]

#: Where the public names are; the modules among them are not listed.
_MODULES = {
    "case.case": ("Case",),
    "case.running": ("run_case",),
    "conduction": ("cable",),
    "coupling": ("Electromechanics",),
    "electrics": (
        "Drive",
        "GivenPotential",
        "InitialValues",
        "Place",
        "Potential",
        "Stimulus",
        "StretchCurrent",
        "Variation",
    ),
    "errors": ("ComputationError", "InputError", "MyostrainError"),
    "geometry": ("FunctionFibres", "UniformFibres", "build"),
    "mechanics": (
        "Cavities",
        "ImposedStretch",
        "Loads",
        "Mechanics",
        "SupportProfile",
        "Supports",
        "unloaded",
    ),
    "output.comparing": ("Comparison", "compare"),
    "output.opening": ("Results", "open"),
    "output.tips": ("Tip",),
    "run.schedule": ("Callback",),
    "run.simulation": ("Simulation",),
    "schemes": ("Implicit", "SecondOrder", "Staggered"),
    "single_cell": ("cell",),
    "sweeping": ("Sweep", "sweep"),
    "transfer": ("NestedMesh",),
}
_WHERE = {name: module for module, names in _MODULES.items() for name in names}

#: Names of earlier versions, and what took their place.
_OLD = {
    "cells": "ms.cells is now ms.membranes",
    "Bump": "ms.Bump is now ms.InitialValues(where=ms.Place(center=..., radius=...), potential=...), "
    "given to ms.Potential(initial=[...])",
    "BoundaryBump": "ms.BoundaryBump is now ms.InitialValues(where=ms.Place(boundary=[...]), potential=...), "
    "given to ms.Potential(initial=[...])",
}


def __getattr__(name: str) -> Any:
    if name in _OLD:
        raise AttributeError(_OLD[name])
    if name == "__version__":
        from importlib import metadata

        try:
            value: Any = metadata.version("myostrain")
        except metadata.PackageNotFoundError:
            value = "unknown"
    elif name in _WHERE:
        value = getattr(importlib.import_module(f"myostrain.{_WHERE[name]}"), name)
    elif name in __all__:
        value = importlib.import_module(f"myostrain.{name}")
    else:
        raise AttributeError(  # with both, Python names the nearest
            f"module 'myostrain' has no attribute '{name}'", name=name, obj=sys.modules[__name__]
        )
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})
