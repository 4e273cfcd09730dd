"""A free rim on bolts: springs at a few places, added to the compliance of the flanks.

With the displacements C of a rim of which only the mean motion is held, the motion rho of the
body, its levers R, and springs of the compliance D,

    [ C_bb + D  R_b ] [p  ]     [ C_bf  ]
    [ R_b'      0   ] [rho] = - [ R_f'  ] F                                                   (B1)

gives the forces p of the bolts, and by them the displacements of the flanks: a term of low rank,
different for all teeth. A bolt acts on the rim of the two sectors whose middles are next to it, in
inverse proportion to the distances, which keeps its place and its direction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.elasticity.compliance.contributions import RimMotion

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.elasticity.compliance.contributions import RimResponse


@dataclass(frozen=True)
class Bolts:
    """Equal bolts, equally spaced from the middle of sector 0.

    Attributes
    ----------
    count : int
    stiffness : (float, float)
        Radial and tangential stiffness of each, N/mm per mm of width.
    """

    count: int
    stiffness: tuple[float, float]


def on_bolts(compliance: BodyCompliance, bolts: Bolts) -> BodyCompliance:
    """The compliance of a body whose free rim is on bolts.

    Forces that a sharp tip turns move the rim as forces along the flank's normal do.
    """
    rim = compliance.rim
    assert rim is not None
    z, p = len(compliance.smooth), compliance.smooth.shape[2]
    by_flanks, levers = _all_around(rim.by_modes), _around(rim.modes, z)
    spread = _spread(z, bolts.count)
    softness = np.diag(np.tile(1.0 / np.array(bolts.stiffness), bolts.count))
    own = spread.T @ _all_around(rim.by_forces) @ spread + softness
    lever = spread.T @ _around(rim.forces, z)
    system = np.block([[own, lever], [lever.T, np.zeros((3, 3))]])
    known = np.vstack([spread.T @ by_flanks, levers.T])
    found = np.linalg.solve(system, known)
    change = -known.T @ found
    change = 0.5 * (change + change.T).reshape(z, p, z, p).transpose(0, 2, 1, 3)
    # smooth depends on the difference of tooth numbers
    difference = np.subtract.outer(np.arange(z), np.arange(z)) % z
    error, turned = compliance.fe_error, compliance.turned
    return replace(
        compliance,
        smooth=(compliance.smooth[difference] + change).reshape(z * z, p, p),
        turned=None if turned is None else turned[difference].reshape(z * z, -1),
        flanks=tuple(range(z)),
        fe_error=None if error is None else np.repeat(error, z, axis=0),
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
    return RimMotion(moved[0::2], body)


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


def _spread(z: int, count: int) -> Floats:
    """Forces (2 z, 2 m) on the rims of the sectors by unit forces of the bolts."""
    spread = np.zeros((z, 2, count, 2))
    for k in range(count):
        first, beyond = divmod(k * z, count)
        for sector, part in ((first, 1.0 - beyond / count), (first + 1, beyond / count)):
            turn = 2.0 * np.pi * (k / count - sector / z)
            cosine, sine = np.cos(turn), np.sin(turn)
            spread[sector % z, :, k] += part * np.array([[cosine, -sine], [sine, cosine]])
    return spread.reshape(2 * z, 2 * count)
