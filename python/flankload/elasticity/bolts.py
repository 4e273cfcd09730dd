"""A free rim on bolts: springs at a few places, added to the compliance of the flanks.

With the displacements C of a rim of which only the mean motion is held, the motion rho of the
body, its levers R, and springs of the compliance D,

    [ C_bb + D  R_b ] [p  ]     [ C_bf  ]
    [ R_b'      0   ] [rho] = - [ R_f'  ] F                                                   (B1)

gives the forces p of the bolts, and by them the displacements of the flanks: a term of low rank,
different for all teeth. A bolt acts on the rim of the two sectors whose middles are next to it, in
inverse proportion to the distances, which keeps its place and its direction.

With a width, a bolt acts evenly over it, at one angle, while the sectors turn with the helix: the
proportions depend on z and are projected onto the polynomials of the axis. The mean motion along
the axis and the mean tilt of the rim stay held.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legvander

from flankload.base.gauss import leggauss
from flankload.base.rotation import directions
from flankload.elasticity.compliance.contributions import RimMotion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.elasticity.compliance.contributions import AxialModes, RimResponse

#: Gauss points along the axis beyond the number of polynomials: the shares of two sectors in a bolt
#: have kinks where it passes the middle of one (1e-3 of a share).
HAT_POINTS = 12


@dataclass(frozen=True)
class Bolts:
    """Equal bolts, equally spaced from the middle of sector 0.

    Attributes
    ----------
    count : int
    stiffness : (float, float)
        Radial and tangential stiffness of each, N/mm, in the plane per mm of width.
    """

    count: int
    stiffness: tuple[float, float]


def on_bolts(
    compliance: BodyCompliance, bolts: Bolts, teeth: Sequence[int] | None = None
) -> BodyCompliance:
    """The compliance of a body whose free rim is on bolts; `teeth`: with flanks, by default all.

    Forces that a sharp tip turns move the rim as forces along the flank's normal do.
    """
    rim = compliance.rim
    assert rim is not None
    z, p = len(compliance.smooth), compliance.smooth.shape[2]
    flanks = np.arange(z) if teeth is None else np.unique(teeth)
    by_flanks, levers = _all_around(rim.by_modes), _around(rim.modes, z)
    spread = _spread(z, bolts.count, compliance.modes.axial)
    softness = np.diag(np.tile(1.0 / np.array(bolts.stiffness), bolts.count))
    own = spread.T @ _all_around(rim.by_forces) @ spread + softness
    lever = spread.T @ _around(rim.forces, z)
    system = np.block([[own, lever], [lever.T, np.zeros((3, 3))]])
    known = np.vstack([spread.T @ by_flanks, levers.T])
    found = np.linalg.solve(system, known)
    own_columns = (p * flanks[:, None] + np.arange(p)).ravel()
    change = -known[:, own_columns].T @ found[:, own_columns]
    n = flanks.size
    change = 0.5 * (change + change.T).reshape(n, p, n, p).transpose(0, 2, 1, 3)
    # smooth depends on the difference of tooth numbers
    difference = np.subtract.outer(flanks, flanks) % z
    error, along = compliance.fe_error, compliance.tangential
    return replace(
        compliance,
        smooth=(compliance.smooth[difference] + change).reshape(n * n, p, p),
        tangential=None if along is None else along[difference].reshape(n * n, p, -1),
        flanks=tuple(flanks.tolist()),
        fe_error=None if error is None else np.repeat(error, n, axis=0),
        rim_motion=rim_motion(rim, z, spread, found),
        rim=None,
    )


def rim_motion(
    rim: RimResponse, z: int, spread: Floats | None = None, reactions: Floats | None = None
) -> RimMotion:
    """Motion of a rim: of a free one relative to its mean motion, or on bolts with (B1)."""
    moved = _all_around(rim.by_modes)
    body = np.zeros((2, moved.shape[1]))
    if spread is not None and reactions is not None:
        forces, motion = reactions[: spread.shape[1]], reactions[spread.shape[1] :]
        moved = moved - _all_around(rim.by_forces) @ (spread @ forces)
        moved -= _around(rim.forces, z) @ motion
        body = -motion[:2]
    return RimMotion(moved[0 :: rim.by_modes.shape[1]], body)


def _all_around(response: Floats) -> Floats:
    """Matrix (z r, z p) of a response (z, r, p) to loads on tooth 0, for loads on all teeth."""
    z, r, p = response.shape
    difference = np.subtract.outer(np.arange(z), np.arange(z)) % z
    return response[difference].transpose(0, 2, 1, 3).reshape(z * r, z * p)


def _around(resultant: Floats, z: int) -> Floats:
    """Resultants (z n, 3) in the frame of the body of loads of all teeth; `resultant`: (3, n)."""
    turns: Floats = 2.0 * np.pi / z * np.arange(1.0 * z)
    along, across = directions(turns), directions(turns + 0.5 * np.pi)
    turned = along[:, :, None] * resultant[0] + across[:, :, None] * resultant[1]  # (z, 2, n)
    moments = np.broadcast_to(resultant[2], (z, 1, resultant.shape[1]))
    return np.concatenate([turned, moments], axis=1).transpose(0, 2, 1).reshape(-1, 3)


def _spread(z: int, count: int, axial: AxialModes) -> Floats:
    """Forces (z r, 2 m) on the rims of the sectors by unit forces of the bolts.

    At each place along the axis, a bolt is between the middles of two sectors.
    """
    points, weights = leggauss(axial.count + HAT_POINTS)
    low, high = axial.range_mm
    # P_b/b has the factor (2 b + 1) int w P_b dz/b of a weight w along the axis
    factors = 0.5 * weights[:, None] * legvander(points, axial.degree)
    factors = factors * (2.0 * np.arange(axial.count) + 1.0)
    pitch, spread = 2.0 * np.pi / z, np.zeros((z, axial.count, 2, count, 2))
    helix = axial.twist / pitch * 0.5 * (low + high + (high - low) * points)
    for k in range(count):
        first, beyond = divmod(k * z, count)
        before = np.floor(beyond / count - helix)
        part = beyond / count - helix - before
        for sector, share, apart in ((before, 1.0 - part, part), (before + 1.0, part, part - 1.0)):
            cosine, sine = np.cos(pitch * apart), np.sin(pitch * apart)
            turn = np.stack([np.stack([cosine, -sine]), np.stack([sine, cosine])])
            for g, at in enumerate(sector.astype(int).tolist()):
                own = share[g] * turn[:, :, g]
                spread[(first + at) % z, :, :, k] += factors[g, :, None, None] * own
    return spread.reshape(-1, 2 * count)
