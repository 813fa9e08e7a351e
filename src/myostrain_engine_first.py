"""Makes ``import dolfinx`` work in any order of imports, where DOLFINx comes from its PyPI wheel.

That wheel has to load MPI before its compiled modules, which importing ``dolfinx_solver`` does; without it,
``import dolfinx`` fails with "libmpi.so.12: cannot open shared object file". Python runs this module when it
starts (``myostrain_engine_first.pth``), and so does ``import myostrain``. It costs a fraction of a
millisecond, and does nothing until one of the modules below is asked for, or where there is no
``dolfinx_solver``.
"""

import sys

#: What needs MPI to be there.
NEEDY = ("dolfinx", "petsc4py", "slepc4py")


class Engine:
    """Sees every import that Python has not done yet; finds nothing itself."""

    @classmethod
    def find_spec(cls, name: str, path: object = None, target: object = None) -> None:
        """Load MPI first, once, when ``name`` needs it."""
        if name in NEEDY and cls in sys.meta_path:
            sys.meta_path.remove(cls)
            try:  # noqa: SIM105 - every start of Python would pay for contextlib
                import dolfinx_solver  # noqa: F401
            except ModuleNotFoundError:  # a DOLFINx from conda, Debian or a container needs no help
                pass


if Engine not in sys.meta_path and "dolfinx_solver" not in sys.modules:
    sys.meta_path.insert(0, Engine)
