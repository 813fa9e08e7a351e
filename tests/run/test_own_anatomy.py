"""The case of docs/howto/own-anatomy.md, from a file with fibres to a loop."""

import re
from pathlib import Path

import myostrain as ms
from myostrain import Case, run_case

import numpy as np

from small_cases import ALONE

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "own-anatomy.md"


def test_from_a_file_with_fibres_to_a_loop(tmp_path):
    """The page's file, as it is there, on the page's ventricle, made coarser: the cavity is shut and pressed.

    It begins with the preload; the volume stays while both valves are shut.
    """
    (text,) = re.findall(r"<!-- own\.toml -->\n```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    ventricle = ms.geometry.Ventricle(
        endocardium=(21.0, 52.0), epicardium=(30.0, 61.0), base=17.0, spacing=20.0, layers=1
    )
    body = ms.build(ventricle, ms.geometry.RuleBasedFibres(), ALONE)
    ms.geometry.write_opencarp(body, tmp_path / "heart", scale=1e3)
    case = Case.from_file(tmp_path / "own.toml", ["time.end=4.0", "output.every=4.0"])
    results = run_case(case, tmp_path / "out", comm=ALONE, figures=False)
    assert results["metrics"]["volume_max"] > 60e3
    table = np.genfromtxt(tmp_path / "out" / "cavities.csv", delimiter=",", names=True)
    assert len(table) == 3
    assert table["pressure_endocardium"][0] == 1.07
    np.testing.assert_allclose(table["volume_endocardium"], table["volume_endocardium"][0], rtol=1e-3)
    first, *_, last = (tmp_path / "out" / "measures.csv").read_text().splitlines()
    assert {"radial_strain_17", "fibre_stress_1", "torsion"} <= set(first.split(","))
    assert len(last.split(",")) == len(first.split(","))
