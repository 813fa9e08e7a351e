"""A case file and what it takes to run it: sections, words, overrides, estimates of size."""

from myostrain.case.case import Case
from myostrain.case.running import run_case

__all__ = ["Case", "run_case"]
