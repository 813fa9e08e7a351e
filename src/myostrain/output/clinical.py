"""What a cardiologist reads at the end of a run: its metrics in clinical words and units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

#: Metrics of one segment of a ventricle, of which there are too many for a screen.
SEGMENT = re.compile(r"(\w+_strain|fibre_stretch|fibre_stress)_\d+")

#: By metric, its name; that of a cavity of several has the cavity's name appended.
_OF_CAVITIES = {
    "volume_max": "end-diastolic volume",
    "volume_min": "end-systolic volume",
    "stroke_volume": "stroke volume",
    "ejection_fraction": "ejection fraction",
    "pressure_max": "greatest pressure",
    "dpdt_max": "greatest dP/dt",
    "stroke_work": "stroke work",
    "stroke_volume_change": "change of stroke volume",
}
_OF_WALLS = {
    "twist_beat": "twist",
    "torsion": "torsion at the end",
    "wall_thickening_beat": "thickening of the wall",
    "longitudinal_shortening_beat": "shortening of the long axis",
    "fibre_shortening": "shortening of the fibres",
    "longitudinal_strain_peak": "greatest longitudinal strain",
    "circumferential_strain_peak": "greatest circumferential strain",
    "radial_strain_peak": "greatest radial strain",
}
_PERCENT = (
    "ejection_fraction",
    "stroke_volume_change",
    "wall_thickening_beat",
    "longitudinal_shortening_beat",
    "fibre_shortening",
    *(f"{kind}_strain_peak" for kind in ("longitudinal", "circumferential", "radial")),
)

#: kPa in a mmHg.
MMHG = 0.133322

#: By unit of a metric, by what it is multiplied, and what it then is.
_CLINICAL = {
    "mm^3": (1e-3, "mL"),
    "cm^3": (1.0, "mL"),
    "kPa": (1 / MMHG, "mmHg"),
    "Pa": (1e-3 / MMHG, "mmHg"),
    "kPa/ms": (1e3 / MMHG, "mmHg/s"),
    "kPa/s": (1 / MMHG, "mmHg/s"),
    "Pa/s": (1e-3 / MMHG, "mmHg/s"),
    "kPa mm^3": (1e-6, "J"),
    "kPa cm^3": (1e-3, "J"),
}


def clinical(metrics: Mapping[str, Any], units: Mapping[str, str]) -> list[tuple[str, float, str]]:
    """Name, value and unit of what a ventricle did, empty where no cavity is connected to anything.

    Twist, thickening and shortening are those since the run began, as from the end of diastole.

    Args:
        metrics: Those of a run.
        units: Units of metrics by name; what has none of the clinical ones stays as it is.
    """
    found = []
    for words in (_OF_CAVITIES, _OF_WALLS):
        # The longest first: a stroke volume may be that of a cavity called "change".
        keys = {
            metric: max((key for key in words if _is(metric, key, words)), key=len, default=None)
            for metric, value in metrics.items()
            if value is not None
        }
        for wanted in words:
            for metric, key in keys.items():
                if key == wanted:
                    found.append(_row(metric, key, words[key], float(metrics[metric]), units.get(metric, "")))
        if not found:
            return []
    return found


def _row(metric: str, key: str, words: str, value: float, unit: str) -> tuple[str, float, str]:
    """Name, value and unit of one metric."""
    name = words + metric.removeprefix(key).replace("_", ", ", 1).replace("_", " ")
    if key in ("twist_beat", "torsion"):
        return name, value, "degrees"
    factor, clinical_unit = (100.0, "%") if key in _PERCENT else _CLINICAL.get(unit, (1.0, unit))
    return name, factor * value, clinical_unit


def _is(metric: str, key: str, words: Mapping[str, str]) -> bool:
    """Whether a metric is this one, or that of a cavity."""
    return metric == key or (words is _OF_CAVITIES and metric.startswith(f"{key}_"))
