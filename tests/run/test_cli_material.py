"""``myostrain material``: the curves that it draws, and what it says of wrong input."""

from pathlib import Path

from myostrain import materials
from myostrain.output.figures import material as figures_material

import numpy as np
import pytest
from PIL import Image

from small_cases import command_line

SOLIDS = ["Arostica2025", "Guccione1995", "HolzapfelOgden2009", "MooneyRivlin", "NeoHookean", "Usyk2002"]


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """The figures that are saved; commands are called in an empty folder."""
    figures = []
    save = figures_material.save

    def spy(figure, path):
        figures.append(figure)
        return save(figure, path)

    monkeypatch.setattr(figures_material, "save", spy)
    monkeypatch.chdir(tmp_path)
    return figures


def curves(panel):
    """Data of a panel's curves by the word of the legend."""
    lines = dict(zip([t.get_text() for t in panel.get_legend().get_texts()], panel.get_lines(), strict=False))
    return {word: line.get_data() for word, line in lines.items()}


def test_curves_of_neo_hookean(drawn):
    """Closed forms of the incompressible material: μ(λ² − 1/λ), μ(λ² − λ⁻⁴), μκ; μ is what --set gives."""
    done = command_line("material", "NeoHookean", "--set", "mu=2.5", "--unit", "kPa", "--out", "curves.png")
    assert (done.status, done.out, done.err) == (0, "curves.png\n", "")
    (figure,) = drawn
    assert "mu = 2.5" in figure.get_suptitle().replace("\N{NO-BREAK SPACE}", " ")
    uniaxial, equibiaxial, shear = figure.axes
    forms = {
        uniaxial: ("fibre f, sheet s, normal n", lambda x: 2.5 * (x**2 - 1 / x)),
        equibiaxial: ("fibre f, sheet s", lambda x: 2.5 * (x**2 - x**-4)),
        shear: ("fs, fn, sf, sn, nf, ns", lambda x: 2.5 * x),
    }
    for panel, (names, form) in forms.items():
        assert list(curves(panel)) == [names]
        x, y = curves(panel)[names]
        assert np.ptp(x) >= 0.3 - 1e-12
        np.testing.assert_allclose(y, form(x), rtol=0, atol=1e-12)  # measured 2e-15
        assert panel.get_ylabel() == "Cauchy stress (kPa)"


def test_curves_of_usyk_differ_by_direction(drawn):
    """An orthotropic material has a curve each; by Usyk et al. 2002 (bff largest) fibres are stiffest."""
    assert command_line("material", "Usyk2002").status == 0
    uniaxial = curves(drawn[0].axes[0])
    assert list(uniaxial) == ["fibre f", "sheet s", "normal n"]
    ends = [uniaxial[word][1][-1] for word in uniaxial]
    assert ends == sorted(ends, reverse=True)
    assert ends[0] > 1.1 * ends[1] > 1.2 * ends[2]


def test_picture(drawn):
    """Without --out the picture is NAME.png; it is replaced when there is one."""
    for _ in range(2):
        done = command_line("material", "Guccione1995", "--set", "C=2", "--set", "bf=8.0")
        assert (done.status, done.out) == (0, "Guccione1995.png\n")
    with Image.open("Guccione1995.png") as picture:
        image = np.asarray(picture.convert("RGB")).astype(int)
    assert min(image.shape[:2]) > 400
    assert len(np.unique(image @ [1, 256, 65536])) > 100


def test_list(drawn):
    """Without NAME the materials for solids are listed, with their parameters."""
    done = command_line("material")
    assert [line.split()[0] for line in done.out.splitlines()] == SOLIDS
    assert "mu = 1" in done.out
    assert f"C = {materials.Usyk2002().C}" in done.out


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["NeoHokean"], ["NAME", "did you mean 'NeoHookean'", "Usyk2002"]),
        (["Rubber"], ["NAME", "known: ", *SOLIDS]),
        (["Spring"], ["NAME", "Spring is for a line"]),
        (["NeoHookean", "--set", "nu=1"], ["material.nu", "did you mean 'mu'"]),
        (["NeoHookean", "--set", "mu=-1"], ["material.mu", "greater than 0", "-1"]),
        (["NeoHookean", "--set", "mu=soft"], ["material.mu", "give a number", "soft"]),
        (["NeoHookean", "--set", "mu"], ["--set", "KEY=VALUE"]),
        (["NeoHookean", "--out", "curves.xyz"], ["--out", "curves.xyz", ".png"]),
        (["NeoHookean", "--out", "nowhere/curves.png"], ["nowhere/curves.png cannot be written"]),
    ],
    ids=lambda x: " ".join(x) if x[0] in (*SOLIDS, "NeoHokean", "Rubber", "Spring") else "",
)
def test_wrong_input(drawn, arguments, said):
    """Interface: exit status 2, one message: the key, the value, what is allowed, the nearest known."""
    done = command_line("material", *arguments)
    assert (done.status, done.out) == (2, "")
    for words in said:
        assert words in done.err
    assert done.err.startswith("myostrain: ")
    assert list(Path().iterdir()) == []


def test_help():
    """The help says what is drawn, and what each option is for."""
    done = command_line("material", "--help")
    assert done.status == 0
    for words in ("uniaxial, equibiaxial and in simple shear", "KEY=VALUE", "FILE.png", "--unit"):
        assert words in " ".join(done.out.split())
