"""Formulas over past values, extrapolation and backward differences, and what keeps the values."""

import myostrain as ms
from myostrain.engine import fem
from myostrain.history import History, backward_difference, extrapolation_weights

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

#: Newest first, uneven: neighbouring intervals differ by up to a factor of ten.
intervals = st.lists(st.floats(0.1, 1.0), min_size=1, max_size=3)


def newest_first(end, gaps):
    return end - np.concatenate([[0.0], np.cumsum(gaps)])


def test_extrapolation_over_equal_steps():
    """Lagrange's polynomials one step ahead: 1; 2, −1; 3, −3, 1."""
    np.testing.assert_allclose(extrapolation_weights([0.7], 0.8), [1.0])
    np.testing.assert_allclose(extrapolation_weights([0.7, 0.6], 0.8), [2.0, -1.0])
    np.testing.assert_allclose(extrapolation_weights([0.7, 0.6, 0.5], 0.8), [3.0, -3.0, 1.0])


@given(gaps=intervals, ahead=st.floats(-0.5, 1.0), end=st.floats(-10, 10))
@settings(max_examples=50, deadline=None)
def test_extrapolation_is_exact_for_polynomials(gaps, ahead, end):
    """n values at uneven times reproduce every polynomial of degree n − 1.

    The weights reach 1e3 for such times, so that round-off of the times (1e-15) shows as 1e-11.
    """
    times = newest_first(end, gaps)
    weights = extrapolation_weights(times, end + ahead)
    for power in range(len(times)):
        assert weights @ (times - end) ** power == pytest.approx(ahead**power, abs=1e-10)


def test_backward_differences_over_equal_steps():
    """Backward Euler (1, −1)/h and BDF2 (3/2, −2, 1/2)/h."""
    h = 0.02
    np.testing.assert_allclose(backward_difference([1.0, 1.0 - h]) * h, [1, -1], atol=1e-12)
    np.testing.assert_allclose(
        backward_difference([1.0, 1.0 - h, 1.0 - 2 * h]) * h, [1.5, -2, 0.5], atol=1e-12
    )


@given(h=st.floats(1e-6, 1.0), ratio=st.floats(0.1, 10.0))
@settings(max_examples=50, deadline=None)
def test_bdf2_over_uneven_steps(h, ratio):
    """The closed form with r the newest step over the one before: ((1+2r)/(1+r), −(1+r), r²/(1+r))/h."""
    r = ratio
    expected = np.array([(1 + 2 * r) / (1 + r), -(1 + r), r**2 / (1 + r)])
    np.testing.assert_allclose(backward_difference([0.0, -h, -h - h / r]) * h, expected, rtol=1e-9)


@given(gaps=intervals, end=st.floats(-10, 10))
@settings(max_examples=50, deadline=None)
def test_backward_differences_are_exact_for_polynomials(gaps, end):
    """n values at uneven times differentiate every polynomial of degree n − 1 at the newest time."""
    times = newest_first(end, gaps)
    weights = backward_difference(times)
    for power in range(len(times)):
        assert weights @ (times - end) ** power == pytest.approx(float(power == 1), abs=1e-10)


@pytest.fixture
def field():
    body = ms.build(ms.geometry.Line(length=3.0))
    return fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1)))


def test_history_keeps_the_newest_values(field):
    """Depth three: copies, newest first, the oldest dropped; nothing after clear()."""
    history = History(field, depth=3)
    for time in (0.0, 1.0, 2.0, 4.0):
        field.x.array[:] = time**2
        history.push(time)
    field.x.array[:] = -1.0
    assert history.times == [4.0, 2.0, 1.0]
    np.testing.assert_array_equal([v[0] for v in history.values], [16.0, 4.0, 1.0])
    history.clear()
    assert not history.times
    assert not history.values


@pytest.mark.parametrize(
    "order, expected",
    [(0, 16.0), (1, 16 + 6 * 1.0), (2, 25.0), (5, 25.0)],  # t² at 5 from 4, 2, 1; no more values than kept
)
def test_history_extrapolates_at_most_to_the_order_asked(field, order, expected):
    """t² from its values at 1, 2, 4 by polynomials of degree 0, 1, 2."""
    history = History(field, depth=3)
    for time in (0.0, 1.0, 2.0, 4.0):
        field.x.array[:] = time**2
        history.push(time)
    out = np.empty_like(field.x.array)
    history.extrapolate(5.0, order, out)
    np.testing.assert_allclose(out, expected, rtol=1e-14)


@pytest.mark.parametrize(
    "course, expected",
    [
        (lambda t: 7.0, 7.0),
        (float, 9.0),
        (lambda t: t**2, 81.0),
        (lambda t: t**3, 729.0),
        (lambda t: t**4, 6561.0),
        (lambda t: t**5, 9**5 - 2240.0),  # a quartic through 7, 5, 4, 2, 1: less 2 · 4 · 5 · 7 · 8
        (lambda t: float(t >= 7), 1.0),  # a jump, which no polynomial foretells
        (lambda t: (-1.0) ** t * t, -7.0),
    ],
)
def test_history_predicts_by_the_order_that_was_best(field, course, expected):
    """A polynomial of degree 0 to 4 exactly, by values at 1, 2, 4, 5, 7; noise by the last value."""
    history = History(field, depth=5)
    for time in (0.0, 1.0, 2.0, 4.0, 5.0, 7.0):
        field.x.array[:] = course(time)
        history.push(time)
    out = np.empty_like(field.x.array)
    history.predict(9.0, lambda values: np.abs(values).max(), out)
    np.testing.assert_allclose(out, expected, rtol=1e-13)


def test_history_predicts_by_all_values_while_there_are_few(field):
    """One value stays, two are a line, three a parabola unless the line was worse than no change."""
    history = History(field, depth=5)
    for time, expected in ((1.0, 1.0), (2.0, 7.0), (4.0, 25.0)):
        field.x.array[:] = time**2
        history.push(time)
        out = np.empty_like(field.x.array)
        history.predict(time + 1.0, lambda values: np.abs(values).max(), out)
        np.testing.assert_allclose(out, expected, rtol=1e-13)


def test_history_of_one_value_gives_that_value(field):
    """A first step has no past: whatever the order asked, the one value; without any, nothing is written."""
    history = History(field, depth=3)
    out = np.full_like(field.x.array, 7.0)
    history.extrapolate(1.0, 2, out)
    np.testing.assert_array_equal(out, 7.0)
    field.x.array[:] = 3.0
    history.push(0.0)
    history.extrapolate(1.0, 2, out)
    np.testing.assert_array_equal(out, 3.0)


def test_a_value_of_the_same_time_takes_the_place_of_the_kept_one():
    """History.push: "It takes the place of one that is kept for the same time"."""
    body = ms.build(ms.geometry.Line(length=1.0, spacing=1.0))
    field = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1)))
    kept = History(field, depth=2)
    for time, value in ((0.0, 1.0), (0.0, 2.0), (0.5, 3.0), (0.5, 4.0)):
        field.x.array[:] = value
        kept.push(time)
    assert kept.times == [0.5, 0.0]
    assert [values[0] for values in kept.values] == [4.0, 2.0]
    kept.extrapolate(1.0, 1, field.x.array)
    assert np.all(field.x.array == 6.0)
