"""What a file says of a cell, whatever its language."""

from __future__ import annotations

from dataclasses import dataclass, field

from myostrain.membranes.files.formulas import Formula


class Unreadable(Exception):
    """A file that cannot be read; the message says why, without the file's name."""


@dataclass(frozen=True)
class Contents:
    """What a file says of a cell.

    Attributes:
        parameters: Numbers that may be changed, by name.
        states: Initial value of each state, by name.
        rates: Formula of each state's time derivative.
        formulas: Formulas of the other variables.
        time: Names of the time.
        units: Units of variables, as the file has them, where it says them.
        time_unit: Unit of time, where it says it.
        roles: Variables that the file itself says to be "potential", "calcium" or "stimulus".
    """

    parameters: dict[str, float]
    states: dict[str, float]
    rates: dict[str, Formula]
    formulas: dict[str, Formula]
    time: tuple[str, ...]
    units: dict[str, str] = field(default_factory=dict)
    time_unit: str | None = None
    roles: dict[str, str] = field(default_factory=dict)


#: Spellings of units.
SPELLINGS = {
    "millisecond": "ms",
    "milliseconds": "ms",
    "second": "s",
    "seconds": "s",
    "millivolt": "mV",
    "millivolts": "mV",
    "volt": "V",
    "volts": "V",
    "uM": "μM",
    "umol/L": "μM",
    "micromolar": "μM",
    "millimolar": "mM",
    "mmol/L": "mM",
    "dimensionless": "",
    "1": "",
}


def spelt(unit: str | None) -> str | None:
    """A unit as it is written here; None for none."""
    unit = (unit or "").strip().strip("[]").strip()
    return SPELLINGS.get(unit, unit) or None
