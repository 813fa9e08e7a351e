"""A case over values of its keys: many runs, one table."""

from myostrain.sweeping.running import Sweep, sweep

__all__ = ["Sweep", "sweep"]
