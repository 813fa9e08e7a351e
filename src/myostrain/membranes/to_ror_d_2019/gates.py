"""Rates of the gates of ToR-ORd and of the conformations of its rapid potassium channel, 1/ms."""

from typing import Any

from myostrain.membranes.channels import sodium_inactivation
from myostrain.membranes.to_ror_d_2019.states import States

import numpy as np

# Each gate goes to its steady value with a speed, the reciprocal of its time constant. A time constant such
# as t + 1/a is the speed a/(1 + t a).


def gate_rates(p: Any, v: Any, s: States) -> dict[str, Any]:
    """Rate of each gate by name.

    Args:
        p: The membrane with its parameters.
        v: Potential, mV.
        s: Its states.
    """
    return {**_sodium(p, v, s), **_outward(p, v, s), **_calcium(p, v, s), **_slow(v, s), **_rapid(p, v, s)}


def _sodium(p: Any, v: Any, s: States) -> dict[str, Any]:
    h_speed, j_speed = sodium_inactivation(v)
    m_root = 1.0 + np.exp((-56.86 - v) / 9.03)
    odds = np.exp((v + 71.55) / 7.43)
    h_root, hp_root = 1.0 + odds, 1.0 + np.exp(6.0 / 7.43) * odds
    steady = 1.0 / (h_root * h_root)
    first, second = (v + 45.79) / 15.54, (v - 4.823) / 51.12
    m_speed = 1.0 / (0.1292 * np.exp(-first * first) + 0.06487 * np.exp(-second * second))
    odds_late = np.exp((v + 87.61) / 7.488)
    return {
        "m": (1.0 / (m_root * m_root) - s.m) * m_speed,
        "h": (steady - s.h) * h_speed,
        "hp": (1.0 / (hp_root * hp_root) - s.hp) * h_speed,
        "j": (steady - s.j) * j_speed,
        "jp": (steady - s.jp) * j_speed / 1.46,
        "mL": (1.0 / (1.0 + np.exp((-42.85 - v) / 5.264)) - s.mL) * m_speed,
        "hL": (1.0 / (1.0 + odds_late) - s.hL) / p.thL,
        "hLp": (1.0 / (1.0 + np.exp(6.2 / 7.488) * odds_late) - s.hLp) / (3.0 * p.thL),
    }


def _outward(p: Any, v: Any, s: States) -> dict[str, Any]:
    odds = np.exp((14.34 - v) / 14.82)
    a, b = 1.0 + np.exp((18.4099 - v) / 29.3814), 1.0 + np.exp((v + 100.0) / 29.3814)
    speed = (1.0 / (1.2089 * a) + 3.5 / b) / 1.0515
    steady = 1.0 / (1.0 + np.exp((v + 43.94) / 5.711))
    fast = 0.3933 * np.exp((v + 100.0) / -100.0) + 0.08004 * np.exp((v + 50.0) / 16.59)
    slow = 0.001416 * np.exp((v + 96.52) / -59.05) + 1.780e-8 * np.exp((v + 114.1) / 8.079)
    fast, slow = fast / (1.0 + 4.562 * fast), slow / (1.0 + 23.62 * slow)
    c = 1.0 + np.exp((v + 70.0) / 5.0)
    faster = np.where(p.delta_epi > 0.5, c / (c - 0.95), 1.0)  # a number where it varies over the body
    fast, slow = fast * faster, slow * faster
    # Phosphorylated channels are slower: in what develops and in what recovers. Its steep exponential is
    # capped where it does no more matter.
    steep = np.exp(np.minimum((12.23 - v) / 0.2154, 300.0))
    c = 1.0 + np.exp(3.5) * np.exp(v / 20.0)
    slower = (1.354 + 1e-4 / (np.exp((v - 167.4) / 15.89) + steep)) * (c - 0.5) / c
    return {
        "a": (1.0 / (1.0 + odds) - s.a) * speed,
        "ap": (1.0 / (1.0 + np.exp(10.0 / 14.82) * odds) - s.ap) * speed,
        "iF": (steady - s.iF) * fast,
        "iS": (steady - s.iS) * slow,
        "iFp": (steady - s.iFp) * fast / slower,
        "iSp": (steady - s.iSp) * slow / slower,
    }


