"""Response of a flank to a tangential force at its sharp tip, where the direction of forces turns.

A tangential unit force on the last edge reads the displacements under the pressure modes; by
reciprocity (Betti) this is the response of the flank to that force. The near field is not included:
the jump of the half-plane, -j sign(s - s') (`near_field`), and the mirror images behind free
corners, -c0 psi_nt ln(d + d') (`bodies.free_corner`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legint, legval

from flankload.base.gauss import leggauss
from flankload.bodies.free_corner import along_strengths, image_strength, tip_angle
from flankload.bodies.tip_modes import graded
from flankload.elasticity.near_field import (
    consistent_loads,
    jump_strength,
    logarithm_strength,
    mode_values,
    to_coefficients,
)

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Body, MeshedFlank, SectorMesh

#: Gauss points, exact for a quadratic edge times a linear function and modes up to degree 20.
POINTS = 12


def has_turned_forces(body: Body) -> bool:
    """Whether the flank ends in a sharp tip, where the direction of forces turns."""
    return body.imported is None and image_strength(tip_angle(body)) > 0.0


def turned_columns(body: Body, flank: int) -> Floats:
    """Loads (2 N, 1) of a tangential unit force at the sharp tip of a flank, per mm of width.

    The force is distributed over the last edge, increasing linearly from 0 to the tip.
    """
    mesh = _flank_of(body, flank)
    start, end = last_edge(mesh)
    edges = mesh.flank_edges[-1:]
    return consistent_loads(
        mesh,
        lambda s: (2.0 * (s - start) / (end - start) ** 2)[:, None],
        count=1,
        along="tangent",
        edges=(edges, mesh.flank_arc_length[edges]),
    )


def turned_coefficients(body: Body, moments: Floats, own: Numbers, plane: str) -> Floats:
    """Displacements (k, p) of the flanks under a tangential force at the tip.

    Mode coefficients, mm²/N, without jump and images, from the readings (k, p) by the force under p
    modes, for k teeth or pairs of flanks; `own`: indices of flanks under their own loads.
    """
    low, high = body.mode_range_mm
    start, end = last_edge(_flank_of(body, 0))
    points, weights = leggauss(POINTS)
    s = 0.5 * (start + end) + 0.5 * (end - start) * points
    x = (2.0 * s - low - high) / (high - low)
    weights = weights * (s - start) / (end - start)
    modes = np.eye(moments.shape[1])
    # int P sign(x - y) dy = 2 int_-1^x P dy - int_-1^1 P dy
    primitive = legint(modes.T, lbnd=-1)
    sides = 2.0 * legval(x, primitive) - legval(np.ones(1), primitive)
    sign = 0.5 * (high - low) * sides @ weights
    smooth = moments.copy()
    smooth[own] -= jump_strength(body.material, plane) * sign
    away, parts = graded(high - low)
    strength = logarithm_strength(body.material, plane)
    for psi, end, inwards in zip(along_strengths(body), (low, high), (1.0, -1.0), strict=True):
        values = mode_values(end + inwards * away, body.mode_range_mm, moments.shape[1])
        both = np.log(inwards * (s - end)[:, None] + away)
        smooth[own] += strength * psi * (weights @ both @ (parts[:, None] * values))
    return to_coefficients(smooth.T, body.mode_range_mm).T


def last_edge(mesh: SectorMesh | MeshedFlank) -> tuple[float, float]:
    """Arc lengths of the ends of the last edge of a flank, mm."""
    start, end = mesh.flank_arc_length[mesh.flank_edges[-1, :2]].tolist()
    return start, end


def _flank_of(body: Body, flank: int) -> SectorMesh | MeshedFlank:
    assert body.mesh is not None
    return body.mesh.flanks[flank]
