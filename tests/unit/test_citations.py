"""What to cite for a run comes out of the objects that it is made of."""

import inspect
import re
from pathlib import Path

import myostrain as ms
from myostrain import activation, materials, membranes
from myostrain.output.citations import OF_CASE, OF_CLASS, bibtex, citations, entries

import pytest

DOCS = Path(__file__).parents[2] / "docs"

#: Shipped classes without a paper of their own: the paper's, or textbook ones.
PLAIN = {
    *("FileMembrane", "GeneralizedRushLarsen", "LinearlyImplicit", "RushLarsen", "Step"),
    *("MooneyRivlin", "NeoHookean", "Spring"),
    *("ActiveStress", "Fibre", "FibreTension", "Proportional", "Relaxing", "Timed", "NodalActivation"),
}


class Mine:
    """A law of one's own."""

    drivers, doi = ("excitation",), "10.1000/mine"

    def activation(self, states, drivers):
        return -0.1 * drivers["excitation"]


def model(law=None, **mechanics):
    body = ms.build(ms.geometry.Line(length=2.0, spacing=1.0))
    membrane = ms.membranes.BuenoOrovio2008()
    potential = ms.Potential(body, membrane=membrane, diffusivity=0.1)
    parts = {"kinematics": ms.kinematics.Line(), "material": ms.materials.Spring(mu=1.0)}
    held = ms.Mechanics(body, **parts, supports=ms.Supports(fixed=["left"]), **mechanics)
    return ms.Electromechanics(potential, held, law=law or ms.activation.Proportional(beta=0.1))


def keys(found):
    return [each["key"] for each in found]


@pytest.mark.parametrize("module", [membranes, materials, activation])
def test_every_shipped_class_says_its_paper(module):
    """A model of a paper, named after it, is cited; nothing is cited that is not there."""
    shipped = {name for name in module.__all__ if hasattr(getattr(module, name), "__dataclass_fields__")}
    named = {name for name in shipped if re.search(r"(19|20)\d\d$", name)}
    assert named <= OF_CLASS.keys()
    assert shipped <= OF_CLASS.keys() | PLAIN
    assert {key for value in OF_CLASS.values() for key in value} | set(OF_CASE.values()) <= entries().keys()


def test_a_doi_is_that_of_the_docstring():
    """Where a docstring gives the DOI of its class, that is what is cited."""
    compared = 0
    for module in (materials, activation):
        for name in set(module.__all__) & OF_CLASS.keys():
            said = set(re.findall(r"10\.\d{4,}/[^\s,;]+[^\s,;.:]", inspect.getdoc(getattr(module, name))))
            cited = {re.search(r"doi = \{(.+?)\}", entries()[key])[1] for key in OF_CLASS[name]}
            if said:
                assert cited & said, name
                compared += 1
    assert compared >= 8


def test_dois_are_those_of_the_documentation():
    """The pages give the same DOI, but for that of the engine and of a textbook membrane."""
    pages = "".join(path.read_text(encoding="utf-8") for path in DOCS.glob("*.md"))
    for key, entry in entries().items():
        if key not in ("myostrain", "baratta2023", "fitzhugh1961"):
            assert re.search(r"doi = \{(.+?)\}", entry)[1] in pages, key


def test_a_run_says_what_to_cite(tmp_path):
    """The membrane's and the law's, an own object's DOI, in ``results.json`` and as BibTeX."""
    simulation = ms.Simulation(model(Mine()), step=0.1, end=0.1, out=tmp_path / "out")
    results = simulation.run()
    assert keys(results["citations"]) == [
        "myostrain",
        "ambrosi2011",
        "baratta2023",
        "buenoorovio2008",
        "Mine",
    ]
    text = (tmp_path / "out" / "references.bib").read_text(encoding="utf-8")
    assert text == bibtex(results["citations"])
    assert text.count("\n}") == text.count("@") == 5
    assert f"version = {{{ms.__version__}}}" in text
    assert "doi = {10.1000/mine}" in text
    assert "10.1016/j.jtbi.2008.03.029" in text


def test_what_a_case_adds():
    """Fibres of a rule, a benchmark, electrodes, inertia: each only where it is."""
    case = {"name": "land-2", "parameters": {"fibres": {"kind": "rule-based"}}}
    found = keys(citations(model(density=1.0), case, electrodes=True))
    assert found[4:] == ["bayer2012", "land2015", "chung1993", "gima2002"]
    assert keys(citations(model(), {"name": "mine"})) == found[:4]
