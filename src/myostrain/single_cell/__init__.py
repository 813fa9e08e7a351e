"""Membranes without a body: paced by stimuli, measured beat by beat, written down."""

from myostrain.single_cell.pacing import Paced, cell
from myostrain.single_cell.record import end_state, resting_at, write_cell

__all__ = ["Paced", "cell", "end_state", "resting_at", "write_cell"]
