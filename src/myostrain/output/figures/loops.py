"""Pressure–volume loops, and volumes and pressures of cavities over time."""

from __future__ import annotations

from pathlib import Path

from myostrain.output.figures.data import Recording
from myostrain.output.figures.style import COLOURS, GREY, new_figure, plain, save

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: What clinicians read: factor and unit, by the run's own unit of length (cubed) or stress.
VOLUMES, PRESSURES = {"mm": (1e-3, "mL"), "cm": (1.0, "mL")}, {"kPa": (1 / 0.133322, "mmHg")}


def draw_loops(recording: Recording, folder: Path) -> list[Path]:
    """Draw ``loop.png``, pressure over volume, and ``cavities.png``, both over time, with other pressures.

    Lengths in mm or cm and stresses in kPa are shown as mL and mmHg. Of several beats the last is the thick
    one.

    Args:
        recording: The run.
        folder: Where the pictures go.

    Returns:
        The files; none of a run without cavities.
    """
    table = recording.table("cavities.csv")
    names = [key[7:] for key in table if key.startswith("volume_") and f"pressure_{key[7:]}" in table]
    if not names or len(table["time"]) < 2:
        return []
    units = recording.units or {}
    volume, of_volume = VOLUMES.get(units.get("length", ""), (1.0, recording.unit("length")))
    of_volume = f"{of_volume}³" if of_volume and volume == 1.0 and of_volume != "mL" else of_volume
    pressure, of_pressure = PRESSURES.get(units.get("stress", ""), (1.0, recording.unit("stress")))
    across = f"volume ({of_volume})" if of_volume else "volume"
    up = f"pressure ({of_pressure})" if of_pressure else "pressure"

    figure = new_figure(4.8, 4.0, recording.title)
    panel = figure.add_subplot()
    last = table["time"] >= _last_beat(recording, table["time"])
    for name, colour in zip(names, COLOURS, strict=False):
        V, p = volume * table[f"volume_{name}"], pressure * table[f"pressure_{name}"]
        panel.plot(V, p, color=colour, linewidth=0.6, alpha=0.6)
        panel.plot(V[last], p[last], color=colour, linewidth=1.8, label=plain(name))
    if len(names) > 1:
        panel.legend()
    panel.set(xlabel=across, ylabel=up)
    written = [save(figure, folder / "loop.png")]

    figure = new_figure(6.4, 4.6, recording.title)
    above, below = figure.subplots(2, 1, sharex=True)
    for name, colour in zip(names, COLOURS, strict=False):
        above.plot(table["time"], pressure * table[f"pressure_{name}"], color=colour, label=plain(name))
        below.plot(table["time"], volume * table[f"volume_{name}"], color=colour)
    for key in (key for key in table if key.startswith("pressure_") and key[9:] not in names):
        above.plot(table["time"], pressure * table[key], color=GREY, linestyle="--", label=plain(key[9:]))
    above.legend(loc="upper right")
    above.set(ylabel=up)
    below.set(ylabel=across, xlabel=recording.label("$t$", "time"))
    below.margins(x=0)
    return [*written, save(figure, folder / "cavities.png")]


def _last_beat(recording: Recording, time: Array) -> float:
    """When the last beat begins."""
    parameters = (recording.results or {}).get("parameters", {})
    beats = int(parameters.get("circulation", {}).get("beats", 1))
    return float(time[0] + (time[-1] - time[0]) * (1 - 1 / beats)) - 1e-9 * float(np.ptp(time))
