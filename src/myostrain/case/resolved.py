"""A case, checked, as nested dictionaries with everything resolved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.activation import FibreTension
from myostrain.case.parsing import plain, word
from myostrain.case.sections import (
    CELLS,
    CIRCULATIONS,
    DEFORMATIONS,
    FIBRES,
    GEOMETRIES,
    KINEMATICS,
    LAWS,
    MATERIALS,
    SCHEMES,
    Rigid,
)
from myostrain.mechanics import Cavities


def _placed(things: Sequence[Any]) -> Any:
    """Tables of things in places; one table for one thing."""
    tables = _tables(things)
    return tables[0] if len(tables) == 1 else tables


def _tables(things: Sequence[Any]) -> list[dict[str, Any]]:
    tables = [{**(plain(thing.where) or {}), **plain(thing)} for thing in things]
    return [{k: v for k, v in table.items() if k != "where" and v != {}} for table in tables]


def resolved(texts: Mapping[str, str], made: Mapping[str, Any]) -> dict[str, Any]:
    """The case as nested dictionaries with everything resolved."""
    kin, scheme = plain(made["kinematics"]), plain(made["scheme"])
    pace = {"every": scheme.pop("every")} if "every" in scheme else {}
    moving = _moving(made, kin, pace) if not isinstance(made["kinematics"], Rigid) else {}
    fibres, solved = made["fibres"], made["drive"] is None
    sections = {
        "units": plain(made["units"]),
        "geometry": {"kind": word(made["geometry"], GEOMETRIES), **plain(made["geometry"])},
        "fibres": {"kind": word(fibres, FIBRES), **plain(fibres)} if fibres is not None else None,
        "cell": _cell(made) if solved else None,
        "potential": plain(made["potential"]) if solved else None,
        "initial": _placed(made["initial"]),
        "stimulus": _placed(made["stimuli"]),
        "drive": plain(made["drive"]),
        "activation": moving.get("activation"),
        "material": moving.get("material"),
        "mechanics": {"kinematics": word(made["kinematics"], KINEMATICS), **moving.get("mechanics", {})},
        "circulation": _circulation(made["cavities"], made["unload"]),
        "time": {**plain(made["time"]), "scheme": word(made["scheme"], SCHEMES), **scheme},
        "probes": plain(made["probes"]),
        "electrodes": plain(made["electrodes"]),
        "output": plain(made["output"]),
        "solver": plain(made["solver"]),
    }
    return {**texts, **{name: section for name, section in sections.items() if section}}


def _cell(made: Mapping[str, Any]) -> dict[str, Any]:
    """The section of the membrane."""
    lists = {"stretch_current": _placed(made["stretch_currents"]), "variation": _tables(made["variations"])}
    cell = {"model": word(made["cell"], CELLS), **plain(made["cell"]), **plain(made["beginning"])}
    return {**cell, **{name: tables for name, tables in lists.items() if tables}}


def _moving(made: Mapping[str, Any], kin: Mapping[str, Any], pace: Mapping[str, Any]) -> dict[str, Any]:
    """The sections of a body that moves."""
    activity = {"law": word(made["law"], LAWS), **plain(made["law"]), **plain(made["active"])}
    if not isinstance(made["active"], FibreTension):
        activity["deformation"] = word(made["active"], DEFORMATIONS)
    return {
        "activation": {**activity, **plain(made["transmural"])},
        "material": {"model": word(made["material"], MATERIALS), **plain(made["material"])},
        "mechanics": {**kin, **plain(made["mechanics"]), **pace},
    }


def _circulation(cavities: Cavities | None, unload: bool) -> dict[str, Any]:
    """What the cavities are connected to; nothing where there are none."""
    if cavities is None:
        return {}
    section = {"kind": word(cavities.circulation, CIRCULATIONS), "cavity": list(cavities.names)}
    parameters = {k: v for k, v in plain(cavities.circulation).items() if k != "cavities"}
    preload = {} if cavities.preload is None else {"preload": plain(cavities.preload)}
    return {**section, **parameters, **preload, "beats": cavities.beats, "unload": unload}
