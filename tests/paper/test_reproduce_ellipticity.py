"""What the chapter on ellipticity measures with: material points, borders, what follows the stretch."""

import functools
import operator

from myostrain.errors import ComputationError
from myostrain.reproduce import build, chapters
from myostrain.reproduce.build import csv_text
from myostrain.reproduce.chapters.ellipticity import jobs, numbers
from myostrain.reproduce.measurements import ellipticity
from myostrain.reproduce.measurements.points import (
    Points,
    active_tensors,
    free_stretches,
    isochoric,
    material,
    tension_for,
)
from myostrain.reproduce.verdict import claims, judge

import numpy as np
import pytest

LAW = {"model": "Guccione1995"}
FIBRE = {"fibre": {"kind": "Fibre"}}
ONE = np.eye(3)


@pytest.fixture(scope="module")
def points():
    return Points(material(LAW), 300)


def test_points_are_the_active_body(points):
    """Stress and moduli of Jo W(F Fo⁻¹) + Ta/2 (I₄f − 1) against differences and a formula."""
    rng = np.random.default_rng(1)
    F = ONE + 0.1 * rng.standard_normal((1, 3, 3))
    Fo = active_tensors({"kind": "Fibre"}, np.array([-0.2]))
    np.testing.assert_allclose(Fo[0], np.diag([0.8, 1, 1]), atol=1e-15)
    points.put(F, Fo, 0.7)
    A, P = points.moduli()[0], points.stress()[0]
    h = 1e-5

    def energy(F):
        Fe = F @ np.linalg.inv(Fo[0])
        E = (Fe.T @ Fe - ONE) / 2
        Q = 8 * E[0, 0] ** 2 + 2 * (E[1:, 1:] ** 2).sum() + 8 * (E[0, 1:] ** 2).sum()
        return 0.8 * np.expm1(Q) + 0.35 * ((F[:, 0] ** 2).sum() - 1)

    for i, j in ((0, 0), (1, 0), (2, 1)):
        step = np.zeros((3, 3))
        step[i, j] = h
        assert (energy(F[0] + step) - energy(F[0] - step)) / (2 * h) == pytest.approx(P[i, j], abs=1e-7)
        points.put(np.stack([F[0] + step, F[0] - step]), Fo, 0.7)
        plus, minus = points.stress()
        np.testing.assert_allclose(A[:, :, i, j], (plus - minus) / (2 * h), atol=1e-6 * np.abs(A).max())


def test_free_points_and_the_tension_that_matches_them(points):
    """Free of stress but for a pressure; the tension makes the passive points so at the same stretch."""
    gamma = np.array([-0.3, -0.1])
    Fo = active_tensors({"kind": "Fibre"}, gamma)
    free = free_stretches(points, Fo)
    assert free.prod(axis=1) == pytest.approx(1.0, abs=1e-12)
    cauchy = np.einsum("nii->ni", points.stress()) * free
    assert np.ptp(cauchy, axis=1) == pytest.approx(0.0, abs=1e-8)
    T = tension_for(points, free[:, 0])
    # A larger tension: the balance is gone.
    for share, balanced in ((1.0, True), (1.1, False)):
        points.put(points_at(points), tension=T * share)
        total = np.einsum("nij,nkj->nik", points.stress(), points_at(points))
        assert (np.abs(total[:, 0, 0] - total[:, 2, 2]).max() < 1e-8) == balanced


def points_at(points):
    cells = points._F.function_space.dofmap.list[:2, 0]
    return points._F.x.array.reshape(-1, 3, 3)[cells].copy()


def test_the_identity_sees_a_fault(points, monkeypatch):
    """Q(m; F) = Jo Qe(Fo⁻ᵀm; F Fo⁻¹) to rounding; not if Fo differs between both sides."""
    right = ellipticity.identities(points, FIBRE, 3, 60)
    assert right["strain"] < 1e-12
    assert right["tension_added"] < 1e-12
    assert right["signs"] == 1.0
    put = Points.put

    def faulty(self, F, Fo=None, tension=0.0):
        put(self, F, None if Fo is None else Fo @ np.diag([1.001, 1, 1]), tension)

    monkeypatch.setattr(Points, "put", faulty)
    assert ellipticity.identities(points, FIBRE, 3, 60)["strain"] > 1e-4


def test_borders_of_active_strain_are_those_of_the_passive_law_moved():
    """With the transversely isotropic Fo and equal sides, Fe is the isochoric stretch λ/(1 + γ)."""
    law = {"model": "Usyk2002"}
    found = ellipticity.examined(
        law,
        {"ti": {"kind": "TransverselyIsotropic"}},
        [-0.2, -0.1, 0.0],
        {"uniaxial": np.linspace(0.5, 1.6, 12).tolist()},
        1,
        10,
    ).arrays
    # Sheets kink where b_ss (1/e − 1) + b_ns/e = 0, e = 3/2; fibres, numerically.
    above, below = found["ti uniaxial above"], found["ti uniaxial below"]
    assert above == pytest.approx(1.5 * (1 + found["gamma"]), abs=1e-4)
    assert below == pytest.approx(below[2] * (1 + found["gamma"]), abs=1e-4)
    assert np.all(found["ti uniaxial least"][:2, 0] < 0)


