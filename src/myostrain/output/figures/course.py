"""What happens over time: at the probes, and how the whole body deforms."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.output.figures.data import Recording
from myostrain.output.figures.style import BLUE, COLOURS, GREY, SEQUENTIAL, new_figure, plain, save
from myostrain.output.frames import Frames
from myostrain.output.quantities import attributes

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps

Array = npt.NDArray[np.float64]

#: A deformation is shown if some stretch or volume ratio is farther from 1 than this.
LEAST = 1e-4


def hues(count: int) -> list[Any]:
    """A colour for each of some curves: few that are told apart, or many in order."""
    few = count <= len(COLOURS)
    return [COLOURS[i] if few else colormaps[SEQUENTIAL](i / count) for i in range(count)]


def draw_probes(recording: Recording, path: Path) -> list[Path]:
    """Draw what is sampled at the probes: the potential, and the activation and |u| where there are any.

    Args:
        recording: The run.
        path: The picture.

    Returns:
        The files; none without probes, or with one time only.
    """
    times, table = recording.probe_table()
    table = {probe: values for probe, values in table.items() if "potential" in values}
    if len(times) < 2 or not table:
        return []
    panels = {recording.label("$v$", "potential"): {p: values["potential"] for p, values in table.items()}}
    activation = {p: values["activation"] for p, values in table.items() if "activation" in values}
    if any(np.any(values) for values in activation.values()):
        panels[recording.activation_label] = activation
    moved = {p: _size(values) for p, values in table.items()}
    if any(np.any(values) for values in moved.values()):
        panels[recording.label("$|u|$", "length")] = moved
    figure = new_figure(7.2, 1.4 + 2.0 * len(panels), recording.heading)
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for panel, (label, curves) in zip(axes, panels.items(), strict=True):
        lines = [
            panel.plot(times, values, color=hue, linewidth=1.5)[0]
            for values, hue in zip(curves.values(), hues(len(curves)), strict=True)
        ]
        panel.axhline(recording.rest if panel is axes[0] else 0.0, color=GREY, linewidth=0.5, zorder=1)
        panel.set_ylabel(label)
        panel.margins(x=0)
        if panel is axes[0]:
            names = [f" {plain(name)}" for name in curves]
            panel.legend(lines, names, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axes[-1].set_xlabel(recording.label("$t$", "time"))
    figure.align_ylabels()
    return [save(figure, path)]


def _size(values: Mapping[str, Array]) -> Array:
    """The length of the displacement (samples,) at a probe."""
    parts = [column for name, column in values.items() if name.startswith("displacement_")]
    return np.asarray(np.linalg.norm(parts, axis=0)) if parts else np.zeros(1)


def deformation_over_time(frames: Frames) -> dict[str, Array]:
    """How a body deforms, from its frames: "displacement" (frames,) is the largest |u| of a node.

    "fibre_stretch" and "J" are (3, frames): least, mean over the reference body, largest at the centres of
    the cells; "J" is there for bodies whose volume changes. What the frames cannot say is left out.
    """
    size = [float(np.linalg.norm(frame["displacement"], axis=1).max()) for frame in frames]
    found = {"displacement": np.array(size)}
    for name in ("fibre_stretch", "J"):
        rows = []
        try:
            for frame in frames:
                values = getattr(frame, name)()
                mean = np.average(values, weights=frames.volumes)
                rows.append((values.min(), mean, values.max()))
        except InputError:  # no fibres, or a sheet whose thickness was not written
            continue
        found[name] = np.array(rows).T
    if "J" in found and (frames.points.shape[1] == 1 or np.abs(found["J"] - 1).max() < 1e-2):
        del found["J"]  # of a line it is the stretch; where it is constrained it is 1 to the mesh's error
    return found


def draw_deformation(recording: Recording, path: Path) -> list[Path]:
    """Draw how the body deforms over time: the largest |u|, the stretch of the fibre, J where it changes.

    Args:
        recording: The run.
        path: The picture.

    Returns:
        The files; none of a body that does not deform, or with one frame only.
    """
    if len(recording.time) < 2 or not recording.has("displacement"):
        return []
    found = deformation_over_time(Frames(recording))
    if not found["displacement"].max() > LEAST * np.ptp(recording.points, axis=0).max():
        return []
    labels = {
        "displacement": recording.label("largest $|u|$", "length"),
        "fibre_stretch": attributes("stretch", {}, None)["long_name"],
        "J": "volume ratio $J$",
    }
    figure = new_figure(7.2, 1.2 + 1.9 * len(found), recording.heading)
    axes = figure.subplots(len(found), 1, sharex=True, squeeze=False)[:, 0]
    for panel, (name, values) in zip(axes, found.items(), strict=True):
        rows = np.atleast_2d(values)
        panel.plot(recording.time, rows[len(rows) // 2], color=BLUE, label="mean")
        if len(rows) == 3:
            band = {"color": BLUE, "alpha": 0.2, "linewidth": 0, "label": "least to largest"}
            panel.fill_between(recording.time, rows[0], rows[2], **band)
            panel.axhline(1.0, color=GREY, linewidth=0.5, zorder=1)
            panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        panel.set_ylabel(labels[name])
        panel.margins(x=0)
    axes[-1].set_xlabel(recording.label("$t$", "time"))
    figure.align_ylabels()
    return [save(figure, path)]
