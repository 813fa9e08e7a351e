"""Pressure–volume loops, and volumes and pressures of cavities over time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from myostrain.output.figures.data import Recording
from myostrain.output.figures.style import COLOURS, GREY, new_figure, plain, save
from myostrain.output.reader import Reader

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: What clinicians read: factor and unit, by the run's own unit of length (cubed) or stress.
VOLUMES, PRESSURES = {"mm": (1e-3, "mL"), "cm": (1.0, "mL")}, {"kPa": (1 / 0.133322, "mmHg")}


def draw_loops(recording: Recording, folder: Path) -> list[Path]:
    """Draw ``loop.png``, pressure over volume, ``cavities.png``, both over time, and ``wiggers.png``.

    The last is the diagram of C. J. Wiggers of the last beat: all pressures, volumes, and the potential at
    electrodes or probes; phases in which the volume of the first cavity is constant are shaded. Lengths in mm
    or cm and stresses in kPa are shown as mL and mmHg. Of several beats the last is the thick one.

    Args:
        recording: The run.
        folder: Where the pictures go.

    Returns:
        The files; none of a run without cavities.
    """
    table = recording.table("cavities.csv")
    names = cavities_in(table)
    if not names:
        return []
    (volume, across), (pressure, up) = scales(recording)
    figure = new_figure(4.8, 4.0, recording.heading)
    panel = figure.add_subplot()
    last = last_beat(recording, table["time"])
    for name, colour in zip(names, COLOURS, strict=False):
        V, p = volume * table[f"volume_{name}"], pressure * table[f"pressure_{name}"]
        panel.plot(V, p, color=colour, linewidth=0.6, alpha=0.6)
        panel.plot(V[last], p[last], color=colour, linewidth=1.8, label=plain(name))
    if len(names) > 1:
        panel.legend()
    panel.set(xlabel=across, ylabel=up)
    written = [save(figure, folder / "loop.png")]

    figure = new_figure(6.4, 4.6, recording.heading)
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
    written.append(save(figure, folder / "cavities.png"))

    beat = {key: values[last] for key, values in table.items()}
    if np.count_nonzero(last) < 2:
        return written
    signals, label = _signals(recording)
    rows = 3 if signals else 2
    figure = new_figure(6.4, 2.2 + 1.4 * rows, recording.heading)
    above, middle, *below = figure.subplots(rows, 1, sharex=True, height_ratios=(2, 1.4, 1)[:rows])
    t = beat["time"]
    for name, colour in zip(names, COLOURS, strict=False):
        above.plot(t, pressure * beat[f"pressure_{name}"], color=colour, label=plain(name))
        middle.plot(t, volume * beat[f"volume_{name}"], color=colour, label=plain(name))
    others = [key for key in beat if key.startswith("pressure_") and key[9:] not in names]
    for key, look in zip(others, ("--", ":", "-.", (0, (1, 3))), strict=False):
        above.plot(
            t, pressure * beat[key], color="black", linewidth=1.0, linestyle=look, label=plain(key[9:])
        )
    held = isovolumetric(beat[f"volume_{names[0]}"])
    for panel in (above, middle, *below):
        panel.fill_between(
            t, 0, 1, where=held, color=GREY, alpha=0.25, linewidth=0, transform=panel.get_xaxis_transform()
        )
        panel.margins(x=0)
    for panel in below:
        times = signals.pop("time")
        within = (times >= t[0]) & (times <= t[-1])
        for (name, values), colour in zip(signals.items(), COLOURS, strict=False):
            panel.plot(times[within], values[within], color=colour, linewidth=0.9, label=plain(name))
        panel.set(ylabel=label)
        panel.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    above.set(ylabel=up)
    middle.set(ylabel=across)
    (below or [middle])[-1].set(xlabel=recording.label("$t$", "time"))
    above.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return [*written, save(figure, folder / "wiggers.png")]


def isovolumetric(volume: Array) -> npt.NDArray[np.bool_]:
    """Rows (n,) about which a volume (n,) stays the same to a thousandth of its range a row."""
    steps = np.abs(np.diff(volume)) < 1e-3 * np.ptp(volume)
    return np.concatenate([steps[:1], steps[1:] & steps[:-1], steps[-1:]])


def _signals(recording: Recording) -> tuple[dict[str, Array], str]:
    """Time and the potential at electrodes or, without any, at probes; nothing where neither is."""
    signals = recording.table("ecg.csv")
    if len(signals) > 1:
        return signals, "electrodes"
    times, found = recording.probe_histories("potential")
    return ({"time": times, **found} if found else {}), recording.label("$v$", "potential")


def cavities_in(table: Mapping[str, Array]) -> list[str]:
    """Names of the cavities of which a table has volume and pressure over time."""
    names = [key[7:] for key in table if key.startswith("volume_") and f"pressure_{key[7:]}" in table]
    return names if names and len(table["time"]) > 1 else []


def scales(recording: Reader) -> tuple[tuple[float, str], tuple[float, str]]:
    """Factor and label of volumes, then of pressures."""
    units = recording.units or {}
    volume, of_volume = VOLUMES.get(units.get("length", ""), (1.0, recording.unit("length")))
    of_volume = f"{of_volume}³" if of_volume and volume == 1.0 and of_volume != "mL" else of_volume
    pressure, of_pressure = PRESSURES.get(units.get("stress", ""), (1.0, recording.unit("stress")))
    across = f"volume ({of_volume})" if of_volume else "volume"
    return (volume, across), (pressure, f"pressure ({of_pressure})" if of_pressure else "pressure")


def last_beat(recording: Reader, time: Array) -> npt.NDArray[np.bool_]:
    """Which of the times are in the last beat."""
    parameters = (recording.results or {}).get("parameters", {})
    beats = int(parameters.get("circulation", {}).get("beats", 1))
    begin = float(time[0] + (time[-1] - time[0]) * (1 - 1 / beats)) - 1e-9 * float(np.ptp(time))
    return np.asarray(time >= begin)
