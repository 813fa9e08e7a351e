"""Formulas that several human membranes share."""

from typing import Any

import numpy as np


def drift(x: Any, decay: Any) -> Any:
    """x/(1 − exp(−x)), the factor of a constant-field flux; it tends to 1 at x = 0.

    Args:
        x: Potential over its thermal value, per charge.
        decay: exp(−x), which the caller has.
    """
    near = np.abs(x) < 0.03
    series = 1.0 + x / 2.0 + x * x * (1.0 / 12.0 - x * x / 720.0)
    return np.where(near, series, x / np.where(near, 1.0, 1.0 - decay))


def sodium_inactivation(v: Any) -> tuple[Any, Any]:
    """Speeds (reciprocal time constants, 1/ms) of the sodium gates h and j at a potential in mV.

    The formulas are those of ten Tusscher et al., 2004; ToR-ORd has them, too. There is one below −40 mV and
    another above, and they share exponentials.
    """
    low = v < -40.0
    a = np.exp(np.where(low, (v + 80.0) / -6.8, (v + 10.66) / -11.1))
    h_low = 0.057 * a + 2.7 * np.exp(0.079 * v) + 310000.0 * np.exp(0.3485 * v)
    h_speed = np.where(low, h_low, (0.77 / 0.13) / (1.0 + a))
    opening = (25428.0 * np.exp(0.2444 * v) + 6.948e-6 * np.exp(-0.04391 * v)) * (v + 37.78)
    alpha = np.where(low, -opening / (1.0 + np.exp(0.311 * (v + 79.23))), 0.0)
    b = np.exp(np.where(low, -0.1378 * (v + 40.14), -0.1 * (v + 32.0)))
    c = np.where(low, 0.02424, 0.6) * np.exp(np.where(low, -0.01052 * v, 0.057 * v))
    return h_speed, alpha + c / (1.0 + b)
