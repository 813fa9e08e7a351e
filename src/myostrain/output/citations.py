"""What to cite for a run: the papers behind the objects that it is made of."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import myostrain

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics

#: What every run rests on.
ALWAYS = {"software": "myostrain", "active strain": "ambrosi2011", "finite elements": "baratta2023"}

#: Keys of ``references.bib`` by the name of a class; FentonKarma1998 has a second paper for most of its sets.
OF_CLASS: dict[str, tuple[str, ...]] = {
    "FitzHughNagumo": ("fitzhugh1961",),
    "AlievPanfilov1996": ("aliev1996",),
    "MitchellSchaeffer2003": ("mitchell2003",),
    "FentonKarma1998": ("fenton1998", "fenton2002"),
    "BuenoOrovio2008": ("buenoorovio2008",),
    "LuoRudy1991": ("luo1991",),
    "TenTusscherPanfilov2006": ("tentusscher2006",),
    "ToRORd2019": ("tomek2019",),
    "Guccione1995": ("guccione1991", "guccione1995", "land2015"),
    "HolzapfelOgden2009": ("holzapfel2009",),
    "Usyk2002": ("usyk2002",),
    "Arostica2025": ("arostica2025",),
    "Bestel2001": ("bestel2001", "arostica2025"),
    "NashPanfilov2004": ("nash2004",),
    "GoektepeKuhl2010": ("goektepe2010",),
    "Hunter1998": ("hunter1998",),
    "Rossi2014": ("rossi2014",),
    "TransverselyIsotropic": ("rossi2014",),
    "Orthotropic": ("rossi2014",),
    "EllipsoidalFibres": ("land2015",),
    "RuleBasedFibres": ("bayer2012",),
}

#: By the word of a case file.
OF_FIBRES = {"ellipsoidal": "EllipsoidalFibres", "rule-based": "RuleBasedFibres"}

#: By the beginning of the name of a case.
OF_CASE = {"land-": "land2015", "niederer-": "niederer2011", "arostica-": "arostica2025"}


@cache
def entries() -> dict[str, str]:
    """The BibTeX entries that ship, by key."""
    text = files("myostrain.output").joinpath("references.bib").read_text(encoding="utf-8")
    found = {}
    for entry in re.split(r"\n(?=@)", text.strip()):
        match = re.match(r"@\w+\{(\w+),", entry)
        if match:
            found[match[1]] = entry.strip()
    return found


def citations(
    model: Electromechanics, case: Mapping[str, Any], electrodes: bool = False
) -> list[dict[str, str]]:
    """What to cite for a run: dictionaries with "what" it is for, the "key" and, if there is one, the "doi".

    An object of one's own is cited if it has an attribute ``doi``.

    Args:
        model: The coupled problem.
        case: Name and parameters of the case, as ``results.json`` has them.
        electrodes: Whether potentials at electrodes were computed.
    """
    found = [_entry(what, key) for what, key in ALWAYS.items()]
    for what, thing in _parts(model):
        name = type(thing).__name__
        own = getattr(thing, "doi", None)
        if own:
            found.append({"what": f"{what} {name}", "key": name, "doi": str(own)})
        found += [_entry(f"{what} {name}", key) for key in OF_CLASS.get(name, ())]
    parameters = case.get("parameters", {})
    rule = OF_FIBRES.get(str((parameters.get("fibres") or {}).get("kind")), "")
    found += [_entry("fibres", key) for key in OF_CLASS.get(rule, ())]
    name = str(case.get("name", ""))
    found += [_entry("benchmark", key) for prefix, key in OF_CASE.items() if name.startswith(prefix)]
    if getattr(model.mechanics, "motion", None) is not None:
        found.append(_entry("inertia", "chung1993"))
    if "stretch_current" in (parameters.get("cell") or {}):
        found.append(_entry("stretch-activated current", "panfilov2005"))
    if electrodes:
        found.append(_entry("electrocardiogram", "gima2002"))
    return found


def bibtex(cited: Sequence[Mapping[str, str]]) -> str:
    """What is cited as a BibTeX file, each entry once.

    Args:
        cited: What :func:`citations` gives.
    """
    known, made = entries(), {}
    for each in cited:
        key = each["key"]
        if key == "myostrain":
            made[key] = known[key].replace("\n}", f"\n  version = {{{myostrain.__version__}}},\n}}")
        else:
            own = f"@misc{{{key},\n  title = {{{key}}},\n  doi = {{{each.get('doi', '')}}},\n}}"
            made[key] = known.get(key, own)
    return "\n\n".join(made.values()) + "\n"


def _entry(what: str, key: str) -> dict[str, str]:
    found = {"what": what, "key": key}
    if match := re.search(r"doi = \{(.+?)\}", entries()[key]):
        found["doi"] = match[1]
    return found


def _parts(model: Electromechanics) -> Iterator[tuple[str, Any]]:
    """The objects of a model, each with what it is."""
    if (membrane := getattr(model.potential, "membrane", None)) is not None:
        yield "membrane", membrane
    if model.activation is not None:
        yield "activation law", model.activation.law
    if model.mechanics is not None:
        yield "material", model.mechanics.material
        yield "active deformation", model.mechanics.active
