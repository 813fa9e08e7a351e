"""In which units a run's numbers are: what its membrane declares and what its case or script says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.errors import InputError, nearest, shown

#: What may have a unit.
QUANTITIES = ("length", "time", "stress", "potential")
#: A range of a potential in mV is wider than this.
MILLIVOLTS = 10.0


def units_of(membrane: Any, given: Mapping[str, Any]) -> dict[str, str]:
    """Units by quantity; what has none is left out.

    Args:
        membrane: The membrane; None where the potential is given.
        given: What the case or the script says.

    Raises:
        InputError: They contradict what the membrane declares, or are of no known quantity.
    """
    for name, unit in given.items():
        if name not in QUANTITIES:
            raise InputError(f"no such quantity; {nearest(name, QUANTITIES)}", f"units.{name}")
        if not (unit is None or (isinstance(unit, str) and unit.isprintable() and 0 < len(unit) <= 30)):
            raise InputError(f'give a short text, such as "mm", not {shown(unit)}', f"units.{name}")
    found = {name: unit for name, unit in given.items() if unit is not None}
    for name in ("time", "potential"):
        declared = getattr(membrane, f"{name}_unit", None)
        if declared is None:
            if name == "potential" and membrane is not None and found.get(name) == "mV":
                _refuse_millivolts(membrane)
            continue
        if found.setdefault(name, declared) != declared:
            raise InputError(
                f"{type(membrane).__name__} counts the {name} in {declared}, not {found[name]}; nothing is "
                f'converted: give "{declared}", and all numbers of the case in it',
                f"units.{name}",
            )
    return found


def _refuse_millivolts(membrane: Any) -> None:
    """Refuse mV for a potential that goes from 0 to 1 or so.

    Raises:
        InputError: It does.
    """
    low, high = getattr(membrane, "range", (0.0, 1.0))
    if high - low < MILLIVOLTS:
        raise InputError(
            f"the potential of {type(membrane).__name__} has no unit, it lies between {low:g} and {high:g}; "
            "nothing is converted: leave it out",
            "units.potential",
        )


def about(potential: Any, title: str, units: Mapping[str, str]) -> dict[str, Any]:
    """What pictures have to know of a run.

    Args:
        potential: The potential, solved for or given.
        title: Of the run.
        units: What the case or the script says.

    Raises:
        InputError: The units contradict what the membrane declares, or are of no known quantity.
    """
    return {
        "title": title,
        "range": potential.range,
        "threshold": potential.threshold,
        "rest": resting_potential(potential),
        "units": units_of(getattr(potential, "membrane", None), units),
    }


def resting_potential(potential: Any) -> float:
    """The potential at rest: the membrane's, zero where the potential is given."""
    membrane = getattr(potential, "membrane", None)
    return 0.0 if membrane is None else float(membrane.resting_potential())
