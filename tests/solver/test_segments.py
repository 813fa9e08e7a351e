"""The 17 segments of a left ventricle: which they are, and what is measured in them, against closed forms."""

from types import SimpleNamespace

import myostrain as ms
from myostrain import InputError
from myostrain.geometry import Ventricle
from myostrain.kinematics import Solid
from myostrain.output.measures import Measures
from myostrain.output.segments import KINDS, segment_numbers

import numpy as np
import pytest

from segment_tools import deformed, prescribed
from small_cases import ALONE

#: A shell between half spheres: the depth goes along the radius, everywhere.
INNER, OUTER = 10.0, 14.0
SHELL = Ventricle(endocardium=(INNER, INNER), epicardium=(OUTER, OUTER), base=0.0, spacing=2.2, layers=2)
SEPTUM = (-1.0, 0.0, 0.3)  # what of it is along the axis does not count
#: Pull along the axis by the one, across it by the other.
ACROSS, ALONG = 0.9, 1.2


@pytest.fixture(scope="module")
def shell():
    return prescribed(SHELL, SEPTUM)


def by_segment(values, kind):
    return np.array([values[f"{kind}_{n}"] for n in range(1, 18)])


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)], ids="zx")
def test_where_the_segments_are(axis):
    """Septum at the left, anterior wall above, seen from the apex; thirds of the height; apex 17."""
    base, septum = np.array(axis), np.array([0.0, -1.0, 0.0])
    right = -septum
    up = np.cross(right, base)
    for height, ring in ((10, 0), (40, 6)):
        for number, angle in enumerate((90, 150, 210, 270, 330, 30), start=1):
            for off in (-29, 29):
                turn = np.radians(angle + off)
                X = np.cos(turn) * right + np.sin(turn) * up - height * base
                assert segment_numbers(X[None], 0 * base, -90 * base, base, septum) == [ring + number]
    for number, angle in enumerate((90, 180, 270, 0), start=13):
        for off in (-44, 44):
            turn = np.radians(angle + off)
            X = np.cos(turn) * right + np.sin(turn) * up - 70 * base
            assert segment_numbers(X[None], 0 * base, -90 * base, base, septum) == [number]
            assert segment_numbers(X[None] - 25 * base, 0 * base, -90 * base, base, septum) == [17]


def test_the_volumes_of_segments(shell):
    """A ring between two heights: π ∫ (R² − r²) dz; in it each segment has the same."""
    segments = shell.measures._segments

    def ring(low, high):
        z = np.linspace(low, high, 2001)
        area = np.pi * (np.maximum(OUTER**2 - z**2, 0) - np.maximum(INNER**2 - z**2, 0))
        return np.sum((area[1:] + area[:-1]) / 2 * np.diff(z))

    third = INNER / 3
    due = np.repeat(
        [ring(0, third) / 6, ring(third, 2 * third) / 6, ring(2 * third, INNER) / 4, ring(INNER, OUTER)],
        [6, 6, 4, 1],
    )
    np.testing.assert_allclose(segments.volumes, due, rtol=0.05)
    body = 2 / 3 * np.pi * (OUTER**3 - INNER**3)
    assert segments.volumes.sum() == pytest.approx(body, rel=0.02)


def test_a_body_that_grows_strains_alike(shell):
    """x = 1.1 X: every strain is 0.1 in every segment; the stretch of the fibre 1.1; its stress the given."""
    values = deformed(shell, lambda X: 0.1 * X)
    for kind in KINDS[:3]:
        np.testing.assert_allclose(by_segment(values, kind), 0.1, rtol=0, atol=1e-10)
        assert values[kind] == pytest.approx(0.1, abs=1e-10)
    np.testing.assert_allclose(by_segment(values, "fibre_stretch"), 1.1, rtol=1e-12)
    np.testing.assert_allclose(by_segment(values, "fibre_stress"), 5.0, rtol=1e-12)
    assert values["fibre_stress_mean"] == pytest.approx(5.0)
    assert abs(values["torsion"]) < 1e-8


def test_strains_of_a_pulled_shell(shell):
    """x = diag(0.9, 0.9, 1.2) X: at the angle θ from the axis, λ² = (0.9 sin θ)² + (1.2 cos θ)² radially."""
    values = deformed(shell, lambda X: (np.array([ACROSS, ACROSS, ALONG]) - 1)[:, None] * X)
    np.testing.assert_allclose(by_segment(values, "circumferential_strain"), ACROSS - 1, rtol=0, atol=2e-3)
    r, c = np.meshgrid(
        np.linspace(INNER, OUTER, 401), (np.arange(2000) + 0.5) / 2000, indexing="ij"
    )  # radius and cosine
    s = np.sqrt(1 - c * c)
    fields = {
        "radial_strain": np.hypot(ACROSS * s, ALONG * c) - 1,
        "longitudinal_strain": np.hypot(ACROSS * c, ALONG * s) - 1,
    }
    ring = np.digitize(r * c, INNER * np.array([1 / 3, 2 / 3, 1]))
    for kind, field in fields.items():
        due = [np.average(field[ring == k], weights=(r * r)[ring == k]) for k in range(4)]
        found = by_segment(values, kind)
        np.testing.assert_allclose(found, np.repeat(due, [6, 6, 4, 1]), rtol=0, atol=0.02)
        assert np.ptp(due) > 0.05


def test_torsion_of_a_twisted_shell(shell):
    """The twist of the ends by the mean radii of the epicardium in them over their distance."""
    rate = -np.radians(1.0)  # turn a unit of height: the apex anticlockwise seen from below

    def turned(X):
        turn = -rate * X[2]
        x, y = X[0] * np.cos(turn) - X[1] * np.sin(turn), X[0] * np.sin(turn) + X[1] * np.cos(turn)
        return np.stack([x, y, X[2]]) - X

    values = deformed(shell, turned)
    z = OUTER * np.array([np.linspace(0.8, 1, 400), np.linspace(0, 0.2, 400)])
    radii = np.sqrt(np.maximum(OUTER**2 - z**2, 0)).mean(axis=1)  # rings of a sphere have equal areas
    assert values["torsion"] == pytest.approx(values["twist"] * radii.sum() / (2 * 0.8 * OUTER), rel=0.03)
    assert abs(values["torsion"]) > 5


def test_bad_septum(shell):
    """A direction along the axis; a body that is no left ventricle."""
    with pytest.raises(InputError, match=r"^output\.septum: .*not a direction across the long axis"):
        Measures(shell, (0.0, 0.0, 2.0))
    slab = ms.build(
        ms.geometry.Slab(size=(2.0, 1.0, 1.0), spacing=1.0), ms.UniformFibres(direction=(1, 0, 0)), ALONE
    )
    other = SimpleNamespace(body=slab, u=shell.u, kinematics=Solid(bulk_modulus=1.0))
    with pytest.raises(InputError, match=r"^output\.septum: segments are those of a left ventricle"):
        Measures(other, SEPTUM)
