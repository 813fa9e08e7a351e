"""The ToR-ORd membrane: what it declares, its parameters and its sets."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Final, Literal

from myostrain.membranes.parameter_sets import OF_SET, fill_from_set
from myostrain.membranes.to_ror_d_2019.concentrations import concentration_rates
from myostrain.membranes.to_ror_d_2019.currents import currents
from myostrain.membranes.to_ror_d_2019.gates import gate_rates
from myostrain.membranes.to_ror_d_2019.initial import INITIAL
from myostrain.membranes.to_ror_d_2019.states import GATES, States
from myostrain.validation import Flag, NonNegative, Number, Positive, description

#: Endocardial values of the parameters that tell the layers of the wall apart.
_ENDO: Final[Mapping[str, Any]] = {
    "GNaL": 0.0279,
    "Gto": 0.16,
    "PCa": 8.3757e-05,
    "GKr": 0.0321,
    "GKs": 0.0011,
    "GK1": 0.6992,
    "GKb": 0.0189,
    "Gncx": 0.0034,
    "Pnak": 15.4509,
    "cmdnmax": 0.05,
    "upScale": 1.0,
    "relScale": 1.0,
}

#: What the other layers multiply them by.
_FACTORS: Final[Mapping[str, Mapping[str, float]]] = {
    "ENDO": {},
    "EPI": {
        "GNaL": 0.6,
        "Gto": 2.0,
        "PCa": 1.2,
        "GKr": 1.3,
        "GKs": 1.4,
        "GK1": 1.2,
        "GKb": 0.6,
        "Gncx": 1.1,
        "Pnak": 0.9,
        "cmdnmax": 1.3,
        "upScale": 1.3,
    },
    "MID": {
        "Gto": 2.0,
        "PCa": 2.0,
        "GKr": 0.8,
        "GK1": 1.3,
        "Gncx": 1.4,
        "Pnak": 0.7,
        "relScale": 1.7,
    },
}

SETS: Final[Mapping[str, Mapping[str, Any]]] = {
    layer: {name: value * factors.get(name, 1.0) for name, value in _ENDO.items()}
    | {"delta_epi": layer == "EPI"}
    for layer, factors in _FACTORS.items()
}


@description
class ToRORd2019:
    """ToR-ORd human ventricle of Tomek et al., doi 10.7554/eLife.48890; mV, ms, mM.

    This is the model of 2019, with constant chloride. The state ``cai`` alone is counted in μM, since it
    drives contraction. Currents are in pA/pF, which is mV/ms. The published model adds the stimulus to the
    balance of potassium; no membrane here sees it. The states at rest are those that the authors publish, of
    a cell paced at 1 Hz: no equilibrium. Equations as in the authors' public code.

    Args:
        set: Layer of the wall: "ENDO", "EPI" or "MID".
        GNa: Conductance of the fast sodium current, mS/μF; so are all conductances G.
        GNaL: Of the late sodium current; from the set.
        thL: Time constant of its inactivation, ms.
        Gto: Of the transient outward current; from the set.
        delta_epi: Whether that current inactivates as in the epicardium; from the set.
        PCa: Permeability of the L-type channel to calcium, cm³/(F s); from the set.
        Aff: Share of its fast inactivation by voltage.
        ICaL_fractionSS: Share of the channels that open into the subspace.
        Kmn: Half saturation of its inactivation by calcium, mM.
        k2n: Rate of that inactivation, 1/ms.
        tjca: Time constant of recovery from it, ms.
        dielConstant: Dielectric constant of water, for the activity of ions.
        GKr: Of the rapid delayed rectifier; from the set.
        alpha_1: Rate of its step C1 to C2, 1/ms.
        beta_1: Rate of its step C2 to C1, 1/ms.
        GKs: Of the slow delayed rectifier; from the set.
        PKNa: Its permeability to sodium, relative to potassium.
        GK1: Of the inward rectifier; from the set.
        GKb: Of the potassium background; from the set.
        PNab: Permeability of the sodium background, cm³/(F s).
        PCab: Permeability of the calcium background, cm³/(F s).
        GpCa: Largest current of the sarcolemmal calcium pump, pA/pF.
        KmCap: Its half saturation, mM.
        GClCa: Of the chloride current that calcium activates; all of it is in the subspace.
        KdClCa: Its half saturation, mM.
        GClb: Of the chloride background.
        Gncx: Strength of the sodium–calcium exchanger, pA/pF; from the set.
        INaCa_fractionSS: Its share in the subspace.
        KmCaAct: Half saturation of its activation by calcium, mM.
        kasymm: Its asymmetry.
        kcaon: Rate of binding calcium, 1/(mM ms).
        kcaoff: Rate of losing calcium, 1/ms.
        kna1: Its first half saturation by sodium, mM.
        kna2: Its second, mM.
        kna3: Its third, mM.
        qna: Share of the potential that sodium sees.
        qca: Share of the potential that calcium sees.
        wna: Rate of turning with sodium, 1/ms.
        wca: Rate of turning with calcium, 1/ms.
        wnaca: Rate of turning with both, 1/ms.
        Pnak: Strength of the sodium–potassium pump, pA/pF; from the set.
        k1p: First forward rate of the pump, 1/ms; so are the others.
        k1m: First backward rate, per mM of ADP.
        k2p: Second forward rate.
        k2m: Second backward rate.
        k3p: Third forward rate.
        k3m: Third backward rate, per mM of phosphate and protons.
        k4p: Fourth forward rate.
        k4m: Fourth backward rate.
        Knai0: Half saturation by sodium inside, at 0 mV, mM.
        Knao0: Half saturation by sodium outside, at 0 mV, mM.
        delta: Share of the potential that sodium sees inside.
        Kki: Half saturation by potassium inside, mM.
        Kko: Half saturation by potassium outside, mM.
        MgADP: Magnesium ADP, mM.
        MgATP: Magnesium ATP, mM.
        Kmgatp: Its half saturation, mM.
        H: Protons, mM.
        eP: Phosphate, mM.
        Khp: Half saturation of phosphate by protons, mM.
        Knap: By sodium, mM.
        Kxkur: By potassium, mM.
        CaMKo: Share of CaMK that calmodulin can bind.
        KmCaM: Half saturation of that by calcium, mM.
        KmCaMK: Half saturation of targets by CaMK.
        aCaMK: Rate of trapping, 1/ms.
        bCaMK: Rate of release from the trap, 1/ms.
        Jrel_b: Strength of the release of calcium.
        relScale: Factor of its steady value; from the set.
        bt: Its time constant, ms.
        cajsr_half: Half saturation of it by the junction's calcium, mM.
        Jup_b: Strength of the uptake of calcium and of its leak.
        upScale: Factor of the uptake; from the set.
        cmdnmax: Calmodulin, mM; from the set.
        kmcmdn: Its half saturation, mM.
        trpnmax: Troponin, mM.
        kmtrpn: Its half saturation, mM.
        BSRmax: Buffer of the subspace at the reticulum, mM.
        KmBSR: Its half saturation, mM.
        BSLmax: Buffer of the subspace at the sarcolemma, mM.
        KmBSL: Its half saturation, mM.
        csqnmax: Calsequestrin, mM.
        kmcsqn: Its half saturation, mM.
        tauNa: Time of diffusion of sodium out of the subspace, ms.
        tauK: Of potassium, ms.
        tauCa: Of calcium, ms.
        nao: Sodium outside, mM.
        ko: Potassium outside, mM.
        cao: Calcium outside, mM.
        clo: Chloride outside, mM.
        cli: Chloride inside, mM.
        L: Length of the cell, cm.
        rad: Its radius, cm.
        R: Gas constant, mJ/(mol K).
        T: Temperature, K.
        F: Faraday's constant, C/mol.
    """

    set: Literal["ENDO", "EPI", "MID"] = "ENDO"
    GNa: NonNegative = 11.7802
    GNaL: NonNegative = OF_SET
    thL: Positive = 200.0
    Gto: NonNegative = OF_SET
    delta_epi: Flag = OF_SET
    PCa: NonNegative = OF_SET
    Aff: NonNegative = 0.6
    ICaL_fractionSS: NonNegative = 0.8
    Kmn: Positive = 0.002
    k2n: Positive = 500.0
    tjca: Positive = 75.0
    dielConstant: Positive = 74.0
    GKr: NonNegative = OF_SET
    alpha_1: NonNegative = 0.154375
    beta_1: NonNegative = 0.1911
    GKs: NonNegative = OF_SET
    PKNa: NonNegative = 0.01833
    GK1: NonNegative = OF_SET
    GKb: NonNegative = OF_SET
    PNab: NonNegative = 1.9239e-09
    PCab: NonNegative = 5.9194e-08
    GpCa: NonNegative = 0.0005
    KmCap: Positive = 0.0005
    GClCa: NonNegative = 0.2843
    KdClCa: Positive = 0.1
    GClb: NonNegative = 0.00198
    Gncx: NonNegative = OF_SET
    INaCa_fractionSS: NonNegative = 0.35
    KmCaAct: Positive = 0.00015
    kasymm: NonNegative = 12.5
    kcaon: Positive = 1.5e6
    kcaoff: Positive = 5000.0
    kna1: Positive = 15.0
    kna2: Positive = 5.0
    kna3: Positive = 88.12
    qna: NonNegative = 0.5224
    qca: NonNegative = 0.167
    wna: Positive = 60000.0
    wca: Positive = 60000.0
    wnaca: Positive = 5000.0
    Pnak: NonNegative = OF_SET
    k1p: Positive = 949.5
    k1m: Positive = 182.4
    k2p: Positive = 687.2
    k2m: Positive = 39.4
    k3p: Positive = 1899.0
    k3m: Positive = 79300.0
    k4p: Positive = 639.0
    k4m: Positive = 40.0
    Knai0: Positive = 9.073
    Knao0: Positive = 27.78
    delta: Number = -0.155
    Kki: Positive = 0.5
    Kko: Positive = 0.3582
    MgADP: Positive = 0.05
    MgATP: Positive = 9.8
    Kmgatp: Positive = 1.698e-07
    H: Positive = 1e-07
    eP: Positive = 4.2
    Khp: Positive = 1.698e-07
    Knap: Positive = 224.0
    Kxkur: Positive = 292.0
    CaMKo: NonNegative = 0.05
    KmCaM: Positive = 0.0015
    KmCaMK: Positive = 0.15
    aCaMK: NonNegative = 0.05
    bCaMK: NonNegative = 0.00068
    Jrel_b: NonNegative = 1.5378
    relScale: NonNegative = OF_SET
    bt: Positive = 4.75
    cajsr_half: Positive = 1.7
    Jup_b: NonNegative = 1.0
    upScale: NonNegative = OF_SET
    cmdnmax: NonNegative = OF_SET
    kmcmdn: Positive = 0.00238
    trpnmax: NonNegative = 0.07
    kmtrpn: Positive = 0.0005
    BSRmax: NonNegative = 0.047
    KmBSR: Positive = 0.00087
    BSLmax: NonNegative = 1.124
    KmBSL: Positive = 0.0087
    csqnmax: NonNegative = 10.0
    kmcsqn: Positive = 0.8
    tauNa: Positive = 2.0
    tauK: Positive = 2.0
    tauCa: Positive = 0.2
    nao: Positive = 140.0
    ko: Positive = 5.0
    cao: Positive = 1.8
    clo: Positive = 150.0
    cli: Positive = 24.0
    L: Positive = 0.01
    rad: Positive = 0.0011
    R: Positive = 8314.0
    T: Positive = 310.0
    F: Positive = 96485.0
    sets: ClassVar[Mapping[str, Mapping[str, Any]]] = SETS
    states: ClassVar[tuple[str, ...]] = States._fields
    gates: ClassVar[tuple[str, ...]] = GATES
    conserved: ClassVar[tuple[str, ...]] = ()
    time_unit: ClassVar[str | None] = "ms"
    potential_unit: ClassVar[str | None] = "mV"
    range: ClassVar[tuple[float, float]] = (-92.0, 45.0)
    threshold: ClassVar[float] = 0.0
    calcium: ClassVar[str | None] = "cai"
    calcium_unit: ClassVar[str | None] = "μM"
    pacing: ClassVar[tuple[float, float] | None] = (53.0, 1.0)

    def __post_init__(self) -> None:
        """Take from the set what is not given."""
        fill_from_set(self, self.sets)

    def resting_potential(self) -> float:
        """The published initial potential of the set, mV."""
        return INITIAL[self.set][0]

    def resting_states(self) -> tuple[float, ...]:
        """The published initial states of the set; no equilibrium."""
        return INITIAL[self.set][1:]

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """Sum of all currents of the membrane, pA/pF."""
        return sum(currents(self, v, States(*states)).values())

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """Rate of each state, in their order."""
        s = States(*states)
        found = {**concentration_rates(self, s, currents(self, v, s)), **gate_rates(self, v, s)}
        return tuple(found[name] for name in self.states)
