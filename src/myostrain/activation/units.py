"""Units in which laws and membranes count."""

from __future__ import annotations

#: Each quantity's units, in multiples of one of them.
SCALES = (
    {"M": 1.0, "mM": 1e-3, "μM": 1e-6, "uM": 1e-6, "nM": 1e-9},
    {"V": 1.0, "mV": 1e-3},
    {"s": 1.0, "ms": 1e-3},
)


def conversion(given: str | None, wanted: str | None) -> float | None:
    """The factor that makes numbers in one unit such in another; None where there is none."""
    given, wanted = (unit and unit.replace("\N{MICRO SIGN}", "μ") for unit in (given, wanted))
    if given == wanted:
        return 1.0
    for scale in SCALES:
        if given in scale and wanted in scale:
            return scale[given] / scale[wanted]
    return None
