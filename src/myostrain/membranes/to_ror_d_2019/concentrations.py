"""Rates of the concentrations of ToR-ORd, of its release of calcium and of CaMK."""

from typing import Any

from myostrain.membranes.to_ror_d_2019.currents import phosphorylated
from myostrain.membranes.to_ror_d_2019.states import States

import numpy as np

#: Shares of the volume of the cell.
MYO, NSR, JSR, SS = 0.68, 0.0552, 0.0048, 0.02


def concentration_rates(p: Any, s: States, i: dict[str, Any]) -> dict[str, Any]:
    """Rate of each by name: mM/ms, but μM/ms of ``cai``.

    Args:
        p: The membrane with its parameters.
        s: Its states.
        i: Its currents.
    """
    # The codes of the authors take 3.14 for π.
    volume = 1000.0 * 3.14 * p.rad * p.rad * p.L
    area = 2.0 * (2.0 * 3.14 * p.rad * p.rad + 2.0 * 3.14 * p.rad * p.L)
    myo, ss = area / (p.F * MYO * volume), area / (p.F * SS * volume)
    cai = 1e-3 * s.cai
    bound, active, share = phosphorylated(p, s)

    # Release: currents of calcium open it, as far as the junction is filled. One that empties, as that of MID
    # does, shuts it within a microsecond, even if a step leaves a little less than nothing there.
    filled = _eighth(s.cajsr) / (_eighth(s.cajsr) + _eighth(p.cajsr_half))
    steady = (-0.5 * p.bt * p.relScale) * i["CaL_ss"] * filled
    tau = p.bt * s.cajsr / (s.cajsr + 0.0123)
    release = p.Jrel_b * (s.Jrel_np + share * (s.Jrel_p - s.Jrel_np))

    plain, changed = cai / (cai + 0.00092), 2.75 * cai / (cai + 0.00075)
    uptake = (0.005425 * p.upScale) * (plain + share * (changed - plain)) - (0.0048825 / 15.0) * s.cansr
    uptake = p.Jup_b * uptake
    refill = (s.cansr - s.cajsr) / 60.0
    to_na, to_k, to_ca = (s.nass - s.nai) / p.tauNa, (s.kss - s.ki) / p.tauK, (s.cass - cai) / p.tauCa

    free_i = 1.0 / (1.0 + _bound(cai, p.cmdnmax, p.kmcmdn) + _bound(cai, p.trpnmax, p.kmtrpn))
    free_ss = 1.0 / (1.0 + _bound(s.cass, p.BSRmax, p.KmBSR) + _bound(s.cass, p.BSLmax, p.KmBSL))
    sodium = i["Na"] + i["NaL"] + i["Nab"] + i["CaNa_i"] + 3.0 * (i["NaCa_i"] + i["NaK"])
    potassium = i["to"] + i["Kr"] + i["Ks"] + i["K1"] + i["Kb"] + i["CaK_i"] - 2.0 * i["NaK"]
    calcium = 0.5 * (i["CaL_i"] + i["pCa"] + i["Cab"]) - i["NaCa_i"]
    return {
        "nai": (SS / MYO) * to_na - myo * sodium,
        "nass": -to_na - ss * (i["CaNa_ss"] + 3.0 * i["NaCa_ss"]),
        "ki": (SS / MYO) * to_k - myo * potassium,
        "kss": -to_k - ss * i["CaK_ss"],
        "cai": 1e3 * free_i * ((SS / MYO) * to_ca - (NSR / MYO) * uptake - myo * calcium),
        "cass": free_ss * ((JSR / SS) * release - to_ca - ss * (0.5 * i["CaL_ss"] - i["NaCa_ss"])),
        "cansr": uptake - (JSR / NSR) * refill,
        "cajsr": (refill - release) / (1.0 + _bound(s.cajsr, p.csqnmax, p.kmcsqn)),
        "CaMKt": p.aCaMK * bound * active - p.bCaMK * s.CaMKt,
        "Jrel_np": (steady - s.Jrel_np) / np.maximum(tau, 0.001),
        "Jrel_p": (1.25 * steady - s.Jrel_p) / np.maximum(1.25 * tau, 0.001),
    }


def _bound(c: Any, buffer: Any, half: Any) -> Any:
    """Calcium that a buffer takes up for each that stays free."""
    return buffer * half / ((c + half) * (c + half))


def _eighth(x: Any) -> Any:
    square = x * x
    return square * square * square * square
