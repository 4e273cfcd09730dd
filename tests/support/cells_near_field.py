"""The near field between cells of a flank, written plainly: the half-plane and its images."""

from __future__ import annotations

import numpy as np

from flankload.elasticity.compliance.body_compliance import BodyCompliance


def cells_near_field(
    compliance: BodyCompliance, s: np.ndarray, cell: np.ndarray | float
) -> np.ndarray:
    """Displacements (n, n) of cells at s under unit loads on cells of one width, mm²/N.

    Parameters
    ----------
    compliance : BodyCompliance
    s : (n,) array
    cell : (n, n) array or float
        Width of the loaded cell of each two.

    Returns
    -------
    (n, n) array
    """
    near = strip_kernel(s[:, None] - s, cell, compliance.near.kernel)
    for psi, corner in zip(compliance.near.wedge, compliance.modes.range_mm, strict=True):
        away = np.maximum(np.abs(s - corner), 0.5 * np.min(cell))  # a cell ends in the corner
        near = near + psi * strip_kernel(away[:, None] + away, cell, compliance.near.kernel)
    return np.asarray(near)


def strip_kernel(distance: np.ndarray, cell: np.ndarray | float, strength: float) -> np.ndarray:
    """Displacement at a distance from the centre of a strip under a uniform unit load.

    -(c0/d) [(x + d/2) ln|x + d/2| - (x - d/2) ln|x - d/2| - d].
    """
    right = np.asarray(distance) + 0.5 * np.asarray(cell)
    left = np.asarray(distance) - 0.5 * np.asarray(cell)
    return -strength * ((_x_log_x(right) - _x_log_x(left)) / cell - 1.0)


def _x_log_x(x: np.ndarray) -> np.ndarray:
    magnitude = np.abs(x)
    return x * np.log(np.where(magnitude > 0, magnitude, 1.0))
