"""Static condensation of one sector to its loads and cuts, and the closed ring of equal sectors.

A condensed sector consists of the response to its loads with fixed cuts, the forces G of these
loads on the cuts, and the stiffness S of the cuts. A ring of equal sectors is block-circulant and
solved by sector harmonics, exactly. Each kind of reading (displacements under the loads, coast
flank, stress, …) has a separate product, so that its bits do not depend on other readings.

If only the mean motion of the bore is held, its reactions R s on the bore have further unknowns s
in the harmonics of rigid motions (`MeanMotion`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import SectorMesh
from flankload.elasticity.condensed_sector import (
    AXIAL_MOTIONS,
    IN_PLANE,
    LATERAL_MOTIONS,
    CondensedSector,
    on_cuts,
    turned_cuts,
)
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.fronts.recovery import Recovery

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from flankload.base.arrays import Complexes, Floats, Numbers
    from flankload.bodies.body import WholeMesh
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.job_log import JobLog


def condense_sector(
    section: SectionStiffness,
    mesh: SectorMesh | WholeMesh,
    loads: Floats,
    readings: Sequence[Floats],
    log: JobLog,
    reactions: Floats | None = None,
    *,
    held: bool = False,
) -> CondensedSector:
    """Condense a mesh to its loads and cuts.

    Parameters
    ----------
    loads : (N, u, p) array
        Loads, which are also readings of the displacements.
    readings : sequence of (N, u, q) arrays
        Kinds of further readings of the displacements. Body loads are readings, too: by reciprocity
        (Betti), they read the displacements that they cause.
    reactions : (N, u, n) array, optional
        Reactions of a bore whose mean motion is held (`MeanMotion`).
    held : bool
        Whether the cuts are fixed.
    """
    p, recovery, columns = loads.shape[2], None, loads
    if reactions is not None and reactions.size:
        columns = np.concatenate([loads, reactions], axis=2)
    if log.estimates:
        recovery = Recovery()
    elif readings:
        read = [np.flatnonzero(part.any(axis=(1, 2))) for part in readings]
        recovery = Recovery(np.unique(np.concatenate(read)))
    sector = condense_nodes(
        section, mesh, columns, held=held, account=log.account, recovery=recovery
    )
    log.end_step("factorisation")
    if recovery is not None:
        moved = recovery.under_loads(section.nodes, 0, columns.shape[2])
        log.solution(moved[..., :p].reshape(-1, p))
        for part in readings:
            sector = recovery.read(sector, part, moved)
        log.end_step("solution")
    return sector if columns is loads else sector.with_reactions(columns.shape[2] - p)


class Harmonics:
    """Equations of a closed ring of equal sectors, by sector harmonic.

    In harmonic k the displacements of the cuts are w exp(i k pitch t) in the frames of sectors t;
    the common cut of sectors t - 1 and t belongs to sector t. Reactions of a mean motion have
    further unknowns s in harmonics 0 and 1: with the motions W of a ring,

        [  S      -c W   ] [w]   [ l   ]
        [ -W'c'   -W'h W ] [s] = [ W'x ] f                                                    (M1)

    with the forces l and c of loads and reactions on the cuts, and the motions x and h under them
    with fixed cuts. A reading r of [w; s] is [l_r; W'x_r]'.

    A reflection about a cut reverses the order of the sectors, so that it makes S of a symmetric
    sector its conjugate: with a factor of i for the unknowns that change their signs, S is real.
    """

    def __init__(self, sector: CondensedSector, teeth: int) -> None:
        self._sector, self._pitch = sector, 2.0 * np.pi / teeth
        self._stiffness, self._carried = turned_cuts(sector, self._pitch)
        self._real = None if sector.line is None else _RealParts.of(sector, self._stiffness)

    def motions(self, k: int) -> Complexes:
        """Motions W (n, q) of a ring in harmonic k, by the reactions of a sector."""
        mean = self._sector.mean
        count = 0 if mean is None else len(mean.own)
        if count == 0 or k > 1:
            return np.zeros((count, 0), dtype=complex)
        motions = (AXIAL_MOTIONS, LATERAL_MOTIONS)[k]
        if count == len(motions):
            return motions
        return motions[IN_PLANE][:, motions[IN_PLANE].any(axis=0)]

    def on_cuts(self, forces: Floats) -> tuple[Floats, Floats]:
        """Forces (2 m, r) on left and right cuts, these in the frame of the next sector."""
        return on_cuts(self._sector, forces, self._pitch)

    def system(self, k: int) -> Complexes:
        """Matrix (M1) of harmonic k."""
        left_left, left_right, right_left, right_right = self._stiffness
        wave, motions = np.exp(1j * self._pitch * k), self.motions(k)
        stiffness = left_left + right_right + left_right * wave + right_left / wave
        mean = self._sector.mean
        if mean is None or not motions.size:
            return np.asarray(stiffness)
        left, right = self.on_cuts(mean.carried)
        border = -(left + right / wave) @ motions
        corner = -motions.conj().T @ mean.own @ motions
        return np.block([[stiffness, border], [border.conj().T, corner]])

    def solved(self, k: int, right: Complexes) -> Complexes:
        """Unknowns of (M1) in harmonic k for right sides (n, r)."""
        if self._real is None or self.motions(k).size:
            return np.asarray(np.linalg.solve(self.system(k), right))
        return self._real.solved(self._pitch * k, right)

    def loads(self, k: int) -> list[Complexes]:
        """Right sides of (M1) by kind of reading; transposed, readings of its unknowns."""
        wave, motions = np.exp(1j * self._pitch * k), self.motions(k)
        found = [np.asarray(left + right / wave) for left, right in self._carried]
        mean = self._sector.mean
        if mean is None:
            return found
        return [
            np.concatenate([part, motions.conj().T @ local.T])
            for part, local in zip(found, mean.local, strict=True)
        ]


@dataclass(frozen=True)
class _RealParts:
    """S of a symmetric sector as a real matrix: constant + cos(angle) even + sin(angle) odd.

    Attributes
    ----------
    turn : float
        Polar angle of the left cut, along which x is in the frame of the matrices, rad.
    phases : (m,) array
        1, or i for unknowns that change their signs in the image about the cut.
    """

    constant: Floats
    even: Floats
    odd: Floats
    components: int
    turn: float
    phases: Complexes

    @classmethod
    def of(cls, sector: CondensedSector, stiffness: tuple[Floats, ...]) -> _RealParts:
        """Parts of the stiffness of the cuts by `turned_cuts`."""
        assert sector.line is not None
        (turn, signs), (left_left, left_right, _, right_right) = sector.line, stiffness
        own, mixed = (
            _along(_along(part, sector.components, -turn).T, sector.components, -turn).T
            for part in (left_left + right_right, left_right)
        )
        signs = np.tile(signs, len(own) // signs.size)
        same = signs[:, None] == signs
        return cls(
            np.where(same, own, 0.0),
            np.where(same, mixed + mixed.T, 0.0),
            np.where(same, 0.0, signs[:, None] * (mixed.T - mixed)),
            sector.components,
            turn,
            np.where(signs > 0.0, 1.0, 1.0j),
        )

    def solved(self, angle: float, right: Complexes) -> Complexes:
        """Solution for right sides (m, r) at a phase angle between neighbouring sectors."""
        known = self.phases.conj()[:, None] * _along(right, self.components, -self.turn)
        matrix = self.constant + np.cos(angle) * self.even + np.sin(angle) * self.odd
        real, imaginary = np.split(
            np.linalg.solve(matrix, np.hstack([known.real, known.imag])), 2, axis=1
        )
        found = self.phases[:, None] * (real + 1j * imaginary)
        return _along(found, self.components, self.turn)


def _along(values: NDArray[Any], components: int, turn: float) -> NDArray[Any]:
    """Rows (m, r) by point and component, rotated counter-clockwise by an angle."""
    found = values.reshape(-1, components, values.shape[1]).copy()
    x, y = values.reshape(found.shape)[:, :2].transpose(1, 0, 2)
    cosine, sine = np.cos(turn), np.sin(turn)
    found[:, 0], found[:, 1] = cosine * x - sine * y, sine * x + cosine * y
    return found.reshape(values.shape)


def close_ring(sector: CondensedSector, teeth: int) -> Floats:
    """Response (z, r, p) of all teeth of a closed ring to the loads on tooth 0.

    A Fourier transform over the sectors decouples the block-circulant system (`Harmonics`). [t]:
    readings on tooth t, in its frame; the first p are those of the loads.
    """
    ring = Harmonics(sector, teeth)
    response = [np.zeros((teeth, *local.shape)) for local in sector.local]
    angles = 2.0 * np.pi * np.arange(teeth) / teeth
    for k in range(teeth // 2 + 1):
        weight = 1.0 if k == 0 or 2 * k == teeth else 2.0
        loads = ring.loads(k)
        unknown = ring.solved(k, loads[0])
        waves = np.exp(1j * k * angles)[:, None, None]
        for part, read in zip(response, loads, strict=True):
            part += (weight / teeth) * np.real((read.conj().T @ unknown)[None] * waves)
    for part, local in zip(response, sector.local, strict=True):
        part[0] += local
    return np.concatenate(response, axis=1)


def ring_displacements(
    sector: CondensedSector, teeth: int, forces: Floats, motions: Floats | None = None
) -> tuple[Floats, Floats]:
    """Displacements of the cuts of all sectors of a closed ring, in the sectors' frames.

    Parameters
    ----------
    forces : (2 m, z) array
        Forces of the loads of each sector on its cuts.
    motions : (n, z) array, optional
        Motions of the bore of each sector under its loads with fixed cuts, for a mean motion.

    Returns
    -------
    displacements : (2 m, z) array
    reactions : (n, z) array
        Factors of the reactions of a mean motion; n = 0 without one.
    """
    ring = Harmonics(sector, teeth)
    left, right = ring.on_cuts(forces)
    load = np.fft.rfft(left + np.roll(right, 1, axis=1), axis=1)
    seen = np.fft.rfft(np.zeros((0, teeth)) if motions is None else motions, axis=1)
    waved, reactions = np.empty_like(load), np.zeros_like(seen)
    for k in range(load.shape[1]):
        rigid = ring.motions(k)
        known = np.append(load[:, k], rigid.conj().T @ seen[:, k])
        found = ring.solved(k, known[:, None])[:, 0]
        waved[:, k], reactions[:, k] = found[: len(load)], rigid @ found[len(load) :]
    moved = np.fft.irfft(waved, n=teeth, axis=1).T
    next_cut = np.roll(moved, -1, axis=0).reshape(teeth, -1, sector.components).copy()
    next_cut[..., :2] = turned(next_cut[..., :2], 2.0 * np.pi / teeth)
    displacements = np.concatenate([moved.T, next_cut.reshape(teeth, -1).T])
    return displacements, np.fft.irfft(reactions, n=teeth, axis=1)


def uniform_response(sector: CondensedSector, teeth: int) -> Floats:
    """Response (r, p) of a ring under equal loads on all teeth: the sum over `close_ring`."""
    ring = Harmonics(sector, teeth)
    reads = ring.loads(0)
    unknown = ring.solved(0, reads[0])
    return np.concatenate(
        [
            local + np.real(read.conj().T @ unknown)
            for local, read in zip(sector.local, reads, strict=True)
        ]
    )


def unknowns_of(mesh: SectorMesh | WholeMesh, *, held: bool = False, per_node: int = 2) -> int:
    """Unknowns of a mesh, of a sector with one of its cuts or, `held`, without both."""
    if not isinstance(mesh, SectorMesh):
        return per_node * (len(mesh.nodes) - len(mesh.fixed_nodes))
    fixed = np.concatenate([mesh.fixed_nodes, mesh.left_nodes, mesh.right_nodes])
    inside = len(mesh.nodes) - np.unique(fixed).size
    return per_node * (inside if held else inside + mesh.left_nodes.size)


def made_symmetric(response: Floats, across: Numbers) -> tuple[Floats, float]:
    """Mean of responses (k, p, p) and their transposes, which differ by rounding only (Betti).

    Also the largest difference over the largest response. `across` (k,): blocks with load and
    reading exchanged.
    """
    mirrored = response[across].transpose(0, 2, 1)
    asymmetry = float(np.abs(response - mirrored).max() / np.abs(response).max())
    return 0.5 * (response + mirrored), asymmetry
