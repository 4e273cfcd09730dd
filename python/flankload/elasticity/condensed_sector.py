"""One of equal sectors of a body, condensed to its loads and cuts, and its reactions on a bore."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


#: Motions of a ring in sector harmonics 0 and 1, by motions of a section, and these by motions of a
#: sector in its frame, with (1, i) exp(i k pitch): u_z and t_z; u_x, u_y, t_x and t_y.
AXIAL_MOTIONS = np.eye(6, dtype=complex)[:, [2, 5]]
LATERAL_MOTIONS = np.sqrt(0.5) * np.kron(np.eye(2), np.array([[1.0], [1.0j], [0.0]]))
#: The motions in the plane among them: u_x, u_y, t_z.
IN_PLANE = np.array([0, 1, 5])


@dataclass(frozen=True)
class MeanMotion:
    """Reactions on the bore of a condensed sector of which only the mean motion is held.

    The n reactions are tractions in proportion to u_x, u_y and t_z in the plane, to all six motions
    of a rigid body in three dimensions; as readings they are the mean motions.

    Attributes
    ----------
    own : (n, n) array
        Motions under unit reactions with fixed cuts.
    local : tuple of (r, n) arrays
        By kind of reading, response to unit reactions with fixed cuts.
    carried : (2 m, n) array
        Forces of unit reactions on both cuts.
    """

    own: Floats
    local: tuple[Floats, ...]
    carried: Floats


@dataclass(frozen=True)
class CondensedSector:
    """One condensed sector with free cuts, with the unknowns of the cuts in its frame.

    Attributes
    ----------
    local : tuple of (r, p) arrays
        By kind of reading, the loads first: response of its r readings to the p loads with fixed
        cuts.
    carried : tuple of (2 m, r) arrays
        By kind of reading: forces on the left and the right cut if the readings act as loads.
    stiffness : (2 m, 2 m) array
        Stiffness of the cuts.
    components : int
        Components of a displacement: 2, or 3 with the axial one last. The unknowns of a point of a
        cut are consecutive.
    mean : MeanMotion or None
        Mean motion of a bore that is not fixed itself.
    line : (float, (u,) array) or None
        For a symmetric sector, whose cuts are straight: polar angle of the left one, rad, and the
        signs of the unknowns of one of its points in its image about the cut, with x along it.
    """

    local: tuple[Floats, ...]
    carried: tuple[Floats, ...]
    stiffness: Floats
    components: int = 2
    mean: MeanMotion | None = None
    line: tuple[float, Floats] | None = None

    def with_reactions(self, count: int) -> CondensedSector:
        """The sector whose last `count` loads are the reactions of a mean motion."""
        n = self.local[0].shape[1] - count
        first, *others = self.local
        local = (first[:n], *others)
        return replace(
            self,
            local=tuple(part[:, :n] for part in local),
            carried=(self.carried[0][:, :n], *self.carried[1:]),
            mean=MeanMotion(
                first[n:, n:], tuple(part[:, n:] for part in local), self.carried[0][:, n:]
            ),
        )


def turned_cuts(
    sector: CondensedSector, turn_rad: float
) -> tuple[tuple[Floats, ...], tuple[tuple[Floats, Floats], ...]]:
    """Stiffness of the cuts and forces on them, with the right cut in the frame of the next sector.

    Returns
    -------
    stiffness : left-left, left-right, right-left, right-right, each (m, m)
    carried : by kind of reading left, right, each (m, r)
    """
    m = len(sector.stiffness) // 2
    # right unknowns of sector k, in its frame = turn @ left unknowns of sector k + 1, in its frame
    turn = _turn_of_cut(sector, turn_rad)
    return (
        sector.stiffness[:m, :m],
        sector.stiffness[:m, m:] @ turn,
        turn.T @ sector.stiffness[m:, :m],
        turn.T @ sector.stiffness[m:, m:] @ turn,
    ), tuple(on_cuts(sector, forces, turn_rad) for forces in sector.carried)


def on_cuts(sector: CondensedSector, forces: Floats, turn_rad: float) -> tuple[Floats, Floats]:
    """Forces (2 m, r) on left and right cuts, these in the frame of the next sector."""
    m = len(forces) // 2
    return forces[:m], _turn_of_cut(sector, turn_rad).T @ forces[m:]


def _turn_of_cut(sector: CondensedSector, turn_rad: float) -> Floats:
    """Rotation (m, m) of the unknowns of a cut."""
    cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
    block = np.eye(sector.components)
    block[:2, :2] = [[cosine, -sine], [sine, cosine]]
    return np.asarray(
        np.kron(np.eye(len(sector.stiffness) // (2 * sector.components)), block), dtype=float
    )
