"""Run control: clock, schedules, checkpoints, retries, interrupts, progress. It knows no physics."""

from myostrain.run.simulation import Simulation

__all__ = ["Simulation"]
