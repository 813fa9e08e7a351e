"""Which fields are shown, and how: colours, ends of the scale, label."""

from __future__ import annotations

from myostrain.output.figures.choice import choice
from myostrain.output.figures.data import Recording
from myostrain.output.figures.style import DIVERGING, SEQUENTIAL, symmetric_range
from myostrain.output.quantities import attributes

import numpy as np
import numpy.typing as npt
from matplotlib.colors import Normalize

Array = npt.NDArray[np.float64]

#: Names of fields by the name of their picture, where they differ.
PICTURES = {"stress": "stress_trace"}


def shown_fields(recording: Recording, default: tuple[str, ...]) -> dict[str, str]:
    """Recorded fields by the name of their picture: those chosen, else some."""
    named = choice().fields or default
    fields = {name: PICTURES.get(name, name) for name in named}
    return {name: field for name, field in fields.items() if recording.has(field)}


def scalar(values: Array) -> Array:
    """Values (n,) of a field, the lengths (n,) of vectors (n, dim)."""
    return values if values.ndim == 1 else np.linalg.norm(values, axis=-1)


def colours(recording: Recording, field: str, values: Array) -> tuple[str, Normalize, str]:
    """Colour map, scale and label of a field.

    Args:
        recording: The run.
        field: Its name.
        values: All values that are shown, as scalars.
    """
    if field == "potential":
        norm = Normalize(*recording.potential_range(values))
        return SEQUENTIAL, norm, recording.label("potential $v$", "potential")
    if field == "displacement":
        label = recording.label("displacement $|u|$", "length")
        return SEQUENTIAL, Normalize(0.0, float(values.max()) or 1.0), label
    if field in ("activation", "gamma"):
        about = {"long_name": r"$\gamma$" if field == "gamma" else recording.activation_label}
    else:
        about = attributes(field, recording.units, recording.dim)
    unit = about.get("units")
    label = about["long_name"] if unit in (None, "1") else f"{about['long_name']} ({unit})"
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if field.startswith("stress") or low < -0.1 * high < 0:
        return DIVERGING, Normalize(*symmetric_range(values)), label
    return SEQUENTIAL, Normalize(low, high if high > low else low + 1.0), label
