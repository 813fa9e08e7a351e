"""How much force a sarcomere gives at its length."""

from typing import Any

import numpy as np

#: Fourier coefficients over the length in μm, of S. Rossi and others 2014 as public codes have them.
CONSTANT = -4333.618335582119
SINES = (2570.395355352195, 1329.53611689133, 104.943770305116)
COSINES = (-2051.827278991976, 302.216784558222, 218.375174229422)

#: Between these lengths, in μm, the filaments overlap.
SHORTEST, LONGEST = 1.7, 2.6


def force_length(stretch: Any, sarcomere: float = 1.95) -> Any:
    """The share of the largest force at a stretch, 0 to about 1: the curve of Frank and Starling.

    RFL = f₀/2 + Σ fₛₖ sin(k SL) + f_ck cos(k SL), k = 1, 2, 3, with SL in μm; zero outside 1.7 to 2.6 μm and
    never negative. S. Rossi and others, Eur. J. Mech. A/Solids 48 (2014) 129–142,
    doi 10.1016/j.euromechsol.2013.10.009, with the coefficients that public codes have.

    Args:
        stretch: Stretch of the fibre (nodes,).
        sarcomere: Length of the sarcomere at stretch one, μm.
    """
    length = sarcomere * np.asarray(stretch, dtype=float)
    terms = zip((1, 2, 3), SINES, COSINES, strict=True)
    total = CONSTANT / 2 + sum(s * np.sin(k * length) + c * np.cos(k * length) for k, s, c in terms)
    within = (length > SHORTEST) & (length < LONGEST)
    return np.where(within, np.maximum(total, 0.0), 0.0)