def test_activations_that_follow_the_stretch():
    """The neo-Hookean body with a tension is the closed form's; with calcium at rest it is passive."""
    found = ellipticity.following({"model": "NeoHookean"}, [0.2, 1.2], np.linspace(0.95, 1.3, 8).tolist())
    assert found.numbers["closed_form"] < 1e-4
    np.testing.assert_allclose(found.arrays["strain"][0], 1.0, atol=1e-9)
    np.testing.assert_allclose(found.arrays["ordinary"][0], 1.0, atol=1e-9)
    assert (found.arrays["stress"][1] < 0).any()
    assert (found.arrays["frozen"][1] > 0).all()


def test_no_equilibrium_is_an_error(points, monkeypatch):
    """Raises: "No equilibrium is found"."""
    monkeypatch.setattr("myostrain.reproduce.measurements.points.MOST", 2)
    with pytest.raises(ComputationError, match="no equilibrium"):
        free_stretches(points, active_tensors({"kind": "Fibre"}, np.array([-0.3])))


def test_stretches_keep_the_volume():
    """Docstring: "Families of deformations that keep the volume"."""
    for family in ellipticity.FAMILIES.values():
        assert np.linalg.det(family(np.array([0.7, 1.2]))) == pytest.approx(1.0)
    assert isochoric(0.5)[0, 0] == 0.5


def test_groups_of_chapters():
    """`open-questions` stands for its chapters, in the order of the page; numbers as CSV have no NaN."""
    assert build._chosen(["open-questions"]) == chapters.groups()["open-questions"]
    assert build._chosen(["ellipticity", "springs"]) == ["springs", "ellipticity"]
    assert build._chosen([]) == chapters.names()
    assert csv_text({"a": ["x", "y"], "b": np.array([0.1, np.nan])}) == "a,b\nx,0.1\ny,\n"


def measured():
    """Numbers of the chapter with which each of its claims is borne out."""
    borders = {"fibre plane": {"active_below": 0.5}, "tension plane": {"active_below": 0.6}}
    laws = {name: {"borders": borders} for name in ("Guccione1995", "Usyk2002")}
    laws["Usyk2002"]["isometric"] = {"transversely isotropic": -0.3331}
    lost = {
        "strain_gamma": -0.16,
        "stress_gamma": -0.33,
        "strain_earliest_stretch": 1.14,
        "frozen_gamma": None,
    }
    following = {name: dict(lost) for name in jobs.EXPONENTIAL}
    following |= {name: lost | {"strain_gamma": -0.25, "stress_gamma": -0.15} for name in jobs.POLYNOMIAL}
    slab = {"passive": {"border": 0.71, "borders": [0.64, 0.68], "waves": [7, 11]}}
    return {
        "identity_error": 1e-14,
        "same_sign": 1.0,
        "lost_share": 0.4,
        "least_polynomial": 0.4,
        "tension_error": 1e-14,
        "limits": {"push": -1.0, "slopes": [-9.0], "closed_form": [-9.0], "line": 0.5},
        "kinking_error": 1e-5,
        "laws": laws,
        "following": following,
        "curve_peak": 0.97,
        "slab": slab,
        "runs": {"passive": {"reached": [0.55, 0.6]}},
    }


@pytest.mark.parametrize(
    "path, value, claim",
    [
        (("identity_error",), 1e-3, "frozen"),
        (("same_sign",), 0.99, "frozen"),
        (("lost_share",), 0.0, "frozen"),
        (("least_polynomial",), -0.1, "frozen"),
        (("tension_error",), 1e-3, "tension"),
        (("limits", "push"), 1.0, "tension"),
        (("limits", "slopes", 0), -8.9, "tension"),
        (("kinking_error",), 0.01, "exponential"),
        (("laws", "Usyk2002", "borders", "fibre plane", "active_below"), 0.7, "exponential"),
        (("laws", "Usyk2002", "isometric", "transversely isotropic"), -0.4, "exponential"),
        (("following", "NeoHookean", "frozen_gamma"), -0.2, "following"),
        (("following", "Usyk2002", "strain_earliest_stretch"), 0.95, "following"),
        (("following", "Guccione1995", "strain_gamma"), -0.34, "which-first"),
        (("following", "Guccione1995", "stress_gamma"), -0.1, "which-first"),
        (("following", "MooneyRivlin", "stress_gamma"), -0.3, "which-first"),
        (("following", "MooneyRivlin", "stress_gamma"), None, "which-first"),
        (("limits", "line"), 0.6, "line"),
        (("slab", "passive", "borders"), [0.64, 0.72], "slab"),
        (("slab", "passive", "borders"), [0.68, 0.64], "slab"),
        (("slab", "passive", "waves"), [7, 7], "slab"),
        (("runs", "passive", "reached"), [0.55, 0.75], "slab"),
        (("runs", "passive", "reached"), [0.55, None], "slab"),
    ],
)
def test_verdicts_turn_with_the_numbers(path, value, claim):
    """One number that is off turns the verdict that rests on it, and no other."""
    made, known = measured(), claims("ellipticity")

    def verdicts():
        judged = numbers.readings(made)
        return {name: judge(one, judged[name]).kind == "agrees" for name, one in known.items()}

    assert all(verdicts().values())
    *way, last = path
    functools.reduce(operator.getitem, way, made)[last] = value
    assert {name for name, agrees in verdicts().items() if not agrees} == {claim}
