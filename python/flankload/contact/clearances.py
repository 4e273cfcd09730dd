"""Bodies with clearance on their bearings: a force moves a body to the end of its clearance.

A body is displaced by c F/|F| under the force F on it, with half of the clearance c; without a
force it is anywhere within c. This adds c |F| to the energy, which remains convex, so that forces
stay unique. The direction of the force hardly depends on the displacement: on involutes, all forces
on a planet have the directions of the normals and, since it turns freely, the same amount.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import ContactError

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Floats
    from flankload.contact.meshes import MeshStates

#: Change of a displacement at which it is settled, mm: the accuracy of the curves of flanks.
SETTLED_MM = 1e-9
#: Largest number of passes: forces along normals need one or two, on sharp corners they need up to
#: six.
MOST_PASSES = 40


def settled(solved: Callable[[Floats], MeshStates], moved_mm: Floats) -> tuple[MeshStates, Floats]:
    """States under one case of loads with bodies at the ends of their clearances.

    Parameters
    ----------
    solved : callable
        States with the bodies displaced by (P, B, 2), mm.
    moved_mm : (P, B, 2) array
        Displacements under forces along the normals; the amount is half of the clearance. A body
        without force stays there.

    Raises
    ------
    ContactError
        If the directions of the forces do not converge.
    """
    play_mm = np.hypot(moved_mm[..., 0], moved_mm[..., 1])
    for _ in range(MOST_PASSES):
        found = solved(moved_mm)
        force = found.resultant[:, 0, :, :2]
        amount = np.hypot(force[..., 0], force[..., 1])
        loaded = (amount > 0.0) & (play_mm > 0.0)
        along = play_mm[loaded] / amount[loaded]
        wanted = moved_mm.copy()
        wanted[loaded] = along[:, np.newaxis] * force[loaded]
        if np.abs(wanted - moved_mm).max(initial=0.0) <= SETTLED_MM:
            return found, moved_mm
        moved_mm = wanted
    raise ContactError("the places of bodies in their clearances do not converge")
