"""A body whose bore follows a shaft that bends and twists.

Each section of the bore is rigid: its displacements u and rotations t about x, y, z, in the frame
that rotates with the helix, are polynomials of degree q_b in z. In the modes

    v = sum over d of phi_d(z) (u_d + t_d x (x, y, 0)/R),  R the radius of the bore         (B1)

the nodes of the bore have 6 (q_b + 1) unknowns a in the sector. Their columns K T are loads of the
condensation, like those of the flanks. K_shaft is a Timoshenko beam in the same functions
(Galerkin) with the strains in the rotating frame, D u = u' + kappa J u, J u = (-u_y, u_x, 0):

    E A u_z'^2 + k G A ((D u)_x - t_y)^2 + k G A ((D u)_y + t_x)^2 + E I |D t|^2 + G I_p t_z'^2

                                                                                            (B2)

Beyond an end the shaft may be thicker than the bore. It is then connected to the beam in the bore
and to the end face of the body: its motion is the mean over both, weighted with the tractions of a
round shaft (uniform under forces, linear under moments). The rest of the shaft and its bearings are
springs to the ground.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss
from flankload.elasticity.condensed_sector import AXIAL_MOTIONS, LATERAL_MOTIONS
from flankload.elasticity.sector_closure import Harmonics, close_ring
from flankload.elasticity.shape_functions import block_basis

if TYPE_CHECKING:
    from flankload.base.arrays import Complexes, Floats
    from flankload.bodies.body import SectorMesh
    from flankload.bodies.shaft import FlexibleShaft
    from flankload.elasticity.axial_basis import AxialBasis
    from flankload.elasticity.condensed_sector import CondensedSector
    from flankload.elasticity.finite_elements import SectionStiffness

#: Motions of a section: displacements and rotations about x, y, z.
MOTIONS = 6
#: Polynomial degree q_b of the motions of the sections along z.
SECTION_DEGREE = 5
#: Degree of the integration over end faces; elements across the circle of the shaft contribute by
#: their points inside.
FACE_DEGREE = 8


@dataclass(frozen=True, eq=False)
class FlexibleBore:
    """The bore of a sector that follows a shaft.

    Attributes
    ----------
    columns : (N, 3 (p + 1), 6 (q_b + 1) + 12) array
        K T: forces on the nodes of a sector by motions of its bore (by d, motion). Then the loads
        on the end faces by unit forces and moments of the shaft beyond.
    stiffness : (6 (q_b + 1), 6 (q_b + 1)) array
        K_aa = T'K T, with all nodes except the bore fixed.
    beam : (6 (q_b + 1), 6 (q_b + 1)) array
        K_shaft, including the bearings in the bore.
    ends : (12, 6 (q_b + 1)) array
        Contribution of a sector to the motions of the shaft beyond both ends, by motions of its
        bore.
    """

    shaft: FlexibleShaft
    teeth: int
    columns: Floats
    stiffness: Floats
    beam: Floats
    ends: Floats

    @classmethod
    def of(
        cls,
        shaft: FlexibleShaft,
        section: SectionStiffness,
        mesh: SectorMesh,
    ) -> FlexibleBore:
        """The bore of a sector."""
        functions = section.functions
        bases, of_node = functions.of_nodes(np.arange(len(mesh.nodes)))
        basis = bases[of_node[mesh.fixed_nodes[0]]]  # the bore belongs to one region
        degree = min(SECTION_DEGREE, basis.degree)
        motions = _motions(mesh.nodes, shaft.radius_mm)
        of_bore = np.zeros_like(motions)
        of_bore[mesh.fixed_nodes] = motions[mesh.fixed_nodes]
        columns, stiffness = _bore_columns(section, mesh, of_bore, degree)
        at_ends = basis.values(np.array(basis.range_mm))[:, : degree + 1]
        all_ends, parts = [], []
        for end, place in enumerate(basis.range_mm):
            faces, shares = _face_loads(shaft, mesh, motions, section, end)
            on_bore = np.einsum("ncm,nco->mo", faces, of_bore) + np.diag(shares / mesh.teeth)
            parts.append(np.einsum("mo,d->mdo", on_bore, at_ends[end]).reshape(MOTIONS, -1))
            along = np.concatenate([part.values(np.array([place])) for part in bases])[of_node]
            all_ends.append(np.einsum("ncm,nk->nkcm", faces, along))
        columns = np.concatenate(
            [columns, *(face.reshape(len(face), -1, MOTIONS) for face in all_ends)], axis=2
        )
        beam = beam_stiffness(shaft, basis, degree, section.twist)
        return cls(shaft, mesh.teeth, columns, stiffness, beam, np.concatenate(parts))

    def close_ring(self, sector: CondensedSector) -> Floats:
        """Response of all teeth of a closed ring to the loads on tooth 0.

        In harmonic k, with the response H to all loads with a fixed bore, forces s of the shaft
        beyond the ends and their compliance c,

            [ W^H (K_aa - H_aa + K_shaft/z) W   B^H         ] [a]     [H_af]
            [ B                                 -c/z - H_ss ] [s] = - [H_sf] f                  (B3)

        and -H_fa a - H_fs s is added to H_ff f. u_z and t_z belong to harmonic 0; u_x, u_y, t_x and
        t_y to 1 and -1, with (1, i) exp(i k pitch) in the frames of the sectors.

        Parameters
        ----------
        sector : CondensedSector
            Its loads are those of the flanks, then `columns`. Further kinds of readings read the
            displacements under all of them.

        Returns
        -------
        (z, r, p) array
            As for `sector_closure.close_ring`.
        """
        size, loads = len(self.stiffness), sector.local[0].shape[1]
        count = loads - size - len(self.ends)
        held = replace(sector.with_reactions(loads - count), mean=None)
        response = close_ring(held, self.teeth)
        read = np.append(np.arange(count), np.arange(loads, loads - count + response.shape[1]))
        angles = 2.0 * np.pi * np.arange(self.teeth) / self.teeth
        ring = Harmonics(sector, self.teeth)
        for k, weight in ((0, 1.0), (1, 2.0)):
            moved = _under_loads(sector, ring, k)
            motions, (springs, compliance) = self._motions(k), self._springs(k)
            free = np.zeros((size + len(self.ends), motions.shape[1] + springs.shape[1]), complex)
            free[:size, : motions.shape[1]] = motions
            free[size:, motions.shape[1] :] = springs
            own = -moved[count:loads, count:]
            own[:size, :size] += self.stiffness + self.beam / self.teeth
            own[size:, :size] += self.ends
            own[:size, size:] += self.ends.T
            own = free.conj().T @ own @ free
            own[motions.shape[1] :, motions.shape[1] :] -= np.diag(compliance / self.teeth)
            forces = np.linalg.solve(own, free.conj().T @ moved[count:loads, :count])
            part = moved[read, count:] @ free @ forces
            waves = np.exp(1j * k * angles)[:, None, None]
            response += (weight / self.teeth) * np.real(part[None] * waves)
        return response

    def _motions(self, k: int) -> Complexes:
        """Motions of the sections in harmonic 0 or 1, as columns over those of a sector.

        The mean axial motion is 0 without axial bearings; the mean rotation is 0 if the torque
        enters evenly.
        """
        identity = np.eye(len(self.stiffness) // MOTIONS)
        if k == 1:
            return np.kron(identity, LATERAL_MOTIONS)
        without_mean = identity[:, 1:]
        along = identity if self.shaft.axially_held else without_mean
        turned = without_mean if self.shaft.torque_end == "even" else identity
        return np.hstack(
            [np.kron(part, AXIAL_MOTIONS[:, [j]]) for j, part in enumerate((along, turned))]
        )

    def _springs(self, k: int) -> tuple[Complexes, Floats]:
        """Forces (12, n) of the shaft beyond the ends in a harmonic, and their compliances (n,).

        The compliance is 0 for the rotation of the section at which the torque enters.
        """
        forces, compliances = [], []
        own = LATERAL_MOTIONS if k == 1 else AXIAL_MOTIONS
        scale = _scale(self.shaft.radius_mm)
        for end, (name, springs) in enumerate(zip(("I", "II"), self.shaft.beyond, strict=True)):
            stiffness = scale[:, None] * _round_spring(*springs) * scale
            values, vectors = np.linalg.eigh(own.conj().T @ stiffness @ own)
            parts = [own @ (vectors * np.sqrt(np.maximum(values, 0.0)))]
            compliances += [1.0] * values.size
            if k == 0 and self.shaft.torque_end == name:
                parts.append(own[:, 1:])
                compliances.append(0.0)
            place = np.eye(2)[:, [end]]
            forces.append(np.kron(place, np.hstack(parts)))
        return np.hstack(forces), np.array(compliances)


def _motions(places: Floats, radius_mm: float) -> Floats:
    """Displacements (n, 3, 6) of points of a section under its motions; rotations times R."""
    found = np.zeros((len(places), 3, MOTIONS))
    found[:, [0, 1, 2], [0, 1, 2]] = 1.0
    x, y = (places / radius_mm).T
    found[:, 2, 3], found[:, 2, 4] = y, -x
    found[:, 0, 5], found[:, 1, 5] = -y, x
    return found


def _bore_columns(
    section: SectionStiffness,
    mesh: SectorMesh,
    motions: Floats,
    degree: int,
) -> tuple[Floats, Floats]:
    """K T by node, unknown and mode (B1), and T'K T; motions (N, 3, 6) of the bore's nodes."""
    functions = section.functions
    nodes, count, size = len(mesh.nodes), functions.count, MOTIONS * (degree + 1)
    number, terms = functions.products(section)
    held = np.flatnonzero(np.isin(section.columns, mesh.fixed_nodes))
    columns = np.zeros((nodes, count, 3, degree + 1, MOTIONS))
    for one in np.unique(number[held]):
        pairs = held[number[held] == one]
        moved = np.einsum("ntxc,ncm->ntxm", section.blocks[pairs], motions[section.columns[pairs]])
        forces = np.einsum("ntxm,tad->naxdm", moved, terms[one][:, :, : degree + 1])
        np.add.at(columns, section.rows[pairs], forces)
    forces = columns[:, : degree + 1].reshape(nodes, degree + 1, 3, size)
    stiffness = np.einsum("ncm,ndcs->dms", motions, forces).reshape(size, size)
    return columns.reshape(nodes, 3 * count, size), 0.5 * (stiffness + stiffness.T)


def _face_loads(
    shaft: FlexibleShaft,
    mesh: SectorMesh,
    motions: Floats,
    section: SectionStiffness,
    end: int,
) -> tuple[Floats, Floats]:
    """Connection of the shaft beyond an end to the end face around the bore, and to the beam.

    Loads (N, 3, 6) on the face of a sector by unit forces and moments (over R) of the shaft, and
    the part (6,) of these that acts on the beam in the bore.
    """
    inner, bore, outer = shaft.inner_radius_mm, shaft.radius_mm, shaft.end_radii_mm[end]
    loads = np.zeros_like(motions)
    if outer <= bore:
        return loads, np.ones(MOTIONS)
    bases, _ = section.functions.of_nodes(mesh.fixed_nodes)
    for number, (kind, cells) in zip(section.region_of_cells, mesh.cells, strict=True):
        if bases[number].range_mm[end] != shaft.range_mm[end]:
            continue
        basis = block_basis(mesh.nodes, kind, cells, FACE_DEGREE)
        x, y = basis.places
        points = np.column_stack([x.ravel(), y.ravel()])
        traction = _motions(points, bore).reshape(*x.shape, 3, MOTIONS)
        area = np.where(np.hypot(x, y) <= outer, basis.dx, 0.0)
        for local, value in enumerate(basis.values):
            part = np.einsum("eg,egcm->ecm", value * area, traction)
            np.add.at(loads, cells[:, local], part)
    by_force = (bore**2 - inner**2) / (outer**2 - inner**2)
    by_moment = (bore**4 - inner**4) / (outer**4 - inner**4)
    shares = np.repeat([by_force, by_moment], 3)
    whole = mesh.teeth * np.einsum("ncm,ncm->m", loads, motions)
    whole[[0, 1]], whole[[3, 4]] = whole[[0, 1]].mean(), whole[[3, 4]].mean()
    if not whole.all():  # no end face
        return np.zeros_like(motions), np.ones(MOTIONS)
    return loads * (1.0 - shares) / whole, shares


def beam_stiffness(shaft: FlexibleShaft, basis: AxialBasis, degree: int, twist: float) -> Floats:
    """Stiffness of beam and bearings in the bore, Eq. (B2): (6 (q_b + 1), 6 (q_b + 1)), N/mm.

    By d, motion; rotations times R. `basis`: functions over the width of the bore; `degree`: q_b;
    `twist`: kappa, rad/mm.
    """
    push, bend, shear, turn = shaft.stiffness
    low, high = basis.range_mm
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
    for place, radial, axial, tilt in shaft.bearings:
        at = basis.values(np.array([place]))[0, : degree + 1]
        spring = _round_spring(axial, radial, 0.0, tilt)
        total += np.einsum("d,e,mn->dmen", at, at, spring)
    scale = _scale(shaft.radius_mm)
    total *= scale[:, None, None] * scale
    size = MOTIONS * (degree + 1)
    return np.asarray(total.reshape(size, size))


def _scale(radius_mm: float) -> Floats:
    """Factors from displacements and rotations times R to motions of a section."""
    return np.repeat([1.0, 1.0 / radius_mm], 3)


def _round_spring(axial: float, force: float, mixed: float, moment: float) -> Floats:
    """Stiffness (6, 6) of a round spring; in both planes u_x' = t_y, u_y' = -t_x."""
    found = np.diag([force, force, axial, moment, moment, 0.0])
    found[0, 4] = found[4, 0] = mixed
    found[1, 3] = found[3, 1] = -mixed
    return found


def _under_loads(sector: CondensedSector, ring: Harmonics, k: int) -> Complexes:
    """All readings of harmonic k under all loads, with a fixed bore."""
    loads = ring.loads(k)
    found = ring.solved(k, loads[0])
    kinds = zip(sector.local, loads, strict=True)
    return np.concatenate([local + read.conj().T @ found for local, read in kinds])
