"""The sodium–calcium exchanger and the sodium–potassium pump of ToR-ORd: rings of four conformations."""

from typing import Any

import numpy as np


def exchanger(p: Any, y: Any, na: Any, ca: Any) -> Any:
    """Charge that the exchanger moves, times its activation by calcium.

    Args:
        p: The membrane with its parameters.
        y: Potential over its thermal value.
        na: Sodium inside, mM.
        ca: Calcium inside, mM.
    """
    lift, drop = np.exp(p.qna * y), np.exp(-p.qna * y)
    # Inside: free of sodium, or with three of it.
    a = 1.0 / (1.0 + na / p.kna3 * (1.0 + lift))
    three = na * lift * a / p.kna3
    b = 1.0 / (1.0 + na / p.kna1 * (1.0 + na / p.kna2))
    # Outside.
    c = 1.0 / (1.0 + p.nao / p.kna3 * (1.0 + drop))
    three_out = p.nao / p.kna3 * drop * c
    d = 1.0 / (p.kasymm + 1.0 + p.nao / p.kna1 * (1.0 + p.nao / p.kna2))

    k12, k21 = d * (p.cao * p.kcaon), p.kcaoff
    by_na_out, by_na_in = three_out * p.wnaca, three * p.wnaca
    k23, k32 = c * p.wca + by_na_out, a * p.wca * np.exp(-p.qca * y) + by_na_in
    k34, k43 = p.kcaoff, b * ca * p.kcaon
    pair = p.wna / (p.kna1 * p.kna2)
    k41, k14 = pair * three * b * na * na, pair * three_out * d * p.nao * p.nao
    e1, e2, e3, e4 = shares(ring(k12, k21, k23, k32, k34, k43, k41, k14))
    sodium = 3.0 * (e4 * k41 - e1 * k14) + e3 * by_na_in - e2 * by_na_out
    calcium = e2 * k21 - e1 * k12
    return ca * ca / (ca * ca + p.KmCaAct**2) * (sodium + 2.0 * calcium)


def pump(p: Any, y: Any, na: Any, k: Any) -> Any:
    """Charge that the pump moves.

    In the published sum of the third conformation one product has b2 where the ring has b1, and so it has
    here.

    Args:
        p: The membrane with its parameters.
        y: Potential over its thermal value.
        na: Sodium inside, mM.
        k: Potassium inside, mM.
    """
    na_in = na * np.exp(-p.delta / 3.0 * y) / p.Knai0
    na_out = p.nao / p.Knao0 * np.exp((p.delta - 1.0) / 3.0 * y)
    k_in, k_out = k / p.Kki, p.ko / p.Kko
    inside = 1.0 / (_cube(1.0 + na_in) + (1.0 + k_in) * (1.0 + k_in) - 1.0)
    outside = 1.0 / (_cube(1.0 + na_out) + (1.0 + k_out) ** 2 - 1.0)
    atp = p.MgATP / p.Kmgatp
    phosphate = p.eP / (1.0 + p.H / p.Khp + na / p.Knap + k / p.Kxkur)
    a1, b1 = p.k1p * _cube(na_in) * inside, p.k1m * p.MgADP
    a2, b2 = p.k2p, p.k2m * _cube(na_out) * outside
    a3, b3 = p.k3p * k_out**2 * outside, p.k3m * p.H / (1.0 + atp) * phosphate
    a4, b4 = p.k4p * atp / (1.0 + atp), p.k4m * k_in * k_in * inside
    x1, x2, x3, x4 = ring(a1, b1, a2, b2, a3, b3, a4, b4)
    e1, e2, e3, e4 = shares((x1, x2, x3 + (b2 - b1) * b3 * b4, x4))
    return 3.0 * (e3 * a3 - e4 * b3) + 2.0 * (e2 * b1 - e1 * a1)


def ring(k12: Any, k21: Any, k23: Any, k32: Any, k34: Any, k43: Any, k41: Any, k14: Any) -> tuple[Any, ...]:
    """Weights of four conformations in a ring at steady state, from the rates of going to a neighbour."""
    return (
        k21 * k32 * (k43 + k41) + k34 * k41 * (k21 + k23),
        k12 * k41 * (k32 + k34) + k32 * k43 * (k12 + k14),
        k12 * k23 * (k43 + k41) + k14 * k43 * (k21 + k23),
        k21 * k14 * (k32 + k34) + k23 * k34 * (k12 + k14),
    )


def shares(weights: tuple[Any, ...]) -> list[Any]:
    """Weights over their sum."""
    whole = 1.0 / sum(weights)
    return [weight * whole for weight in weights]


def _cube(x: Any) -> Any:
    return x * x * x
