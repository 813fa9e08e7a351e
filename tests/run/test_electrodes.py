"""Potentials outside of the body, against closed forms and quadrature."""

from types import SimpleNamespace

import myostrain as ms
from myostrain.errors import InputError
from myostrain.kinematics import Deformation
from myostrain.output.electrodes import Electrodes

import numpy as np
import pytest
import ufl
from scipy.integrate import dblquad

from small_cases import ALONE, SOLID, changed


def leads(geometry, v, points, *, fibres=None, diffusivity=100.0, stretches=None):
    """Potentials at points of a body with the potential v(X), stretched along the axes."""
    body = ms.build(geometry, None if fibres is None else ms.UniformFibres(direction=fibres))
    stretched = stretches is not None
    F = np.diag(stretches if stretched else np.ones(body.dim))
    deformation = Deformation(ufl.as_matrix(F.tolist())) if stretched else None
    potential = ms.Potential(
        body, membrane=ms.membranes.FitzHughNagumo(), diffusivity=diffusivity, deformation=deformation
    )
    X = potential.v.function_space.tabulate_dof_coordinates()[:, : body.dim]
    potential.v.x.array[:] = v(X)
    model = SimpleNamespace(
        potential=potential,
        mechanics=object() if stretched else None,
        displacement=lambda: X @ (F - np.eye(body.dim)).T if stretched else None,
    )
    return Electrodes(model, {str(i): point for i, point in enumerate(points)}).values()


def test_a_line_in_closed_form():
    """v = 3 X on 0 ≤ X ≤ 10: −(3/4π)(1/r(10) − 1/r(0)), ahead of it, beside it and behind it."""
    points = [(13.0, 0.0, 0.0), (4.0, 2.0, 1.0), (-2.0, 0.0, 0.5)]
    found = leads(ms.geometry.Line(length=10.0, spacing=0.25), lambda X: 3 * X[:, 0], points)
    ends = [[1 / np.hypot(np.hypot(x - at, y), z) for at in (0.0, 10.0)] for x, y, z in points]
    np.testing.assert_allclose(found, [-3 / (4 * np.pi) * (b - a) for a, b in ends], rtol=1e-5)


def test_a_wave_that_comes_is_positive_and_one_that_goes_negative():
    """The sign of an electrocardiogram: v high behind the front, low before it."""
    front = lambda X: 1 / (1 + np.exp(2 * (X[:, 0] - 10)))  # noqa: E731
    ahead, behind = leads(ms.geometry.Line(length=20.0, spacing=0.25), front, [(25.0,), (-5.0,)])
    assert ahead > 0
    assert behind == pytest.approx(-ahead, rel=1e-3)


def faces(box, point):
    """∫∫ 1/r over the face at the end of a box less that at its beginning, along x, by SciPy."""
    (l, w, h), (x, y, z) = box, point
    over = [
        dblquad(lambda b, a, at=at: 1 / np.sqrt((x - at) ** 2 + (y - a) ** 2 + (z - b) ** 2), 0, w, 0, h)[0]
        for at in (0.0, l)
    ]
    return over[1] - over[0]


@pytest.mark.parametrize("stretches", [None, (1.25, 0.8, 1.0)], ids=["rigid", "deformed"])
def test_a_slab_by_quadrature(stretches):
    """v = 3 X: −(s/4π) of the faces' potentials, of the stretched slab, in which the slope s is 3 / λ."""
    box, points = (4.0, 3.0, 2.0), [(7.0, 1.0, 1.0), (1.2, 1.5, 4.5), (1.0, -2.0, -1.0)]
    found = leads(
        ms.geometry.Slab(size=box, spacing=0.4),
        lambda X: 3 * X[:, 0],
        points,
        fibres=(1.0, 0.0, 0.0),
        stretches=stretches,
    )
    factors = np.array(stretches or (1.0, 1.0, 1.0))
    exact = [-3 / factors[0] / (4 * np.pi) * faces(factors * box, point) for point in points]
    np.testing.assert_allclose(found, exact, rtol=2e-4)


def test_across_the_fibre_less_flows():
    """D = (100, 25): a gradient across the fibre counts a quarter."""
    slab = ms.geometry.Slab(size=(4.0, 3.0, 2.0), spacing=0.5)
    points = [(7.0, 1.0, 1.0)]
    v = lambda X: X[:, 0]  # noqa: E731
    (along,) = leads(slab, v, points, fibres=(1.0, 0.0, 0.0), diffusivity=(100.0, 25.0))
    (across,) = leads(slab, v, points, fibres=(0.0, 1.0, 0.0), diffusivity=(100.0, 25.0))
    assert across == pytest.approx(along / 4, rel=1e-12)


def test_a_case_writes_a_column_an_electrode(tmp_path):
    """ecg.csv, a row a sampled time; of a body that moves."""
    case = changed(SOLID, {"electrodes": {"V1": [2.5, 1.0, 4.0], "V2": [9.0, 0.0, 0.0]}})
    ms.run_case(ms.Case.from_dict(case), tmp_path, comm=ALONE, figures=False)
    header, *rows = (tmp_path / "ecg.csv").read_text().splitlines()
    times = [line.split(",")[0] for line in (tmp_path / "probes.csv").read_text().splitlines()[1:]]
    assert header == "time,V1,V2"
    assert [row.split(",")[0] for row in rows] == times
    values = np.array([row.split(",")[1:] for row in rows], dtype=float)
    assert (values[:, 1] > 0).all()  # the front comes nearer
    assert np.isfinite(values).all()


@pytest.mark.parametrize(
    "place, words",
    [
        ([2.5, 1.0, 0.5], "lies in the body"),
        ([5.0, 1.0, 0.5], "lies in the body"),  # on its surface
        ([9.0, 1.0], "electrodes.V1"),
        ("left", "finite coordinates"),
    ],
)
def test_wrong_electrodes(place, words):
    """One message that names the electrode."""
    with pytest.raises(InputError, match=r"electrodes\.V1") as error:
        ms.Case.from_dict(changed(SOLID, {"electrodes": {"V1": place}})).simulation(ALONE).run()
    assert words in str(error.value)


def test_a_given_potential_makes_no_current():
    """[drive] has no conductivity."""
    from small_cases import STATIC

    with pytest.raises(InputError, match="the potential is given"):
        ms.Case.from_dict(changed(STATIC, {"electrodes": {"a": [0.0, 0.0, 9.0]}})).simulation(ALONE).run()
