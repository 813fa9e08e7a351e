"""Deformation gradient, volume ratio and strain, derived from the displacement that a run has written.

A quadratic displacement is taken as it is, so that its gradient is the run's, at every point of a cell.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.errors import InputError, shown

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]


def places(at: Any, corners: int) -> Array:
    """Barycentric coordinates (k, corners) of places in each cell.

    Args:
        at: "centres", "corners", or such coordinates: rows that add up to 1.
        corners: How many corners a cell has.

    Raises:
        InputError: They are neither.
    """
    if isinstance(at, str) and at in ("centres", "corners"):
        return np.full((1, corners), 1 / corners) if at == "centres" else np.eye(corners)
    try:
        given = np.asarray(at, dtype=float)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.ndim != 2 or given.shape[1] != corners or not np.allclose(given.sum(axis=1), 1.0):
        raise InputError(
            f'at: give "centres", "corners", or barycentric coordinates (k, {corners}), rows that add up to '
            f"1, not {shown(at)}"
        )
    return given


def deformation_gradient(
    points: Array, cells: Numbers, displacement: Array, middles: Array | None, where: Array
) -> Array:
    """F = 1 + ∂u/∂X on the mesh, (cells, k, dim, dim).

    Args:
        points: Material coordinates of the nodes, (n, dim).
        cells: Node numbers of the cells, (m, dim + 1).
        displacement: At the nodes, (n, dim).
        middles: At the middles of each cell's edges (m, pairs, dim), for its pairs of corners in the order
            (0, 1), (0, 2), ..., (1, 2), ...; None where it is linear.
        where: Barycentric coordinates, (k, dim + 1).
    """
    dim = points.shape[1]
    X = points[cells]
    # Gradients of the barycentric coordinates: of the corners but the first, the rows of this inverse.
    others = np.linalg.inv(np.swapaxes(X[:, 1:] - X[:, :1], 1, 2))
    slopes = np.concatenate([-others.sum(axis=1, keepdims=True), others], axis=1)  # (m, corners, dim)
    if middles is None:
        linear = np.einsum("mci,mcj->mij", displacement[cells], slopes)
        return np.eye(dim) + np.repeat(linear[:, None], len(where), axis=1)
    first, second = np.triu_indices(dim + 1, 1)
    # Quadratic shape functions: λ (2 λ − 1) at corners, 4 λ λ′ at the middles of edges.
    corner = (4 * where - 1)[None, :, :, None] * slopes[:, None]  # (m, k, corners, dim)
    edge = 4 * (
        where[None, :, first, None] * slopes[:, None, second]
        + where[None, :, second, None] * slopes[:, None, first]
    )
    grad = np.einsum("mci,mkcj->mkij", displacement[cells], corner)
    grad += np.einsum("mei,mkej->mkij", middles, edge)
    return np.eye(dim) + grad


def volume_ratio(F: Array, kinematics: Mapping[str, Any]) -> Array:
    """J of the body in three dimensions, (...), of F (..., dim, dim) on the mesh.

    Args:
        F: The deformation gradient on the mesh.
        kinematics: Its name and constraint, as the run wrote them; empty if it did not.

    Raises:
        InputError: The thickness of the sheet is not in F.
    """
    if kinematics.get("name") == "PlaneStress":
        if kinematics.get("constraint") != "total":
            raise InputError(
                'J of a sheet with constraint = "elastic" is that of the activation; write it: '
                'output.fields = ["J"]'
            )
        return np.ones(F.shape[:-2])
    return np.asarray(np.linalg.det(F))


def green_lagrange(F: Array) -> Array:
    """E = (FᵀF − 1)/2, (..., dim, dim)."""
    return np.asarray((np.swapaxes(F, -1, -2) @ F - np.eye(F.shape[-1])) / 2)


def fibre_stretch(F: Array, fibres: Array | None) -> Array:
    """|F f0|, (cells, k), of F (cells, k, dim, dim) and f0 (cells, dim); on a line of F alone."""
    if fibres is None:
        return np.abs(F[..., 0, 0])
    return np.asarray(np.linalg.norm(np.einsum("mkij,mj->mki", F, fibres), axis=-1))


def volumes(points: Array, cells: Numbers) -> Array:
    """Length, area or volume of the cells of the reference body, (m,)."""
    X = points[cells]
    return np.abs(np.linalg.det(X[:, 1:] - X[:, :1])) / (1, 1, 2, 6)[points.shape[1]]
