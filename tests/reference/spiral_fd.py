"""A spiral of Aliev and Panfilov on a rigid square by finite differences: an independent reference.

Shares nothing with myostrain but the equations, dv/dt = lap v - k v (v - a)(v - 1) - v r and
dr/dt = (eps0 + mu1 r/(v + mu2)) (-r - k v (v - a - 1)), zero flux on all sides; only NumPy.  Five points in
space, Heun's method in time, both of second order.  The tip is where v = 1/2 and dv/dt = 0, bilinear in the
square of the grid that it is in.
"""

from __future__ import annotations

import numpy as np

K, A, EPS0, MU1, MU2 = 8.0, 0.15, 0.002, 0.2, 0.3


def tips(side, spacing, step, end, every, start):
    """Times and places (n, 3) of the tip of a spiral that begins with v, r = ``start(X, Y)``.

    Looks without a tip, or with several, are left out.
    """
    n = round(side / spacing) + 1
    v, r = start(*np.meshgrid(*2 * [np.linspace(0, side, n)], indexing="ij"))
    padded, found = np.empty((n + 2, n + 2)), []

    def rates(v, r):
        padded[1:-1, 1:-1] = v
        padded[[0, -1], 1:-1], padded[1:-1, [0, -1]] = v[[1, -2]], v[:, [1, -2]]
        around = padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:]
        dv = (around - 4 * v) / spacing**2 - K * v * (v - A) * (v - 1) - v * r
        return dv, (EPS0 + MU1 * r / (v + MU2)) * (-r - K * v * (v - A - 1))

    looks = round(every / step)
    for number in range(round(end / step)):
        dv, dr = rates(v, r)
        if number % looks == 0 and (place := tip(v - 0.5, dv)) is not None:
            found.append([number * step, *(spacing * place)])
        ev, er = rates(v + step * dv, r + step * dr)
        v, r = v + step / 2 * (dv + ev), r + step / 2 * (dr + er)
    return np.array(found)


def tip(a, b):
    """Where two fields of a grid are zero, in units of its spacing; None unless there is one such place."""

    def changes(f):
        corners = np.stack([f[:-1, :-1], f[1:, :-1], f[:-1, 1:], f[1:, 1:]])
        return (corners.min(axis=0) < 0) & (corners.max(axis=0) >= 0)

    places = []
    for i, j in np.argwhere(changes(a) & changes(b)):
        s = np.array([0.5, 0.5])
        for _ in range(8):
            value, slope = zip(*(bilinear(f[i : i + 2, j : j + 2], *s) for f in (a, b)), strict=True)
            s = s - np.linalg.lstsq(np.array(slope), np.array(value), rcond=None)[0]
        if (s > -1e-6).all() and (s < 1 + 1e-6).all():
            places.append(np.add(s, (i, j)))
    return places[0] if len(places) == 1 else None


def bilinear(f, p, q):
    """Value and gradient in a square with these corners."""
    value = np.array([1 - p, p]) @ f @ [1 - q, q]
    return value, [[-1, 1] @ f @ [1 - q, q], [1 - p, p] @ f @ [-1, 1]]
