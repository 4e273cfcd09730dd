"""Displacements of all nodes of a closed ring of equal sectors under forces on its nodes.

One sector is condensed to its cuts, and its fronts are stored; the cuts of the ring are solved by
sector harmonics, and each sector requires one back substitution (`fronts.recovery`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.blas_threads import one_blas_thread
from flankload.base.rotation import turned
from flankload.elasticity.condensed_sector import CondensedSector, MeanMotion
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.fronts.recovery import Recovery
from flankload.elasticity.mean_motion import bore_reactions
from flankload.elasticity.sector_closure import ring_displacements

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Material, SectorMesh
    from flankload.elasticity.finite_elements import SectionStiffness


@dataclass(frozen=True, eq=False)
class RecoveredRing:
    """A condensed sector of a ring, for forces on its nodes.

    Attributes
    ----------
    sector : CondensedSector
        Condensed to its cuts.
    recovery : Recovery
        All fronts.
    reactions : (N, u, n) arrays
        Unit reactions on a bore whose mean motion is held, n = 0 for a fixed one, and the
        displacements under them with fixed cuts.
    """

    mesh: SectorMesh
    sector: CondensedSector
    recovery: Recovery
    reactions: tuple[Floats, Floats]

    @classmethod
    def of(cls, section: SectionStiffness, mesh: SectorMesh, material: Material) -> RecoveredRing:
        """Condense a sector, with reactions on a bore whose mean motion is held."""
        reactions = bore_reactions(mesh, section, material.young_modulus_MPa)
        recovery, count = Recovery(), reactions.shape[2]
        sector = condense_nodes(section, mesh, reactions, recovery=recovery)
        moved = recovery.under_loads(len(mesh.nodes), 0, count)
        (own,), (carried,) = sector.local, sector.carried
        mean = MeanMotion(own, (), carried) if count else None
        return cls(
            mesh, replace(sector, local=(), carried=(), mean=mean), recovery, (reactions, moved)
        )

    def in_body(self, forces: Floats, numbers: Numbers) -> Floats:
        """Displacements (M, a, c) of the nodes of the whole ring under forces (M, a, c) on them.

        By axial function and component, in the frame of the body; `numbers` (z, N): node of the
        whole ring for each node of each sector. Forces on cuts act on left cuts.
        """
        pitch = 2 * np.pi / self.mesh.teeth
        local = forces[numbers]
        local[:, self.mesh.right_nodes] = 0.0
        for k, part in enumerate(local):
            part[..., :2] = turned(part[..., :2], -k * pitch)
        by_sector = local.reshape(*numbers.shape, -1).transpose(1, 2, 0)
        moved = self.displacements(by_sector).transpose(2, 0, 1).reshape(local.shape)
        found = np.empty_like(forces)
        for k, (row, part) in enumerate(zip(numbers, moved, strict=True)):
            found[row] = part
            found[row, :, :2] = turned(part[..., :2], k * pitch)
        return found

    def displacements(self, forces: Floats) -> Floats:
        """Displacements of all sectors under nodal forces (N, u, z), in the sectors' frames."""
        columns, moved = self.reactions
        with one_blas_thread():
            kept, carried = self.recovery.reduced(forces)
            motions = np.einsum("num,nuz->mz", moved, forces)
            on_cuts, factors = ring_displacements(self.sector, self.mesh.teeth, carried, motions)
            if factors.size:
                kept, _ = self.recovery.reduced(forces + columns @ factors)
            return self.recovery.displacements(kept, on_cuts, len(self.mesh.nodes))
