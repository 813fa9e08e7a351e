"""What the numbers of a run are called, and their units, made of those that the run declares."""

from __future__ import annotations

import re
from collections.abc import Mapping

#: Powers of the quantities that a unit is made of; "body" stands for the dimension of the body less one.
Powers = Mapping[str, int]

LENGTH, TIME, POTENTIAL, STRESS = {"length": 1}, {"time": 1}, {"potential": 1}, {"stress": 1}
SPEED, VOLUME = {"length": 1, "time": -1}, {"length": 3}
NUMBER: Powers = {}

#: By pattern of the name: the long name, in which {0}, {1} are groups, and the unit; None is unknown.
_KNOWN: tuple[tuple[str, str, Powers | None], ...] = (
    (r"time", "time", TIME),
    (r"celerity", "celerity between the first two probes", SPEED),
    (r"width_material", "width of the leading pulse in X", LENGTH),
    (r"width_spatial", "width of the leading pulse in x", LENGTH),
    (r"front_slope", "slope of the potential at the leading front", {"potential": 1, "length": -1}),
    (r"potential", "potential", POTENTIAL),
    (r"potential_max", "largest potential at the end", POTENTIAL),
    (r"potential_min", "least potential at the end", POTENTIAL),
    (r"displacement_max", "largest displacement at the end", LENGTH),
    (r"conduction_velocity", "conduction velocity", SPEED),
    (r"conduction_velocity_median", "median of the conduction velocity", SPEED),
    (r"apd([\d.]+)", "duration of the action potential at {0} % of repolarisation", TIME),
    (r"apd([\d.]+)_(\w+)", "duration of the action potential at {0} % of repolarisation, {1}", TIME),
    (r"activation_times?", "activation time", TIME),
    (r"repolarization_times_([\d.]+)", "time of {0} % of repolarisation", TIME),
    (r"tips", "number of spiral tips", NUMBER),
    (r"tips_max", "largest number of spiral tips", NUMBER),
    (r"tip_period", "period of the spiral's tip", TIME),
    (r"tip_radius", "radius of the tip's circle", LENGTH),
    (r"tip_drift", "speed of the tip's drift", SPEED),
    (r"tip_deviation", "deviation of the tip from a drifting circle", LENGTH),
    (r"volume_ratio", "volume over that at rest", NUMBER),
    (r"(\w+)_ratio", "{0} over that of the rigid body", NUMBER),
    (r"displacement", "displacement", LENGTH),
    (r"displacement_([xyz])", "displacement along {0}", LENGTH),
    (r"activation", "activation: γ, or the tension", None),
    (r"stretch", "stretch of the fibre", NUMBER),
    (r"stress_([xyz]{2})", "Cauchy stress, {0}", STRESS),
    (r"stress_trace", "trace of the Cauchy stress", STRESS),
    (r"(longitudinal|circumferential|radial)_strain", "mean {0} strain since rest", NUMBER),
    (r"(longitudinal|circumferential|radial)_strain_begin", "mean {0} strain at the beginning", NUMBER),
    (r"(longitudinal|circumferential|radial)_strain_peak", "largest {0} strain since the beginning", NUMBER),
    (r"(longitudinal|circumferential|radial)_strain_(\d+)", "{0} strain of segment {1} since rest", NUMBER),
    (r"fibre_stretch_(\d+)", "stretch of the fibre in segment {0}", NUMBER),
    (r"fibre_stress_(\d+)", "Cauchy stress along the fibre in segment {0}", STRESS),
    (r"fibre_stress_mean", "mean Cauchy stress along the fibre", STRESS),
    (r"fibre_stretch_mean", "mean stretch of the fibre", NUMBER),
    (r"fibre_stretch_min", "least stretch of the fibre", NUMBER),
    (r"fibre_shortening", "largest mean shortening of the fibre", NUMBER),
    (r"cavity_volume()", "volume of the cavity", VOLUME),
    (r"cavity_volume_(min|max)", "volume of the cavity, {0}imum", VOLUME),
    (r"(?:cavity_)?volume_(\w+)", "volume of the cavity {0}", VOLUME),
    (r"pressure_(\w+)", "pressure in the cavity, {0}", STRESS),
    (r"dpdt_(\w+)", "rate of the pressure, {0}", {"stress": 1, "time": -1}),
    (r"stroke_volume_change\w*", "change of the stroke volume since the beat before", NUMBER),
    (r"stroke_volume\w*", "stroke volume", VOLUME),
    (r"stroke_work\w*", "stroke work", {"stress": 1, "length": 3}),
    (r"ejection_fraction\w*", "ejected share of the volume", NUMBER),
    (r"wall_thickening", "thickening of the wall", NUMBER),
    (r"wall_thickening_begin", "thickening of the wall at the beginning", NUMBER),
    (r"wall_thickening_beat", "largest thickening of the wall since the beginning", NUMBER),
    (r"longitudinal_shortening", "shortening of the long axis", NUMBER),
    (r"longitudinal_shortening_begin", "shortening of the long axis at the beginning", NUMBER),
    (r"longitudinal_shortening_beat", "largest shortening of the long axis since the beginning", NUMBER),
    (r"apex_(\w+)", "height of the apex, {0}", LENGTH),
    (r"ellipticity(_min)?", "least eigenvalue of the acoustic tensor over the modulus", NUMBER),
    (r"reaction_(\w+)_([xyz])", "force by which {0} holds the body, along {1}", {"stress": 1, "body": 1}),
    (r"amount", "integral of J v over the reference body", {"potential": 1, "length": 1, "body": 1}),
    (r"[XYZxyz]", "coordinate", LENGTH),
)

