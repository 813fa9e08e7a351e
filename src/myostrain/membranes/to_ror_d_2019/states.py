"""The states of ToR-ORd by name."""

from typing import Any, NamedTuple


class States(NamedTuple):
    """Concentrations in mM but ``cai`` in μM; fluxes in mM/ms; the rest are probabilities.

    Here "i" is the cytosol and "ss" the subspace at the junction; "nsr" and "jsr" are the network and the
    junction of the reticulum; a name that ends in "p" belongs to what CaMK has phosphorylated.
    """

    nai: Any
    nass: Any
    ki: Any
    kss: Any
    cai: Any
    cass: Any
    cansr: Any
    cajsr: Any
    CaMKt: Any
    Jrel_np: Any
    Jrel_p: Any
    # Fast and late sodium.
    m: Any
    h: Any
    hp: Any
    j: Any
    jp: Any
    mL: Any
    hL: Any
    hLp: Any
    # Transient outward.
    a: Any
    iF: Any
    iS: Any
    ap: Any
    iFp: Any
    iSp: Any
    # L-type calcium.
    d: Any
    ff: Any
    fs: Any
    fcaf: Any
    fcas: Any
    ffp: Any
    fcafp: Any
    jca: Any
    nca_ss: Any
    nca_i: Any
    # Slow rectifier, and the five conformations of the rapid one.
    xs1: Any
    xs2: Any
    C0: Any
    C1: Any
    C2: Any
    O: Any
    I: Any


#: Probabilities: gates and conformations of channels.
GATES = States._fields[11:]
