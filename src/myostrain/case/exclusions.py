"""Sections and keys of a case that exclude each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.errors import InputError, dotted


def check_drive(data: Mapping[str, Any]) -> None:
    """Refuse a case that solves for its potential and is given it, or neither.

    Raises:
        InputError: It is one.
    """
    if "drive" not in data:
        if not data.get("initial") and not data.get("stimulus"):
            raise InputError(
                "this section is missing: nothing excites the body; give [initial], [[stimulus]], or [drive] "
                "for a potential that is given in time",
                "initial",
            )
        return
    for section in ("cell", "potential", "initial", "stimulus"):
        if section in data:
            raise InputError("with [drive] the potential is given: leave this section out", section)
    if isinstance(data.get("solver"), Mapping) and "potential" in data["solver"]:
        raise InputError("with [drive] nothing is solved for the potential: leave it out", "solver.potential")


def check_rigid(data: Mapping[str, Any]) -> None:
    """Refuse what a rigid body has no use for.

    Raises:
        InputError: It is there.
    """
    unused = [
        (section, "") for section in ("activation", "material", "drive", "circulation") if section in data
    ]
    unused += [("mechanics", key) for key in data["mechanics"] if key != "kinematics"]
    if isinstance(data.get("solver"), Mapping) and "mechanics" in data["solver"]:
        unused.append(("solver", "mechanics"))
    if isinstance(data.get("output"), Mapping) and data["output"].get("rigid_twin"):
        unused.append(("output", "rigid_twin"))
    for section, key in unused:
        raise InputError(
            f"a rigid body has no use for this {'key' if key else 'section'}: leave it out",
            dotted(section, key) if key else section,
        )
