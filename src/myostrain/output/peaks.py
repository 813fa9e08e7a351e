"""What the measured quantities of a run reached."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping

#: Measured quantity: the metric, and in what sense the greatest value over time is taken.
PEAKS: dict[str, tuple[str, Callable[[float], float]]] = {
    "volume_ratio": ("volume_ratio", lambda ratio: abs(ratio - 1)),
    "fibre_stretch_min": ("fibre_stretch_min", operator.neg),
    "twist": ("twist", abs),
    "wall_thickening": ("wall_thickening", abs),
    "longitudinal_shortening": ("longitudinal_shortening", abs),
    "ellipticity": ("ellipticity_min", operator.neg),
}


#: Mean strains of a wall.
STRAINS = tuple(f"{kind}_strain" for kind in ("longitudinal", "circumferential", "radial"))


def _since(strain: float, begin: float) -> float:
    return (1 + strain) / (1 + begin) - 1


#: What is counted from the first time too: the end of the metric's name, and how. Shortening is 1 − l/l₀.
SINCE: dict[str, tuple[str, Callable[[float, float], float]]] = {
    **dict.fromkeys(STRAINS, ("peak", _since)),
    "wall_thickening": ("beat", _since),
    "longitudinal_shortening": ("beat", lambda shortening, begin: -_since(-shortening, -begin)),
    "twist": ("beat", lambda twist, begin: twist - begin),
}


class Peaks:
    """What a run's metrics say of the measured quantities over its sampled times.

    - ``fibre_shortening``: 1 − the least ``fibre_stretch_mean``;
    - ``twist``, ``wall_thickening``, ``longitudinal_shortening``: the value of largest magnitude;
    - ``volume_ratio``: the value farthest from one;
    - ``fibre_stretch_min``: the least; ``ellipticity_min``: the least ``ellipticity``;
    - ``longitudinal_strain_peak`` and likewise circumferential and radial: the mean strain of largest
      magnitude since the first time, as since the end of diastole, (1 + e)/(1 + e₀) − 1;
    - ``twist_beat``, ``wall_thickening_beat``, ``longitudinal_shortening_beat``: likewise of largest
      magnitude since the first time, the last relative to the length then; ``..._begin`` is the first value;
    - of every cavity ``cavity_volume_min``, ``cavity_volume_max`` and ``ejection_fraction``, the largest
      share of its volume that it lost since an earlier time, 1 − V(t)/V(s) with s ≤ t; for a NAMEd one
      ``cavity_volume_NAME_min``, ..., ``ejection_fraction_NAME``.

    Args:
        found: What was found before.

    Attributes:
        found: The numbers by name.
    """

    def __init__(self, found: Mapping[str, float] | None = None) -> None:
        self.found = dict(found or {})

    def observe(self, values: Mapping[str, float]) -> None:
        """Take the values of one more time into account."""
        for name, value in values.items():
            if name.startswith("cavity_volume"):
                self._keep(f"{name}_min", value, operator.neg)
                self._keep(f"{name}_max", value, float)
                full = self.found[f"{name}_max"]
                if full > 0:
                    share = name.replace("cavity_volume", "ejection_fraction", 1)
                    self._keep(share, 1 - value / full, float)
            elif name == "fibre_stretch_mean":
                self._keep("fibre_shortening", 1 - value, float)
            elif name in PEAKS:
                metric, size = PEAKS[name]
                self._keep(metric, value, size)
            if name in SINCE:
                end, since = SINCE[name]
                begin = self.found.setdefault(f"{name}_begin", value)
                self._keep(f"{name}_{end}", since(value, begin), abs)

    def _keep(self, name: str, value: float, size: Callable[[float], float]) -> None:
        """Keep the value of greatest size."""
        if name not in self.found or size(value) > size(self.found[name]):
            self.found[name] = value
