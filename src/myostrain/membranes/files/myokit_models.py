"""Myokit's ``.mmt`` files, and CellML by Myokit's importer; its expressions are walked here."""

from __future__ import annotations

import io
import warnings
from typing import Any

from myostrain.membranes.files.contents import Contents, Unreadable, spelt
from myostrain.membranes.files.formulas import Formula, make, name, number

import numpy as np

#: Classes of Myokit's expressions by what they do.
CLASSES = {
    "Plus": "add",
    "Minus": "sub",
    "Multiply": "mul",
    "Divide": "div",
    "Power": "pow",
    "Quotient": "quotient",
    "Remainder": "mod",
    "PrefixMinus": "neg",
    "Sqrt": "sqrt",
    "Sin": "sin",
    "Cos": "cos",
    "Tan": "tan",
    "ASin": "arcsin",
    "ACos": "arccos",
    "ATan": "arctan",
    "Exp": "exp",
    "Log10": "log10",
    "Floor": "floor",
    "Ceil": "ceil",
    "Abs": "abs",
    "If": "where",
    "Equal": "eq",
    "NotEqual": "ne",
    "More": "gt",
    "Less": "lt",
    "MoreEqual": "ge",
    "LessEqual": "le",
    "And": "and",
    "Or": "or",
    "Not": "not",
}
#: What Myokit and the web lab's annotations call the roles.
LABELS = {"membrane_potential": "potential"}
ANNOTATIONS = {
    "membrane_voltage": "potential",
    "cytosolic_calcium_concentration": "calcium",
    "membrane_stimulus_current": "stimulus",
}


def read_mmt(text: str) -> Contents:
    """What an ``.mmt`` file says; its protocol and its script are not read.

    Raises:
        ImportError: Myokit is not there.
        Unreadable: It is not such a file.
    """
    import myokit

    try:
        model = myokit.parse(text.splitlines(keepends=True))[0]
    except myokit.MyokitError as error:
        raise Unreadable(f"Myokit cannot read it: {_line(error)}") from None
    if model is None:
        raise Unreadable("it has no [[model]]")
    return _contents(model)


def read_cellml(text: str) -> Contents:
    """What a CellML file of version 1.0, 1.1 or 2.0 says.

    Raises:
        ImportError: Myokit is not there.
        Unreadable: It is not such a file.
    """
    import myokit
    from myokit.formats.cellml import CellMLImporter

    try:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            model = CellMLImporter().model(io.BytesIO(text.encode()))
    except myokit.MyokitError as error:
        what = _line(error)
        if "not a CellML document" in what:
            what = "it is not CellML of version 1.0, 1.1 or 2.0"
        raise Unreadable(f"Myokit cannot read it: {what}") from None
    for warning in said:
        if "no initial value" in str(warning.message):  # Myokit would begin at zero
            raise Unreadable(_line(warning.message))
    return _contents(model)


def _line(error: Exception | str) -> str:
    """The message of an error or a warning in one line."""
    return " ".join(str(error).split())[:300].rstrip(". ")


def _contents(model: Any) -> Contents:
    import myokit

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model.validate()
        return _validated(model)
    except myokit.MyokitError as error:
        raise Unreadable(f"Myokit finds it wrong: {_line(error)}") from None


def _validated(model: Any) -> Contents:
    parameters, formulas, units, roles = {}, {}, {}, {}
    states = {v.qname(): float(v.initial_value(as_float=True)) for v in model.states()}
    rates = {v.qname(): _formula(v.rhs()) for v in model.states()}
    time = model.time()
    for variable in model.variables(deep=True):
        of = variable.qname()
        if unit := spelt(_unit(variable.unit())):
            units[of] = unit
        annotated = variable.meta.get("oxmeta", "")
        role = LABELS.get(variable.label() or "") or ANNOTATIONS.get(annotated)
        if role:
            roles[role] = of
        if variable.binding() == "pace":
            roles["stimulus"] = of
        if variable.is_state() or variable is time:
            continue
        if variable.is_literal() and not variable.is_bound():
            parameters[of] = float(variable.eval())
        else:
            formulas[of] = _formula(variable.rhs()) if variable.binding() != "pace" else number(0)
    for of, value in {**parameters, **states}.items():
        if not np.isfinite(value):
            raise Unreadable(f"the value of {of} is {value}")
    times = () if time is None else (time.qname(),)
    unit = None if time is None else units.get(time.qname())
    return Contents(parameters, states, rates, formulas, times, units, unit, roles)


def _unit(unit: Any) -> str | None:
    return None if unit is None else str(unit)


def _formula(expression: Any) -> Formula:
    kind = type(expression).__name__
    if kind == "Number":
        return number(float(expression.eval()))
    if kind == "Name":
        return name(expression.var().qname())
    if kind == "Derivative":
        return _formula(expression.var().rhs())
    args = [_formula(part) for part in expression]
    if kind == "PrefixPlus":
        return args[0]
    if kind == "Log":
        return make("log" if len(args) == 1 else "logarithm", *args)
    if kind == "Piecewise":
        found = args[-1]
        for at in range(len(args) - 3, -1, -2):
            found = make("where", args[at], args[at + 1], found)
        return found
    if kind not in CLASSES:
        raise Unreadable(f"the expression {kind} is not known: {expression.code()[:60]}")
    return make(CLASSES[kind], *args)
