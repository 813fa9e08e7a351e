"""Travelling fronts on a contracting line: exact solutions of section 4.1 of the paper.

The paper is D. Ambrosi, G. Arioli, F. Nobile, A. Quarteroni, SIAM J. Appl. Math. 71(2), 2011,
doi 10.1137/100788379.  Without recovery (w = 0), with the elastic line x' = 1 - beta v (4.3), (3.4), a
front v(X - c t) that joins v(-inf) = 0 to v(+inf) = 1 solves, according to the balance of the potential,

    conservative (4.8):  -c (1 - 2 beta v) v' - D (v' / (1 - beta v))' = -A (1 - beta v) v (v - alpha) (v - 1)
    advective:           -c (1 -   beta v) v' - D (v' / (1 - beta v))' = -A (1 - beta v) v (v - alpha) (v - 1)

Both have a solution of the family (4.9), v' = a v (1 - v) (1 - beta v).  Put into the equation and divided
by v (1 - v) (1 - beta v), it leaves a polynomial of degree one in v whose two coefficients must vanish:

    both:           c a + D a^2            = A alpha
    conservative:   2 beta c a + 2 D a^2   = A
    advective:        beta c a + 2 D a^2   = A

which gives (4.10) and (4.11), here for any A (the paper takes A = 1), and their advective counterparts:

    conservative:   a^2 = A (1 - 2 alpha beta) / (2 D (1 - beta)),   c a = -A (1 - 2 alpha) / (2 (1 - beta))
    advective:      a^2 = A (1 -   alpha beta) / (D (2 - beta)),     c a = -A (1 - 2 alpha) / (2 - beta)

With a > 0 the excited state lies at +inf, so for alpha < 1/2 it invades the rest towards -X: c < 0.
`speed` is -c, positive where the excited state advances, as in (4.11).

The front in space is simpler than in the material: since x' = 1 - beta v, (4.9) reads dv/dx = a v (1 - v),
whose solution is the logistic function (the hyperbolic tangent of the rigid line) of steepness a, whatever
beta.  Both functions of X below rest on that: with y = log(v / (1 - v)),

    a (X - X_half) = G(y) - G(0),   G(y) = y + beta / (1 - beta) log(1 + (1 - beta) exp(y)),
    a (x - X_half) = y    - G(0),   x - X -> 0 at X -> -inf.

Everything is non-dimensional, as in the paper.

**A front can exist where the line's problem is ill-posed.**  The conservative equation in time is
(1 - 2 beta v) dv/dt = ..., forward-parabolic only while 2 beta v < 1.  For beta >= 1/2 the closed form still
solves (4.8), and these functions return it, but no initial state evolves into it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["BALANCES", "profile", "spatial_coordinate", "speed", "steepness"]

Array = NDArray[np.float64]

BALANCES = ("conservative", "advective")
"""The two balances of the potential: d(Jv)/dt as in (3.5), or J dv/dt."""


def speed(
    alpha: ArrayLike,
    beta: ArrayLike = 0.0,
    *,
    diffusivity: ArrayLike = 1.0,
    A: ArrayLike = 1.0,
    balance: str = "conservative",
) -> Array | float:
    """Speed of the front per unit *material* length, equation (4.11) generalised to any A.

    Positive where the excited state v = 1 invades the rest (alpha < 1/2), zero for alpha = 1/2, negative
    where it retreats.  The front written with a > 0, as `profile` does, is v(X + speed t).

    Args:
        alpha: Threshold of the cubic reaction, 0 < alpha < 1.
        beta: Contraction at v = 1, gamma = -beta v (3.4), 0 <= beta < 1; 0 is the rigid line.
        diffusivity: D > 0, as measured in space (on the rigid line, in X).
        A: Rate of the reaction, A > 0.
        balance: "conservative", the paper's d(Jv)/dt (4.6), or "advective", J dv/dt.

    Returns:
        The speed, a float, or an array of the shape to which the parameters broadcast.

    Raises:
        ValueError: If no front exists (alpha beta >= 1/2 conservative, alpha beta >= 1 advective), or a
            parameter is out of its range, or `balance` is unknown.
    """
    alpha, beta, diffusivity, A = _checked(alpha, beta, diffusivity, A, balance)
    if balance == "conservative":
        c = (1 - 2 * alpha) / 2 * np.sqrt(2 * diffusivity * A / ((1 - beta) * (1 - 2 * alpha * beta)))
    else:
        c = (1 - 2 * alpha) * np.sqrt(diffusivity * A / ((2 - beta) * (1 - alpha * beta)))
    return _plain(c)


def steepness(
    alpha: ArrayLike,
    beta: ArrayLike = 0.0,
    *,
    diffusivity: ArrayLike = 1.0,
    A: ArrayLike = 1.0,
    balance: str = "conservative",
) -> Array | float:
    """Steepness a > 0 of the front v' = a v (1 - v) (1 - beta v), equation (4.10) generalised to any A.

    It is an inverse length; in space, dv/dx = a v (1 - v).

    Arguments, errors and the shape of the answer are those of `speed`.
    """
    alpha, beta, diffusivity, A = _checked(alpha, beta, diffusivity, A, balance)
    if balance == "conservative":
        a = np.sqrt(A * (1 - 2 * alpha * beta) / (2 * diffusivity * (1 - beta)))
    else:
        a = np.sqrt(A * (1 - alpha * beta) / (diffusivity * (2 - beta)))
    return _plain(a)


def profile(
    X: ArrayLike,
    alpha: float,
    beta: float = 0.0,
    *,
    diffusivity: float = 1.0,
    A: float = 1.0,
    balance: str = "conservative",
    center: float = 0.0,
) -> Array | float:
    """Potential v(X) of the front in material coordinates: (4.9) integrated by separation of variables.

    It rises from 0 at X -> -inf to 1 at X -> +inf.  At time t it is `profile(X + speed(...) * t, ...)`;
    for the mirror image, travelling towards +X, use `profile(-X + speed(...) * t, ...)`.

    Args:
        X: Material coordinates, finite, any shape.
        alpha: As in `speed`, but one number, and so the next four.
        beta: As in `speed`.
        diffusivity: As in `speed`.
        A: As in `speed`.
        balance: As in `speed`.
        center: The material coordinate where v = 1/2.

    Returns:
        v, in the shape of X (a float for a number).  Its relative error stays near round-off in the foot of
        the front too, where v is tiny.

    Raises:
        ValueError: As `speed`, or if X or `center` is not finite.
    """
    y, _ = _log_odds(X, alpha, beta, diffusivity, A, balance, center)
    return _plain(np.exp(-np.logaddexp(0.0, -y)))


def spatial_coordinate(
    X: ArrayLike,
    alpha: float,
    beta: float = 0.0,
    *,
    diffusivity: float = 1.0,
    A: float = 1.0,
    balance: str = "conservative",
    center: float = 0.0,
) -> Array | float:
    """Spatial coordinate x(X) = X - beta * integral of v from -inf to X, equation (4.12), in closed form.

    dX = dv / (a v (1 - v) (1 - beta v)) turns the integral into log((1 - beta v) / (1 - v)) / (a (1 - beta)).
    The tissue ahead, where v = 0, does not move; behind the front the line is shortened by 1 - beta.

    Arguments, errors and the shape of the answer are those of `profile`; `center` is where v = 1/2 in the
    *material*.
    """
    y, a = _log_odds(X, alpha, beta, diffusivity, A, balance, center)
    shortening = beta / (1 - beta) * np.logaddexp(0.0, y + np.log1p(-beta)) / a
    return _plain(np.asarray(X, dtype=float) - shortening)


def _log_odds(
    X: ArrayLike, alpha: float, beta: float, diffusivity: float, A: float, balance: str, center: float
) -> tuple[Array, float]:
    """y = log(v / (1 - v)) at X, and a.  Newton's method on G(y) - G(0) = a (X - center).

    G is increasing and convex, 1 < G' < 1 / (1 - beta), so Newton's method converges from any start above
    the root without overshooting.  Both asymptotes of G lie below it; the start is the nearer one's root.
    """
    for name, value in dict(alpha=alpha, beta=beta, diffusivity=diffusivity, A=A, center=center).items():
        if np.ndim(value) != 0:
            raise ValueError(f"{name} must be one number here, not an array of shape {np.shape(value)}")
    X = np.asarray(X, dtype=float)
    if not (np.all(np.isfinite(X)) and np.isfinite(center)):
        raise ValueError("X and center must be finite; the front tends to v = 0 at -inf and to v = 1 at +inf")
    a = float(steepness(alpha, beta, diffusivity=diffusivity, A=A, balance=balance))

    ratio, shift = beta / (1 - beta), np.log1p(-beta)
    target = a * (X - center) + ratio * np.log1p(1 - beta)  # = G(y); G(0) = ratio log(2 - beta)
    y = np.minimum(target, (1 - beta) * target - beta * shift)
    for _ in range(100):
        excess = np.logaddexp(0.0, y + shift)
        slope = 1 + beta * np.exp(y + shift - excess) / (1 - beta)
        step = (y + ratio * excess - target) / slope
        y = y - step
        if np.all(np.abs(step) <= 4 * np.finfo(float).eps * (1 + np.abs(y))):
            return y, a
    raise ArithmeticError("the front's profile did not converge; this should be impossible: please report it")


def _checked(
    alpha: ArrayLike, beta: ArrayLike, diffusivity: ArrayLike, A: ArrayLike, balance: str
) -> tuple[Array, Array, Array, Array]:
    """The parameters as arrays of floats, or a ValueError that says what is allowed."""
    if balance not in BALANCES:
        raise ValueError(f"unknown balance {balance!r}: it must be one of {', '.join(map(repr, BALANCES))}")
    alpha, beta, diffusivity, A = (np.asarray(p, dtype=float) for p in (alpha, beta, diffusivity, A))

    def demand(ok: ArrayLike, message: str) -> None:
        if not np.all(ok):
            raise ValueError(message)

    demand(
        (beta >= 0) & (beta < 1), f"beta = {beta} must lie in 0 <= beta < 1: 1 - beta of the length remains"
    )
    limit, text = (0.5, "1/2") if balance == "conservative" else (1.0, "1")
    demand(
        alpha * beta < limit,
        f"no travelling front: the {balance} balance needs alpha * beta < {text}, and alpha = {alpha}, "
        f"beta = {beta} give {alpha * beta}; lower the contraction beta or the threshold alpha",
    )
    demand(
        (alpha > 0) & (alpha < 1), f"alpha = {alpha} must lie in 0 < alpha < 1, between the two stable states"
    )
    for name, value in dict(diffusivity=diffusivity, A=A).items():
        demand((value > 0) & np.isfinite(value), f"{name} = {value} must be positive and finite")
    return alpha, beta, diffusivity, A


def _plain(value: ArrayLike) -> Array | float:
    """A float where the value is one number."""
    array = np.asarray(value, dtype=float)
    return float(array) if array.ndim == 0 else array