def _calcium(p: Any, v: Any, s: States) -> dict[str, Any]:
    opened = np.where(v >= 31.4978, 1.0, 1.0763 * np.exp(-1.007 * np.exp(-0.0829 * v)))
    up_20, down_20 = np.exp(v / 20.0), np.exp(v / -20.0)
    d = np.exp(-0.3) * down_20 + np.exp(0.09 * (v + 14.0))
    steady = 1.0 / (1.0 + np.exp((v + 19.58) / 3.696))
    f = 0.0045 * (np.exp(2.0) * up_20 * up_20 + np.exp(-2.0) * down_20 * down_20)
    fs = 3.5e-5 * (np.exp((v + 5.0) / -4.0) + np.exp((v + 5.0) / 6.0))
    up, down = np.exp(v / 7.0), np.exp(v / -7.0)
    fca = 0.04 * (np.exp(4.0 / 7.0) * down + np.exp(-4.0 / 7.0) * up)
    fcas = 0.00012 * (np.exp(v / -3.0) + up)
    f, fca = f / (1.0 + 7.0 * f), fca / (1.0 + 7.0 * fca)

    def mode(n: Any, ca: Any) -> Any:
        """Rate of the share of channels that calcium inactivates."""
        square = (1.0 + p.Kmn / ca) * (1.0 + p.Kmn / ca)
        return p.k2n * s.jca / (p.k2n + s.jca * square * square) - n * s.jca

    return {
        "d": (opened - s.d) * d / (1.0 + 0.6 * d),
        "ff": (steady - s.ff) * f,
        "ffp": (steady - s.ffp) * f / 2.5,
        "fs": (steady - s.fs) * fs / (1.0 + 1000.0 * fs),
        "fcaf": (steady - s.fcaf) * fca,
        "fcafp": (steady - s.fcafp) * fca / 2.5,
        "fcas": (steady - s.fcas) * fcas / (1.0 + 100.0 * fcas),
        "jca": (1.0 / (1.0 + np.exp((v + 18.08) / 2.7916)) - s.jca) / p.tjca,
        "nca_ss": mode(s.nca_ss, s.cass),
        "nca_i": mode(s.nca_i, 1e-3 * s.cai),
    }


def _slow(v: Any, s: States) -> dict[str, Any]:
    steady = 1.0 / (1.0 + np.exp((-11.6 - v) / 8.932))
    first = 2.326e-4 * np.exp((v + 48.28) / 17.8) + 0.001292 * np.exp((v + 210.0) / -230.0)
    second = (0.01 * np.exp(-2.5)) * np.exp(v / 20.0) + 0.0193 * np.exp((v + 66.54) / -31.0)
    return {
        "xs1": (steady - s.xs1) * first / (1.0 + 817.3 * first),
        "xs2": (steady - s.xs2) * second,
    }


def _rapid(p: Any, v: Any, s: States) -> dict[str, Any]:
    """Conformations C0 ⇄ C1 ⇄ C2 ⇄ O ⇄ I ⇄ C2; the way back from I to C2 keeps the last loop reversible."""
    y = v * (p.F / (p.R * p.T))
    c0_c1, c1_c0 = 0.1161 * np.exp(0.299 * y), 0.2442 * np.exp(-1.604 * y)
    c2_o, o_c2 = 0.0578 * np.exp(0.971 * y), 0.000349 * np.exp(-1.062 * y)
    o_i, i_o = 0.2533 * np.exp(0.5953 * y), 0.06525 * np.exp(-0.8209 * y)
    c2_i = 5.2e-5 * np.exp(1.525 * y)
    balance = 0.000349 * 0.06525 * 5.2e-5 / (0.0578 * 0.2533)
    i_c2 = balance * np.exp((-1.062 - 0.8209 + 1.525 - 0.971 - 0.5953) * y)
    return {
        "C0": s.C1 * c1_c0 - s.C0 * c0_c1,
        "C1": s.C0 * c0_c1 + s.C2 * p.beta_1 - s.C1 * (c1_c0 + p.alpha_1),
        "C2": s.C1 * p.alpha_1 + s.O * o_c2 + s.I * i_c2 - s.C2 * (p.beta_1 + c2_o + c2_i),
        "O": s.C2 * c2_o + s.I * i_o - s.O * (o_c2 + o_i),
        "I": s.C2 * c2_i + s.O * o_i - s.I * (i_c2 + i_o),
    }
