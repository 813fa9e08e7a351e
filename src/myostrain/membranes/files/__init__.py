"""Membranes from files of other programs: ``.ode`` (gotran), ``.mmt`` (Myokit) and ``.cellml``.

A reader makes formulas of what a file says, and these are walked: nothing in a file is ever run as code.
"""

from myostrain.membranes.files.file_membrane import FileMembrane

__all__ = ["FileMembrane"]
