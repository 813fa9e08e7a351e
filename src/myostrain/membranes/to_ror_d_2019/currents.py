"""Currents of the ToR-ORd membrane, pA/pF."""

from typing import Any

from myostrain.membranes.channels import drift
from myostrain.membranes.to_ror_d_2019.exchangers import exchanger, pump
from myostrain.membranes.to_ror_d_2019.states import States

import numpy as np


def phosphorylated(p: Any, s: States) -> tuple[Any, Any, Any]:
    """CaMK bound to calmodulin, active CaMK, and the share of targets that it has phosphorylated."""
    bound = p.CaMKo * (1.0 - s.CaMKt) * s.cass / (s.cass + p.KmCaM)
    active = bound + s.CaMKt
    return bound, active, active / (active + p.KmCaMK)


def activity(p: Any, ions: Any) -> Any:
    """Davies' coefficient of single charges at ionic strength (M); its 4th power is that of double ones."""
    root = np.sqrt(ions)
    strength = 1.82e6 * (p.dielConstant * p.T) ** -1.5
    return np.exp(strength * (0.3 * ions - root / (1.0 + root)))


def currents(p: Any, v: Any, s: States) -> dict[str, Any]:
    """All currents by name.

    Args:
        p: The membrane with its parameters.
        v: Potential, mV.
        s: Its states.
    """
    thermal = p.R * p.T / p.F
    y = v / thermal
    log_k = np.log(p.ko)
    from_na = v - thermal * (np.log(p.nao) - np.log(s.nai))
    from_k = v - thermal * (log_k - np.log(s.ki))
    from_ks = v - thermal * (np.log(p.ko + p.PKNa * p.nao) - np.log(s.ki + p.PKNa * s.nai))
    from_cl = v - thermal * (np.log(p.cli) - np.log(p.clo))
    root_k = np.sqrt(p.ko / 5.0)
    share = phosphorylated(p, s)[2]
    cai = 1e-3 * s.cai

    fast = (1.0 - share) * s.h * s.j + share * s.hp * s.jp
    late = (1.0 - share) * s.hL + share * s.hLp
    rapid = 1.0 / (1.0 + np.exp((v - 213.6) / 151.2))
    plain = s.a * (rapid * s.iF + (1.0 - rapid) * s.iS)
    changed = s.ap * (rapid * s.iFp + (1.0 - rapid) * s.iSp)
    # α/(α + β) of the inward rectifier with α = 4.094/a and β = b/c.
    a = 1.0 + np.exp(0.1217 * (from_k - 49.934))
    b = 15.72 * np.exp(0.0674 * (from_k - 3.257)) + np.exp(0.0618 * (from_k - 594.31))
    c = 1.0 + np.exp(-0.1629 * (from_k + 14.207))
    rectified = 1.0 / (1.0 + a * b / (4.094 * c))
    by_calcium = 1.0 + 0.6 / (1.0 + np.exp(1.4 * (np.log(0.038) - np.log(s.cai))))
    pumped = pump(p, y, s.nai, s.ki)
    return {
        "Na": p.GNa * s.m * s.m * s.m * fast * from_na,
        "NaL": p.GNaL * s.mL * late * from_na,
        "to": p.Gto * ((1.0 - share) * plain + share * changed) * from_k,
        "Kr": p.GKr * root_k * s.O * from_k,
        "Ks": p.GKs * by_calcium * s.xs1 * s.xs2 * from_ks,
        "K1": p.GK1 * root_k * rectified * from_k,
        "Kb": p.GKb * from_k / (1.0 + np.exp((10.8968 - v) / 23.9871)),
        "NaCa_i": (1.0 - p.INaCa_fractionSS) * p.Gncx * exchanger(p, y, s.nai, cai),
        "NaCa_ss": p.INaCa_fractionSS * p.Gncx * exchanger(p, y, s.nass, s.cass),
        "NaK": p.Pnak * pumped,
        "pCa": p.GpCa * cai / (p.KmCap + cai),
        "ClCa": p.GClCa * from_cl * s.cass / (s.cass + p.KdClCa),
        "Clb": p.GClb * from_cl,
        **_constant_field(p, v, s, share, cai),
    }


def _constant_field(p: Any, v: Any, s: States, share: Any, cai: Any) -> dict[str, Any]:
    """The L-type channel, which three ions pass in two spaces, and the sodium and calcium backgrounds."""
    y = v / (p.R * p.T / p.F)
    fall = np.exp(-y)
    single = p.F * drift(y, fall)
    double = 4.0 * single / (1.0 + fall)  # 2 y/(1 − exp(−2 y)), from the one of y
    square = fall * fall

    root = np.exp(v / 20.0)
    fast = 0.3 + 0.6 / (1.0 + np.exp(-1.0) * root * root)
    slow = (1.0 - fast) * s.fcas
    by_voltage = p.Aff * s.ff + (1.0 - p.Aff) * s.fs
    by_voltage_p = p.Aff * s.ffp + (1.0 - p.Aff) * s.fs
    by_calcium = s.jca * (fast * s.fcaf + slow)
    by_calcium_p = s.jca * (fast * s.fcafp + slow)

    outside = activity(p, 0.5e-3 * (p.nao + p.ko + p.clo + 4.0 * p.cao))
    nao, ko, cao = outside * p.nao, outside * p.ko, outside**4 * p.cao
    found = {}
    spaces = (
        ("i", 1.0 - p.ICaL_fractionSS, s.nai, s.ki, cai, s.nca_i),
        ("ss", p.ICaL_fractionSS, s.nass, s.kss, s.cass, s.nca_ss),
    )
    for space, part, na, k, ca, n in spaces:
        inside = activity(p, 0.5e-3 * (na + k + p.cli + 4.0 * ca))
        inside2 = inside * inside
        calcium = double * (inside2 * inside2 * ca - cao * square)
        plain = by_voltage + n * (by_calcium - by_voltage)
        changed = by_voltage_p + n * (by_calcium_p - by_voltage_p)
        opened = (part * p.PCa) * s.d * (plain + share * (1.1 * changed - plain))
        found[f"CaL_{space}"] = opened * calcium
        found[f"CaNa_{space}"] = 0.00125 * opened * single * (inside * na - nao * fall)
        found[f"CaK_{space}"] = 3.574e-4 * opened * single * (inside * k - ko * fall)
        if space == "i":
            found["Cab"] = p.PCab * calcium
    found["Nab"] = p.PNab * single * (s.nai - p.nao * fall)
    return found
