"""Exponential integrators: exact for a rate that is linear in its own state, as a gate's is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

from myostrain.pointwise import Expression, derivative, quotient_of_factors
from myostrain.validation import Count, description

import numpy as np

Rates = Callable[[Sequence[Expression]], Sequence[Expression]]


class _Exponential:
    """What the integrators share: all but which states take exponential steps."""

    order: ClassVar[int] = 2
    multistep: ClassVar[bool] = False
    every_state: ClassVar[bool]

    def formula(
        self, rates: Rates, before: Sequence[Expression], h: Expression, order: int
    ) -> list[Expression]:
        """The states after a step; see :func:`exponential_step`."""
        return exponential_step(rates, before, h, order, every_state=self.every_state)


@description
class RushLarsen(_Exponential):
    """Exponential steps of what is linear in itself (the gates), explicit ones of the rest.

    A gate tends to its steady state and cannot leave [0, 1]. S. Rush and H. Larsen, IEEE Trans. Biomed.
    Eng. 25 (1978) 389–392, doi 10.1109/TBME.1978.326270.

    Args:
        substeps: Steps of the membrane in one of the potential, which is linear in time between.
    """

    substeps: Count = 1
    every_state: ClassVar[bool] = False


@description
class GeneralizedRushLarsen(_Exponential):
    """Exponential steps of all states, each linearised in itself.

    Of second order the step has two stages, the first of half a step: J. Sundnes, R. Artebrant, O. Skavhaug
    and A. Tveito, IEEE Trans. Biomed. Eng. 56 (2009) 2546–2548, doi 10.1109/TBME.2009.2014739. No state is
    ever extrapolated, so that no concentration gets negative by it.

    Args:
        substeps: Steps of the membrane in one of the potential, which is linear in time between.
    """

    substeps: Count = 1
    every_state: ClassVar[bool] = True


def exponential_step(
    rates: Rates, before: Sequence[Expression], h: Expression, order: int, *, every_state: bool
) -> list[Expression]:
    """Formulas of the states after a step of ds/dt = rates(s).

    Of first order, ``s + φ(a h) h f`` with f and a = ∂f/∂s of each state by itself at the beginning and
    φ(z) = (eᶻ − 1)/z. Of second order, that over half a step, then a whole one with f and a at the middle.

    Args:
        rates: The rates, of states; what else they depend on should be that of the middle for second order.
        before: States at the beginning.
        h: Length of the step.
        order: 1 or 2.
        every_state: Whether states that are not linear in themselves take exponential steps too.
    """
    if order == 1:
        return [
            s + step for s, (step, _) in zip(before, _increments(rates, before, h, every_state), strict=True)
        ]
    half = _increments(rates, before, 0.5 * h, every_state)
    middle = [s + step for s, (step, _) in zip(before, half, strict=True)]
    found = []
    for s, m, f, (_, grown) in zip(before, middle, rates(middle), half, strict=True):
        a = derivative(f, m)
        if not _exponential(a, m, every_state):
            found.append(s + h * f)
            continue
        # e^(a h) − 1 of the half step's, where a is the same in both: for gates.
        same = grown is not None and grown[0] is a
        whole = grown[1] * (grown[1] + 2.0) if grown is not None and same else np.expm1(a * h)
        found.append(s + _exponential_increment(f, a, h, whole, s - m))
    return found


def _increments(
    rates: Rates, states: Sequence[Expression], h: Expression, every_state: bool
) -> list[tuple[Any, tuple[Expression, Any] | None]]:
    """Increment of each state over a first-order step; and a with e^(a h) − 1 where it is exponential."""
    found: list[tuple[Any, tuple[Expression, Any] | None]] = []
    for s, f in zip(states, rates(states), strict=True):
        a = derivative(f, s)
        if not _exponential(a, s, every_state):
            found.append((h * f, None))
            continue
        grown = np.expm1(a * h)
        found.append((_exponential_increment(f, a, h, grown), (a, grown)))
    return found


def _exponential(a: Expression, s: Expression, every_state: bool) -> bool:
    """Whether a state takes an exponential step: its rate depends on it, linearly or in any way."""
    if a.is_number(0):
        return False
    return every_state or s.index not in {node.index for node in a.graph.needed([a])}


def _exponential_increment(f: Any, a: Expression, h: Expression, grown: Any, back: Any = 0.0) -> Any:
    """h (f + a · back) φ(a h) with ``grown`` = e^(a h) − 1; where a h vanishes it is h (f + a · back).

    A gate's rate is (s₀ − s) times a speed −a: then nothing is divided.
    """
    if (quotient := quotient_of_factors(f, a)) is not None:
        return (quotient + back) * grown
    f = f + a * back
    small = (a * h < 1e-12) & (a * h > -1e-12)
    where: Any = np.where
    return where(small, h * f, f / where(small, 1.0, a) * grown)
