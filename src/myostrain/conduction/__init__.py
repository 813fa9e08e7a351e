"""How fast a membrane conducts: a wave on a rigid cable, its velocity, the diffusivity for a wanted one."""

from myostrain.conduction.measuring import Conducted, cable
from myostrain.conduction.record import write_cable
from myostrain.conduction.wave import Cable, Wave, travel

__all__ = ["Cable", "Conducted", "Wave", "cable", "travel", "write_cable"]
