"""What anisotropic materials and active deformations ask of a body's fibres."""

from __future__ import annotations

from typing import Any

from myostrain.errors import InputError

import ufl


def with_sheets(fibres: Any, who: str) -> tuple[Any, Any, Any]:
    """The directions f0, s0, n0 of fibres that come with sheets.

    Args:
        fibres: Has ``f0``, ``s0`` and ``n0``, UFL vectors; ``n0`` may be None, and is f0 × s0 then.
        who: What needs them, for the message.

    Raises:
        InputError: The fibres come without sheets.
    """
    f0, s0, n0 = fibres.f0, fibres.s0, fibres.n0
    if s0 is None:
        raise InputError(
            f"{who} needs a sheet direction beside the fibre's; give one that is across the fibre, "
            "for example sheet = [0, 1, 0]",
            "fibres.sheet",
        )
    return f0, s0, ufl.cross(f0, s0) if n0 is None else n0
