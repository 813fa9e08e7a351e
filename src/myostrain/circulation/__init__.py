"""What cavities are connected to: 0D models of the circulation, and pressures and volumes that are given."""

from myostrain.circulation.circuit import Circuit
from myostrain.circulation.closed_loop import ClosedLoop
from myostrain.circulation.contracts import Circulation, Prescribed
from myostrain.circulation.prescribed import Isovolumetric, PrescribedPressure, PrescribedVolume
from myostrain.circulation.windkessel import Windkessel

__all__ = [
    "Circuit",
    "Circulation",
    "ClosedLoop",
    "Isovolumetric",
    "Prescribed",
    "PrescribedPressure",
    "PrescribedVolume",
    "Windkessel",
]
