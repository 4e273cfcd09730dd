"""A body whose bore follows a shaft that bends and twists: rigid sections along the axis.

The bore at z moves as a rigid section: displacements u and rotations t about x, y, z in the frame
that turns with the helix, each a polynomial of degree q_b in z. In the modes

    v = sum over d of phi_d(z) (u_d + t_d x (x, y, 0)/R),  R the radius of the bore              (B1)

the nodes of the bore have 6 (q_b + 1) unknowns a in the sector. Their columns K T are loads of the
condensation like those of the flanks. In the closed ring u_z, t_z are those of sector harmonic 0;
u_x, u_y, t_x, t_y those of harmonics 1 and -1, where sectors see (1, i) exp(i k pitch):

    C_t = C_t(held bore) + sum over k of w_k/z Re(H_fa W A^-1 W^H H_af exp(i k t pitch))         (B2)
    A = W^H (K_aa - H_aa + K_shaft/z) W,  w_0 = 1, w_1 = 2

with H the response of harmonic k to flank loads f and columns a with the bore held. K_shaft is a
Timoshenko beam in the same functions (Galerkin), strains in the turning frame: D u = u' + kappa J u,
J = (-u_y, u_x, 0), so

    E A u_z'^2 + k G A ((D u)_x - t_y)^2 + k G A ((D u)_y + t_x)^2 + E I |D t|^2 + G I_p t_z'^2   (B3)

and the springs of the shaft beyond the bore and of bearings in it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.linalg import null_space

from flankload.elasticity.prism.axial_basis import AxialBasis, AxialRegions
from flankload.elasticity.sector_closure import close_ring, turned_cuts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import SectorMesh
    from flankload.bodies.carrying_shaft import CarryingShaft
    from flankload.elasticity.prism.section_stiffness import SectionStiffness
    from flankload.elasticity.sector_closure import CondensedSector

    Floats = NDArray[np.float64]
    Complexes = NDArray[np.complex128]

#: Motions of a section: displacements and rotations about x, y, z.
MOTIONS = 6
#: Degree of the motions of the sections along z.
SECTION_DEGREE = 5


@dataclass(frozen=True, eq=False)
class CarriedBore:
    """The bore of a sector whose sections follow a shaft.

    Attributes
    ----------
    shaft : CarryingShaft
    basis : AxialBasis
        Functions of z of the bore's nodes.
    teeth : int
    columns : (N, 3 (p + 1), 6 (q_b + 1)) array
        K T: forces on the nodes of a sector when the sections of its bore move; by d, motion.
    stiffness : (6 (q_b + 1), 6 (q_b + 1)) array
        K_aa = T'K T: all nodes beside the bore at rest.
    held : (6 (q_b + 1), 6 (q_b + 1)) array
        K_shaft.
    """

    shaft: CarryingShaft
    basis: AxialBasis
    teeth: int
    columns: Floats
    stiffness: Floats
    held: Floats

    @classmethod
    def of(
        cls,
        shaft: CarryingShaft,
        section: SectionStiffness,
        functions: AxialBasis | AxialRegions,
        mesh: SectorMesh,
        twist: float,
    ) -> CarriedBore:
        """The bore of a sector.

        Parameters
        ----------
        shaft : CarryingShaft
        section : SectionStiffness
        functions : AxialBasis or AxialRegions
        mesh : SectorMesh
        twist : float
            kappa, rad/mm.

        Returns
        -------
        CarriedBore
        """
        basis = _bore_basis(functions, mesh)
        degree = min(SECTION_DEGREE, basis.degree)
        columns, stiffness = _bore_columns(section, functions, mesh, shaft.radius_mm, degree)
        held = shaft_stiffness(shaft, basis, degree, twist)
        return cls(shaft, basis, mesh.teeth, columns, stiffness, held)

    def close_ring(self, sector: CondensedSector) -> Floats:
        """Response of all teeth of a closed ring to the loads on tooth 0, Eq. (B2).

        Parameters
        ----------
        sector : CondensedSector
            Its loads are those of the flanks, then `columns`.

        Returns
        -------
        (z, p, p) array
            As of `sector_closure.close_ring`.
        """
        count = sector.local[0].shape[1] - len(self.stiffness)
        flanks = replace(
            sector,
            local=(sector.local[0][:count, :count],),
            carried=(sector.carried[0][:, :count],),
        )
        response = close_ring(flanks, self.teeth)
        angles = 2.0 * np.pi * np.arange(self.teeth) / self.teeth
        for k, weight in ((0, 1.0), (1, 2.0)):
            moved = _harmonic(sector, self.teeth, k)
            free = self._motions(k)
            reads = free.conj().T @ moved[count:, :count]
            own = self.stiffness - moved[count:, count:] + self.held / self.teeth
            own = free.conj().T @ own @ free
            part = reads.conj().T @ np.linalg.solve(own, reads)
            waves = np.exp(1j * k * angles)[:, None, None]
            response += (weight / self.teeth) * np.real(part[None] * waves)
        return response

    def _motions(self, k: int) -> Complexes:
        """Motions of the sections in harmonic 0 or 1, as columns over those of a sector.

        The rotation is counted from the section where the torque enters, and a shaft without axial
        bearings, which has no axial force, from its mean axial position.
        """
        identity = np.eye(len(self.stiffness) // MOTIONS)
        if k == 1:
            turning = np.zeros((MOTIONS, 2), dtype=complex)
            turning[[0, 3], [0, 1]], turning[[1, 4], [0, 1]] = np.sqrt(0.5), 1j * np.sqrt(0.5)
            return np.kron(identity, turning)
        mean, side = identity[:1], self.shaft.torque_end
        ends = dict(zip(("I", "II"), self.basis.values(np.array(self.basis.range_mm)), strict=True))
        entry = mean if side == "even" else ends[side][None, : len(identity)]
        along = identity if self.shaft.axially_held else null_space(mean)
        units = np.eye(MOTIONS)[:, [2, 5]]
        parts = np.kron(along, units[:, :1]), np.kron(null_space(entry), units[:, 1:])
        return np.hstack(parts).astype(complex)


def _bore_basis(functions: AxialBasis | AxialRegions, mesh: SectorMesh) -> AxialBasis:
    """Functions of z of the nodes of the bore, which belong to one region."""
    if isinstance(functions, AxialBasis):
        return functions
    (number,) = np.unique(functions.of_node[mesh.fixed_nodes])
    return functions.bases[number]


def _bore_columns(
    section: SectionStiffness,
    functions: AxialBasis | AxialRegions,
    mesh: SectorMesh,
    radius_mm: float,
    degree: int,
) -> tuple[Floats, Floats]:
    """`columns` and `stiffness` of a sector."""
    count = functions.count
    motions = np.zeros((len(mesh.nodes), 3, MOTIONS))
    motions[mesh.fixed_nodes] = _motions(mesh.nodes[mesh.fixed_nodes], radius_mm)
    number, terms = functions.products(section)
    held = np.flatnonzero(np.isin(section.columns, mesh.fixed_nodes))
    columns = np.zeros((len(mesh.nodes), count, 3, degree + 1, MOTIONS))
    for one in np.unique(number[held]):
        pairs = held[number[held] == one]
        moved = np.einsum(
            "ntxc,ncm->ntxm", section.blocks[pairs], motions[section.columns[pairs]]
        )
        forces = np.einsum("ntxm,tad->naxdm", moved, terms[one][:, :, : degree + 1])
        np.add.at(columns, section.rows[pairs], forces)
    size = MOTIONS * (degree + 1)
    forces = columns[mesh.fixed_nodes, : degree + 1].reshape(-1, degree + 1, 3, size)
    stiffness = np.einsum("ncm,ndcs->dms", motions[mesh.fixed_nodes], forces).reshape(size, size)
    return columns.reshape(len(mesh.nodes), 3 * count, size), 0.5 * (stiffness + stiffness.T)


def _motions(places: Floats, radius_mm: float) -> Floats:
    """Displacements (n, 3, 6) of places of a section under its motions; rotations times R."""
    found = np.zeros((len(places), 3, MOTIONS))
    found[:, [0, 1, 2], [0, 1, 2]] = 1.0
    x, y = (places / radius_mm).T
    found[:, 2, 3], found[:, 2, 4] = y, -x
    found[:, 0, 5], found[:, 1, 5] = -y, x
    return found


def shaft_stiffness(
    shaft: CarryingShaft, basis: AxialBasis, degree: int, twist: float
) -> Floats:
    """K_shaft: the beam in the bore, the shaft beyond it and its bearings, Eq. (B3).

    Parameters
    ----------
    shaft : CarryingShaft
    basis : AxialBasis
        Functions of the bore, over its width.
    degree : int
        q_b.
    twist : float
        kappa, rad/mm.

    Returns
    -------
    (6 (q_b + 1), 6 (q_b + 1)) array
        By d, motion; N/mm, rotations times R.
    """
    push, bend, shear, turn = shaft.stiffness
    radius, (low, high) = shaft.radius_mm, basis.range_mm
    points, weights = leggauss(degree + 2)  # exact to degree 2 q_b + 3
    z, weights = 0.5 * (low + high + (high - low) * points), 0.5 * (high - low) * weights
    values, slopes = (part[:, : degree + 1] for part in (basis.values(z), basis.derivatives(z)))
    constant = np.zeros((MOTIONS, MOTIONS))  # strain by motion
    constant[[0, 3], [1, 4]], constant[[1, 4], [0, 3]] = -twist, twist
    constant[0, 4], constant[1, 3] = -1.0, 1.0
    strain = np.einsum("gd,sm->gsdm", slopes, np.eye(MOTIONS))
    strain += np.einsum("gd,sm->gsdm", values, constant)
    moduli = np.array([shear, shear, push, bend, bend, turn])
    total = np.einsum("gsdm,gsen,g,s->dmen", strain, strain, weights, moduli)
    for place, springs in _springs(shaft):
        at = basis.values(np.array([place]))[0, : degree + 1]
        total += np.einsum("d,e,mn->dmen", at, at, springs)
    scale = np.array([1.0, 1.0, 1.0, *[1.0 / radius] * 3])
    total *= scale[:, None, None] * scale
    size = MOTIONS * (degree + 1)
    return np.asarray(total.reshape(size, size))


def _springs(shaft: CarryingShaft) -> list[tuple[float, Floats]]:
    """Places and stiffnesses (6, 6) of what holds the beam in the bore."""
    found = [
        (place, _round_spring(axial, radial, 0.0, tilt))
        for place, radial, axial, tilt in shaft.bearings
    ]
    ends = zip(shaft.range_mm, shaft.beyond, strict=True)
    return found + [(place, _round_spring(*springs)) for place, springs in ends]


def _round_spring(axial: float, force: float, mixed: float, moment: float) -> Floats:
    """Stiffness (6, 6) of a round spring; in both planes u_x' = t_y, u_y' = -t_x."""
    found = np.diag([force, force, axial, moment, moment, 0.0])
    found[0, 4] = found[4, 0] = mixed
    found[1, 3] = found[3, 1] = -mixed
    return found


def _harmonic(sector: CondensedSector, teeth: int, k: int) -> Complexes:
    """Response of harmonic k to all loads, with the bore held; Hermitian."""
    pitch = 2.0 * np.pi / teeth
    (ll, lr, rl, rr), ((left, right),) = turned_cuts(sector, pitch)
    shift = np.exp(1j * pitch * k)
    loads = left + right / shift
    found = np.linalg.solve(ll + rr + lr * shift + rl / shift, loads)
    return np.asarray(sector.local[0] + loads.conj().T @ found)
