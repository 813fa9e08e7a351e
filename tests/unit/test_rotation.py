"""The circle on which a spiral's tip turns, against prescribed trajectories."""

from myostrain.output.rotation import rotation

import numpy as np
import pytest

PERIOD, RADIUS, VELOCITY = 7.3, 2.5, 0.03 - 0.04j


def way(t, turn=1):
    return 4 + 5j + VELOCITY * t + RADIUS * np.exp(turn * 2j * np.pi * t / PERIOD + 0.4j)


def found(t, z):
    return rotation(t, z.real, z.imag)


@pytest.mark.parametrize("turn", [1, -1], ids=["anticlockwise", "clockwise"])
@pytest.mark.parametrize("end", [25.0, 60.0, 400.0], ids=["few turns", "some", "many"])
def test_a_drifting_circle_exactly(turn, end):
    """Period, radius, speed of the centre, in either sense; nothing is left."""
    t = np.arange(0.0, end, 0.2)
    measured = found(t, way(t, turn))
    assert measured.period == pytest.approx(PERIOD, rel=1e-6)
    assert measured.radius == pytest.approx(RADIUS, rel=1e-6)
    assert measured.drift == pytest.approx(0.05, rel=1e-4)
    assert measured.deviation < 1e-5


def test_how_it_began_does_not_count():
    """Another circle in the first half, and a slower one until three turns before the end."""
    t = np.arange(0.0, 80.0, 0.1)
    early = 9 - 3j + 6 * np.exp(2j * np.pi * t / 20)
    slower = 4 + 5j + 2 * RADIUS * np.exp(2j * np.pi * t / (1.1 * PERIOD))
    z = np.where(t < 39, early, np.where(t < 80 - 3.3 * PERIOD, slower, way(t)))
    measured = found(t, z)
    assert measured.period == pytest.approx(PERIOD, rel=2e-3)
    assert measured.radius == pytest.approx(RADIUS, rel=2e-2)


def test_the_deviation_is_that_of_the_noise():
    """Root mean square distance; the circle is found in it."""
    t = np.arange(0.0, 60.0, 0.02)
    noise = np.random.default_rng(1).normal(scale=0.1, size=(2, len(t)))
    measured = found(t, way(t) + noise[0] + 1j * noise[1])
    assert measured.deviation == pytest.approx(0.1 * np.sqrt(2), rel=0.03)
    assert measured.period == pytest.approx(PERIOD, rel=2e-3)


@pytest.mark.parametrize(
    "end, z",
    [
        (2.9 * PERIOD, way),  # its later half has less than a turn and a half
        (60.0, lambda t: (1 + 2j) * t),
        (60.0, lambda t: (1 + 2j) * t**2),
        (60.0, lambda t: 0 * t + 3j),
        (0.5, way),
    ],
    ids=["few turns", "a line", "faster and faster", "a point", "a few looks"],
)
def test_what_is_no_circle_is_none(end, z):
    """None, without a warning."""
    t = np.arange(0.0, end, 0.2)
    assert found(t, z(t)) is None


def test_nothing_was_seen():
    """No look at all."""
    assert rotation([], [], []) is None