#: What are angles, in degrees.
TWIST = {
    "twist": "rotation of the apex against the base",
    "twist_begin": "rotation of the apex against the base at the beginning",
    "twist_beat": "largest rotation of the apex against the base since the beginning",
}


def attributes(name: str, units: Mapping[str, str], dim: int | None) -> dict[str, str]:
    """What xarray says of a variable: "long_name", and "units" where they are known.

    Args:
        name: Name of a metric, of a measure or of a field.
        units: Units of the run by quantity; of a run that has none all is non-dimensional, "1".
        dim: Dimension of the body; None if it is not known.
    """
    if name in TWIST:
        return {"long_name": TWIST[name], "units": "degree"}
    if name == "torsion":
        return {"long_name": "shear angle of the epicardium by the twist", "units": "degree"}
    rigid = name.endswith("_rigid")
    for pattern, text, powers in _KNOWN:
        found = re.fullmatch(pattern, name.removesuffix("_rigid"))
        if found is None:
            continue
        long_name = text.format(*(group or "" for group in found.groups())).replace("_", " ")
        unit = None if powers is None else _unit(powers, units, dim)
        return {"long_name": f"{long_name}, rigid body" if rigid else long_name} | (
            {} if unit is None else {"units": unit}
        )
    return {"long_name": name.replace("_", " ")}


def _unit(powers: Powers, units: Mapping[str, str], dim: int | None) -> str | None:
    """A unit such as "mm/ms" or "kPa mm^2", as udunits and pint read it; "1" for a number."""
    if not powers or not units:
        return "1"
    if "body" in powers:
        if dim is None:
            return None
        powers = {**powers, "length": powers.get("length", 0) + dim - 1}
    named = {units.get(quantity): power for quantity, power in powers.items() if power and quantity != "body"}
    if None in named:
        return None
    above = " ".join(_power(str(unit), power) for unit, power in named.items() if power > 0)
    below = "".join(f"/{_power(str(unit), -power)}" for unit, power in named.items() if power < 0)
    return f"{above or '1'}{below}"


def _power(unit: str, power: int) -> str:
    return unit if power == 1 else f"{unit}^{power}"
