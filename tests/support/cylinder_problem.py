"""The problem of the contact loop benchmarks, and the residual of its solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

ARM = 30.0
YOUNG_MPA, POISSON = 206000.0, 0.3
#: Compliance common to all pairs [mm/N]: bending of the tooth.
BENDING = 4e-5
#: Forces up to this fraction of the largest count as zero in the check of closed gaps.
NO_FORCE = 1e-9


@dataclass(frozen=True)
class Problem:
    """A contact problem with one motion.

    Attributes
    ----------
    compliance : ndarray of shape (n, n)
        K [mm/N].
    gaps : ndarray of shape (n,)
        g0 [mm].
    levers : ndarray of shape (n,)
        b [mm], gap closed by a unit of rotation.
    row : ndarray of shape (n,)
        m [mm], torque of a unit force; equal to b without friction.
    torque : float
        M [N mm].
    """

    compliance: Vector
    gaps: Vector
    levers: Vector
    row: Vector
    torque: float


def cylinder(n: int, friction: float = 0.0) -> Problem:
    """A cylinder pressed on an elastic half-plane that also bends; about a fifth of n pairs touch.

    Friction adds to every column the normal displacement due to its tangential force (bending, and
    the half-plane that rises in front of a tangential force and sinks behind it), and to the torque
    row its lever.
    """
    spacing = 2.0 / n
    place = (np.arange(n) - 0.5 * (n - 1)) * spacing
    kernel = 2.0 * (1.0 - POISSON**2) / (np.pi * YOUNG_MPA)

    def primitive(x: Vector) -> Vector:
        return x * np.log(np.abs(np.where(x == 0.0, 1.0, x)))

    apart = place[:, None] - place[None, :]
    distance = np.abs(apart)
    love = primitive(distance + 0.5 * spacing) - primitive(distance - 0.5 * spacing) - spacing
    compliance = -2.0 * kernel * love / spacing + BENDING
    compliance += friction * (0.7 * BENDING + 0.2 * kernel * np.sign(apart))
    levers = np.full(n, ARM)
    curvature, half_width = 0.2, 0.2
    force = 0.69 * np.pi * half_width**2 * curvature / (8.0 * kernel)
    return Problem(
        compliance=np.asfortranarray(compliance),
        gaps=0.5 * curvature * place**2,
        levers=levers,
        row=levers * (1.0 + friction * (0.5 + 0.1 * place)),
        torque=force * ARM,
    )


def residual(problem: Problem, forces: Vector, rotation: float | None = None) -> float:
    """Largest residual of a row of the problem, relative to the row's own size.

    Parameters
    ----------
    problem : Problem
    forces : ndarray of shape (n,)
        Normal forces [N].
    rotation : float, optional
        Rotation [rad]; by default the mean over all rows, weighted with their forces.

    Returns
    -------
    float
        The largest of: penetration, and force across a gap, over Σ|K|F + |g0| + |b φ|; tension over
        the largest force; residual torque over Σ|m|F + M. Computed in extended precision. A force
        counts if it exceeds 1e-9 of the largest; inf if a force is not finite.
    """
    if not np.isfinite(forces).all():
        return float(np.inf)
    wide = np.longdouble
    carried, levers, row = (part.astype(wide) for part in (forces, problem.levers, problem.row))
    recession = problem.compliance.astype(wide) @ carried + problem.gaps
    if rotation is None:
        rotation = carried @ recession / (carried @ levers)
    gap = recession - levers * rotation
    size = np.abs(problem.compliance).astype(wide) @ np.abs(carried)
    size += np.abs(problem.gaps) + np.abs(levers * rotation)
    largest = np.abs(carried).max()
    wrong = np.where(carried > NO_FORCE * largest, np.abs(gap), np.maximum(-gap, 0.0))
    held = abs(row @ carried - problem.torque) / (np.abs(row) @ np.abs(carried) + problem.torque)
    tension = max(-carried.min() / largest, 0.0) if largest > 0.0 else 0.0
    return float(max((wrong / size).max(), tension, held))
