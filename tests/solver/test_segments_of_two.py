"""Segments of the left one of two ventricles: what is of it, its volumes, and strains in closed form."""

from myostrain import InputError
from myostrain.geometry import Biventricle
from myostrain.output.left_ventricle import LeftVentricle
from myostrain.output.measures import Measures

import numpy as np
import pytest
import ufl

from segment_tools import deformed, prescribed

HEART = Biventricle(
    left=(20.0, 20.0, 40.0),
    left_wall=10.0,
    right=(35.0, 28.0, 36.0),
    right_wall=6.0,
    right_centre=16.0,
    base=10.0,
    spacing=9.0,
)
SEPTUM = (1.0, 0.0, 0.0)
ANTERIOR, SEPTAL, INFERIOR, LATERAL = (1, 7, 13), (2, 3, 8, 9, 14), (4, 10, 15), (5, 6, 11, 12, 16)


@pytest.fixture(scope="module")
def heart():
    return prescribed(HEART, SEPTUM)


def of(values, kind, numbers):
    return np.array([values[f"{kind}_{n}"] for n in numbers])


@pytest.fixture(scope="module")
def shell():
    """Points of the left wall as it is given, by chance, and the normals of the ellipsoids through them."""
    X = np.random.default_rng(1).uniform((-30, -30, -50), (30, 30, HEART.base), (200_000, 3))
    surfaces = HEART.surfaces
    X = X[(surfaces["left_inner"].level(X) >= 1) & (surfaces["left_outer"].level(X) <= 1)]
    across = X / np.array([25.0, 25.0, 45.0]) ** 2
    return X, across / np.linalg.norm(across, axis=1, keepdims=True)


def test_what_is_of_the_left_ventricle(heart, shell):
    """The wall between the left ellipsoids, cut off at the base, and nothing of the right free wall."""
    segments = heart.measures._segments
    low, high = np.array([-30, -30, -50]), np.array([30, 30, HEART.base])
    due = len(shell[0]) / 200_000 * np.prod(high - low)
    assert segments.volumes.sum() == pytest.approx(due, rel=0.05)
    X = segments._points.values(ufl.SpatialCoordinate(heart.body.mesh))().reshape(-1, 3)
    inside = segments._points.weights.reshape(-1) > 0
    level = HEART.surfaces["left_outer"].level(X)
    assert not inside[level > 1.3].any()
    assert inside[level < 0.9].mean() > 0.98
    assert 0.1 < (~inside).mean() < 0.6


def test_the_segments_are_where_they_should_be(heart):
    """The septum's are those before the right cavity; halves behind and before it have the same volume."""
    segments = heart.measures._segments
    X = segments._points.values(ufl.SpatialCoordinate(heart.body.mesh))()
    numbers, inside = segments.numbers.reshape(-1), segments._points.weights.reshape(-1) > 0
    X, above = X.reshape(-1, 3), X.reshape(-1, 3)[:, 2] > -38.0
    septal = np.isin(numbers, SEPTAL)
    assert septal[inside & above & (X[:, 0] > 0) & (np.abs(X[:, 1]) < 0.9 * X[:, 0])].all()
    assert not septal[inside & (X[:, 0] < 0)].any()
    assert (X[inside & np.isin(numbers, ANTERIOR), 1] > 0).all()
    assert (X[inside & np.isin(numbers, INFERIOR), 1] < 0).all()
    assert (X[inside & np.isin(numbers, LATERAL), 0] < 0).all()
    mirrored = [(1, 4), (2, 3), (5, 6), (7, 10), (8, 9), (11, 12), (13, 15)]
    one, other = (segments.volumes[[pair[k] - 1 for pair in mirrored]] for k in (0, 1))
    np.testing.assert_allclose(one, other, rtol=0.2)
    assert one.sum() == pytest.approx(other.sum(), rel=0.03)


def test_only_the_left_ventricle_counts(heart):
    """It grows by a tenth, the free wall of the right one by half, beyond where the two meet."""

    def grown(X):
        away = np.clip(HEART.surfaces["left_outer"].level(X.T) - 1.6, 0, 0.4)
        return (0.1 + away) * X

    values = deformed(heart, grown)
    for kind in ("longitudinal_strain", "circumferential_strain", "radial_strain"):
        np.testing.assert_allclose(of(values, kind, range(1, 18)), 0.1, rtol=0, atol=0.01)
        assert values[kind] == pytest.approx(0.1, abs=2e-3)
    assert values["fibre_stretch_mean"] > 1.15
    np.testing.assert_allclose(of(values, "fibre_stress", range(1, 18)), 5.0, rtol=0, atol=0.01)
    assert "torsion" not in values


def test_strains_of_a_pulled_heart(heart, shell):
    """x = (1.2 X, Y, Z): radially sqrt(1 + 0.44 n_x²) with the wall's normal n, the septum too."""
    values = deformed(heart, lambda X: np.array([0.2, 0.0, 0.0])[:, None] * X)
    X, normal = shell
    stretch = np.sqrt(1 + 0.44 * normal[:, 0] ** 2) - 1
    share = (HEART.base - X[:, 2]) / (HEART.base + HEART.left[2])
    side = np.degrees(np.arctan2(np.abs(X[:, 1]), np.abs(X[:, 0])))
    for low, high, wide in ((0, 1 / 3, (2, 3, 5, 6)), (1 / 3, 2 / 3, (8, 9, 11, 12))):
        ring = (share > low) & (share < high)
        due = stretch[ring & (side < 60)].mean()
        np.testing.assert_allclose(of(values, "radial_strain", wide), due, rtol=0, atol=0.02)
        due = stretch[ring & (side > 60)].mean()
        narrow = (wide[0] - 1, wide[1] + 1)
        np.testing.assert_allclose(of(values, "radial_strain", narrow), due, rtol=0, atol=0.02)


def test_axis_and_apex(heart):
    """The axis is that of the base; the apex the lowest node of the left endocardium."""
    left = LeftVentricle(heart)
    np.testing.assert_allclose(left.axis, [0, 0, 1], atol=1e-9)
    np.testing.assert_allclose(left.apex_at_rest, [0, 0, -40], atol=3.0)
    with pytest.raises(InputError, match=r"^output\.septum: .*not a direction across the long axis"):
        Measures(heart, (0.0, 0.0, 1.0))
