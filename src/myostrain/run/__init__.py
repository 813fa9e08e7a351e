"""Run control: clock, schedules, checkpoints, retries, interrupts, progress. It knows no physics."""
