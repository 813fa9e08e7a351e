"""What mechanics is made of, checked by kind, and keywords of earlier versions."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from myostrain import activation, kinematics, materials
from myostrain.errors import InputError, shown
from myostrain.geometry import Body
from myostrain.mechanics.imposed_stretch import ImposedStretch
from myostrain.mechanics.loads import Loads
from myostrain.mechanics.supports import Supports
from myostrain.validation import NonNegative, Positive, Share, checked, shown_in_notebook

_SUPPORT, _LOAD = "give supports=Supports({0}=...)", "give loads=Loads({0}=...)"

#: Keywords of earlier versions, and what took their place.
FORMER = {
    "law": "it goes to Electromechanics(..., law=...), which writes the nodal field activation",
    "deformation": "it is called active",
    "active_stress": "give Electromechanics law=ActiveStress(...), and Mechanics active=FibreTension(...)",
    "activity": "it goes to Electromechanics(..., activity=...), as values at the nodes",
    "activity_max": "it is not needed; activity goes to Electromechanics",
    **{
        name: _SUPPORT.format(name)
        for name in ("fixed", "sliding", "robin", "robin_boundary", "robin_normal", "damping", "normals")
    },
    **{name: _LOAD.format(name) for name in ("pressure", "body_force")},
}


class InNotebook:
    """How mechanics is shown in a notebook."""

    def _repr_html_(self) -> str:
        me: Any = self
        rows = {
            "body": repr(me.body),
            "kinematics": repr(me.kinematics),
            "material": repr(me.material),
            "activation": f"{me._active.name}, by a {me.yields}",
            "supports": _given(me.supports),
            "loads": _given(me.loads),
            "cavities": ", ".join(me.cavities.names),
            "unknowns": me.u.function_space.dofmap.index_map.size_global * me.u.function_space.dofmap.bs,
        }
        return shown_in_notebook("Mechanics", rows)


def _given(thing: Any) -> str:
    """What of a dataclass is not its default."""
    said = []
    for field in dataclasses.fields(thing):
        value = getattr(thing, field.name)
        if value not in (None, 0.0, (), {}) and value != field.default:
            said.append(f"{field.name} = {value}")
    return ", ".join(said)


def check_kinds(given: Mapping[str, Any]) -> None:
    """Refuse objects that are not what mechanics takes: texts, classes, dictionaries.

    Args:
        given: What was given, by keyword.

    Raises:
        InputError: It names the keyword, and what to give.
    """
    wanted: dict[str, tuple[str, Any, str]] = {
        "body": ("a body, such as build(...) makes", Body, "mesh"),
        "kinematics": (f"one of {_instances(kinematics, 'lift')}", object, "lift"),
        "material": (
            f"one of {_instances(materials, 'energy')}, or an object with energy(Fe, fibres)",
            object,
            "energy",
        ),
        "supports": ('Supports(...), such as Supports(fixed=["left"])', Supports, ""),
        "loads": ('Loads(...), such as Loads(pressure={"right": 0.1})', Loads, ""),
        "imposed_stretch": ("ImposedStretch(...), or None", ImposedStretch | None, ""),
    }
    for name, (what, kind, method) in wanted.items():
        value = given[name]
        lacks = bool(method) and not hasattr(value, method)
        if isinstance(value, type) or lacks or not isinstance(value, kind):
            own = lacks and type(value).__module__ != "builtins"
            what_it_is = f"{type(value).__name__} has no method '{method}'" if own else shown(value)
            raise InputError(f"{what_it_is}: give {what}", f"mechanics.{name}")
    active = given["active"]
    if isinstance(active, type) or not (hasattr(active, "tensor") or hasattr(active, "energy")):
        raise InputError(
            f"{shown(active)}: give an active deformation, one of {_instances(activation, 'tensor')}, or an "
            "active tension",
            "mechanics.active",
        )
    for name in ("relaxation_time", "viscosity", "density"):
        checked(NonNegative, given[name], f"mechanics.{name}")
    checked(Share, given["spectral_radius"], "mechanics.spectral_radius")
    checked(Positive, given["tolerance"], "mechanics.tolerance")


def _instances(module: Any, method: str) -> str:
    """The classes of a module that have a method and are no protocols, as a call each."""
    found = vars(module).values()
    names = [c.__name__ for c in found if isinstance(c, type) and hasattr(c, method)]
    protocols = ("Kinematics", "Material", "ActiveDeformation")
    return ", ".join(f"{name}()" for name in names if name not in protocols and not name.startswith("_"))
