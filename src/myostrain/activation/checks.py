"""Whether an object is an activation law, and whether it gives what it should."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.activation.contracts import Array, Drivers
from myostrain.activation.units import conversion
from myostrain.errors import InputError, nearest

import numpy as np
from ufl.core.expr import Expr

KEY = "activation.law"


def plain(found: Any, who: str) -> Array:
    """What a method gives, as an array of real numbers.

    Raises:
        InputError: It is none.
    """
    # NumPy would try to iterate a UFL scalar, for ever.
    if (symbolic := _symbolic(found)) is not None:
        raise InputError(
            f"{who} gives a {type(symbolic).__name__} of UFL; a law gets and gives arrays of nodal values: "
            "write it in NumPy",
            KEY,
        )
    if found is None:  # NumPy would make NaN of it
        raise InputError(f"{who} gives None: it has to end with return and the values", KEY)
    try:
        if np.iscomplexobj(found):
            raise TypeError("they are complex")
        if isinstance(found, np.ma.MaskedArray):
            found = np.ma.filled(found.astype(float), np.nan)
        return np.asarray(found, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{who} gives no array of real numbers: {error}", KEY) from None


def _symbolic(found: Any) -> Expr | None:
    """Something of UFL, if it is that or among what it holds."""
    if isinstance(found, np.ndarray) and found.dtype == object:
        found = found.reshape(-1).tolist()
    if isinstance(found, (list, tuple)):
        return next((inner for part in found if (inner := _symbolic(part)) is not None), None)
    return found if isinstance(found, Expr) else None


def unit_scales(law: Any, given: Mapping[str, str | None]) -> dict[str, float]:
    """Factors on drivers, and on time, that bring them into the units which a law declares.

    Raises:
        InputError: It declares others than can be had.
    """
    name, wanted, scales = type(law).__name__, getattr(law, "units", {}), {}
    if not isinstance(wanted, Mapping) or not all(isinstance(u, str) for u in wanted.values()):
        raise InputError(
            f'{name}.units is {wanted!r}; give units by driver, such as {{"calcium": "μM"}}', KEY
        )
    for driver, unit in wanted.items():
        if driver not in {*law.drivers, "time"}:
            raise InputError(
                f"{name}.units has '{driver}', which does not drive it; {nearest(driver, law.drivers)}", KEY
            )
        scale = conversion(given.get(driver), unit)
        if scale is None and not (driver == "time" and given.get(driver) is None):
            what = "the time" if driver == "time" else f"the {driver}"
            said = f"in '{given[driver]}'" if given.get(driver) else "without a unit"
            raise InputError(
                f"{name} takes {what} in {unit}, and this membrane has it {said}: another law or membrane",
                KEY,
            )
        scales[driver] = 1.0 if scale is None else scale
    return scales


def called(law: Any, method: str, *arguments: Any) -> Any:
    """What a law's method gives; it gets copies of arrays, so that it may write in them.

    Raises:
        InputError: It fails.
    """
    copies = [_copied(argument) for argument in arguments]
    try:
        return getattr(law, method)(*copies)
    except (
        ArithmeticError,
        AssertionError,
        AttributeError,
        LookupError,
        NameError,
        RecursionError,
        TypeError,
        ValueError,
    ) as error:
        hint = "; declare it in drivers" if isinstance(error, KeyError) else ""
        raise InputError(
            f"{type(law).__name__}.{method} failed: {type(error).__name__}: {error}{hint}", KEY
        ) from error


def _copied(argument: Any) -> Any:
    if isinstance(argument, Mapping):
        return {name: _copied(value) for name, value in argument.items()}
    return argument.copy() if isinstance(argument, np.ndarray) else argument


def initial(law: Any, names: Sequence[str], drivers: Drivers) -> Sequence[Any]:
    """The initial values of a law's states, one for each name.

    Raises:
        InputError: They are not that many.
    """
    found = called(law, "initial_states", drivers)
    who, wanted = f"{type(law).__name__}.initial_states", f"give one for each of the states {list(names)}"
    try:
        count = 0 if isinstance(found, (str, Mapping)) else len(found)
    except (NotImplementedError, TypeError, ValueError):  # UFL has the first
        count = 0
    if count == 0:
        raise InputError(f"{who} gives {found!r}; {wanted}, such as return (0.0,)", KEY)
    if count != len(names):
        raise InputError(f"{who} gives {count} values; {wanted}", KEY)
    values: Sequence[Any] = found
    return values


def check_law(law: Any, known: Mapping[str, Any], wanted: str) -> None:
    """Refuse what is not a law, or not one for these drivers and what the mechanics takes.

    Raises:
        InputError: What is missing, or wrong.
    """
    name = type(law).__name__ if not isinstance(law, type) else f"the class {law.__name__}"
    if isinstance(law, type):
        raise InputError(f"{name} is not an object: give {law.__name__}()", KEY)
    if not callable(getattr(law, "activation", None)):
        hint = (
            "; `gamma(v)` of earlier versions is now `activation(states, drivers)`, on arrays: return the "
            'same of drivers["potential"]'
            if hasattr(law, "gamma")
            else ""
        )
        raise InputError(
            f"{name} is not an activation law: it has no method activation(states, drivers){hint}", KEY
        )
    drivers: Any = getattr(law, "drivers", None)
    states: Any = getattr(law, "states", ())
    for what, names in (("drivers", drivers), ("states", states)):
        texts = not isinstance(names, str) and isinstance(names, (tuple, list))
        if not texts or not all(isinstance(n, str) for n in names):
            raise InputError(f'{name}.{what} is {names!r}; give names, such as ("potential",)', KEY)
        if len(set(names)) != len(names):
            raise InputError(f"{name}.{what} has a name twice: {list(names)}", KEY)
    for driver in drivers:
        if driver not in known:
            raise InputError(f"'{driver}' drives {name}, and nothing gives it; {nearest(driver, known)}", KEY)
    if not states and callable(getattr(law, "advance", None)):
        raise InputError(f'{name} has a method advance, but no states: name them, states = ("gamma",)', KEY)
    if states:
        for method in ("initial_states", "advance"):
            if not callable(getattr(law, method, None)):
                raise InputError(f"{name} has states, but no method {method}", KEY)
    yields = getattr(law, "yields", "strain")
    if yields not in ("strain", "tension"):
        raise InputError(f'{name}.yields is {yields!r}; give "strain" or "tension"', KEY)
    if yields != wanted:
        raise InputError(
            f"{name} yields a {yields}, and the mechanics takes a {wanted}: give Mechanics(active=...) a "
            "deformation such as Fibre() for a strain, FibreTension() for a tension",
            KEY,
        )
