"""What the figures are drawn from: a result folder with frames, and how its axes are labelled."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from myostrain.output.figures.choice import choice
from myostrain.output.figures.style import at_time, potential_range
from myostrain.output.reader import Reader

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Recording(Reader):
    """A result folder with snapshots, to be drawn.

    Args:
        folder: The result folder.

    Raises:
        InputError: It holds no snapshots, or a file in it cannot be read.
    """

    dim: int

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        _ = self.snapshots  # what is wrong with them shows here

    def __repr__(self) -> str:
        """What there is."""
        return f"Recording({self.title}: {self.snapshots!r})"

    def potential_range(self, values: Array) -> tuple[float, float]:
        """Ends of the colour scale of a potential: those of a membrane with a unit, or of the values."""
        declared = self.snapshots.about.get("range")
        if declared and self.snapshots.about.get("units", {}).get("potential"):
            return float(declared[0]), float(declared[1])
        return potential_range(values)

    @property
    def heading(self) -> str:
        """What stands above a picture: the title, and once that all is non-dimensional, where it is."""
        return self.title if self.units else f"{self.title}, non-dimensional"

    @property
    def activation_label(self) -> str:
        """The axis label of what the activation law yields."""
        yields = self.snapshots.about.get("yields")
        return {"strain": r"$\gamma$", "tension": self.label("active tension", "stress")}.get(
            str(yields), "activation"
        )

    def label(self, symbol: str, quantity: str) -> str:
        """An axis label: the symbol and its unit, where it has one; the heading says where nothing has."""
        unit = self.units.get(quantity)
        return symbol if unit is None else f"{symbol} ({unit})"

    def rate_label(self, symbol: str, quantity: str, over: str) -> str:
        """An axis label of a quantity over another one, such as a length over a time."""
        one, other = self.units.get(quantity), self.units.get(over)
        return symbol if one is None or other is None else f"{symbol} ({one}/{other})"

    def chosen_frames(self, default: Sequence[int]) -> list[int]:
        """Frames nearest to the times that are wanted, each once; the default where none are.

        Raises:
            InputError: A time is before or after all frames.
        """
        times = choice().times
        found = dict.fromkeys(self.frame_at(time, "--times") for time in times)
        return list(found) if times else list(default)

    def when(self, frame: int) -> str:
        """The line that says when a frame is: "t = 0.35 ms"."""
        return f"{at_time(self.time[frame])} {self.unit('time')}".strip()
