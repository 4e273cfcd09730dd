"""A planetary stage as bodies, gear meshes and motions for the core."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.body_record import core_sites, packed_body, packed_mesh, packed_parts
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.mesh_sweeps import states_of_torque, sweeps_of_meshes, with_rotations
from flankload.contact.meshes import (
    Members,
    Motion,
    solve_meshes,
    with_members,
    with_shaft,
    with_support,
)
from flankload.contact.stage_wrenches import wrenches_of
from flankload.contact.status import raise_first_failure
from flankload.contact.sweep import Sweep, over_slices
from flankload.pairing.gear_pair import cosine_base_helix
from flankload.pairing.slices import plane_slice
from flankload.pairing.stage_paths import paths_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.axial_shape import AxialShape
    from flankload.bodies.body import Body
    from flankload.contact.flank_contact import Level
    from flankload.contact.meshes import MeshStates, Motion
    from flankload.contact.stage_supports import StageSupports
    from flankload.cost import Account
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.pairing.stage import StageMesh, StagePairing
    from flankload.pairing.stage_errors import StageErrors
    from flankload.scene.discretization import Grid

#: Torque in place of none, N mm per mm of the centre distance and of the face width: deflections by
#: it are of the order of rounding errors. States without load are limits for vanishing torques, in
#: which the members that float still follow from the balance of their forces.
VANISHING = 1e-5


@dataclass(frozen=True)
class StageContact:
    """All gear meshes of a stage of n planets, for the core.

    Bodies of the core are the sun, the planets, and the ring; a body lists its places of contact
    mesh after mesh. The compliance of a planet has both flanks: the working flank meets the sun,
    the coast flank meets the ring.

    Attributes
    ----------
    bodies, compliances : of sun, planet, ring
    pairing : StagePairing
    meshes : tuple of 2n GearMesh
        As in the pairing, with their slices.
    errors : StageErrors
    supports : StageSupports
    grid : Grid
    level : str
        As of `FlankContact`.
    coupled : bool
        Whether forces in a mesh deform the bodies in other meshes.
    """

    bodies: tuple[Body, Body, Body]
    compliances: tuple[BodyCompliance, BodyCompliance, BodyCompliance]
    pairing: StagePairing
    meshes: tuple[GearMesh, ...]
    errors: StageErrors
    supports: StageSupports
    grid: Grid
    level: Level = "pairs"
    coupled: bool = True

    @property
    def count(self) -> int:
        """Number of planets."""
        return self.pairing.count

    @property
    def site_counts(self) -> tuple[int, ...]:
        """(2n,) Number of sites of each mesh in the core: slices of its pairs of flanks."""
        return tuple(core_sites(mesh) for mesh in self.meshes)

    @cached_property
    def springs(self) -> Floats:
        """(n + 2, 6, n + 2, 6) Compliance of the supports of sun, planets and ring."""
        return self.supports.compliances(self.pairing.angles_rad)

    def body_records(self) -> list[Floats]:
        """Records of sun, planets and ring."""
        n, meshes = self.count, self.meshes
        excess = 0.5 * self.errors.thickness_mm / cosine_base_helix(self.bodies[1])
        planets = [
            self._record(1, [(meshes[j], 1), (meshes[n + j], 0)], 1, excess_mm=excess[j])
            for j in range(n)
        ]
        records = [
            self._record(0, [(mesh, 0) for mesh in meshes[:n]], n),
            *planets,
            self._record(2, [(mesh, 1) for mesh in meshes[n:]], 0),
        ]
        return [self._on_springs(b, record) for b, record in enumerate(records)]

    def _record(
        self, which: int, places: list[tuple[GearMesh, int]], working: int, excess_mm: float = 0.0
    ) -> Floats:
        """Record of a body with its places in meshes; the first ones are on its working flanks.

        Flanks of meshes with the ring are coast flanks.
        """
        body, compliance = self.bodies[which], self.compliances[which]
        angles, deviations, slices_of_sites = [], [], []
        for mesh, z in places:
            pairing, slices = mesh.pairing, mesh.slices
            angles.append(slices.site_angles(pairing.site_angles_rad[z], z))
            excess = pairing.site_deviations_mm[z] + excess_mm
            deviations.append(slices.site_deviations(excess, z))
            slices_of_sites.append(np.full(pairing.sites.size, slices.count))
        teeth = np.concatenate([mesh.pairing.site_teeth[z] for mesh, z in places])
        n_working = sum(mesh.pairing.sites.size for mesh, _ in places[:working])
        if not working and compliance.coast is None:
            # coast flanks are the working flanks of the mirror image, whose teeth run clockwise
            teeth, n_working = -teeth % body.teeth, teeth.size
        block = compliance.blocks_of_sites(teeth, n_working, body.teeth)
        if not self.coupled and not compliance.is_rigid:
            mesh_of = np.repeat(np.arange(len(places)), [m.pairing.sites.size for m, _ in places])
            across = mesh_of[:, None] != mesh_of
            compliance, block = compliance.apart(across, block)
        counts = np.concatenate(slices_of_sites)
        mesh, z = places[0]
        return packed_body(
            body,
            compliance,
            angles_rad=np.concatenate(angles),
            deviations_mm=np.concatenate(deviations),
            block=block.repeat(counts, axis=0).repeat(counts, axis=1),
            slices=mesh.slices,
            which=z,
        )

    def _on_springs(self, b: int, record: Floats) -> Floats:
        """The record of a body of the core with its support, if that moves."""
        compliance, axial = self.springs[b, :, b], self.axial_shape(b)
        if 0 < b <= self.count and self.errors.tilts_rad is not None:
            tilt = (*self.errors.tilts_rad[b - 1], axial.middle_mm)
            record = packed_parts(record, [("tilt", np.array(tilt))])
        if not compliance.any():
            return record
        if not axial.plane:
            record = with_shaft(record, compliance, axial.middle_mm)
            if 0 < b <= self.count and self.supports.carrier is not None:
                # planets are the bodies from 2 on in the core
                blocks = self.springs[b, :, 1:-1].transpose(0, 2, 1).ravel(order="F")
                record = packed_parts(record, [("carrier", np.append(2.0, blocks))])
            return record
        support = np.zeros((3, 3))
        support[:2, :2] = compliance[:2, :2]
        return with_support(record, support)

    def axial_shape(self, b: int) -> AxialShape:
        """Shape along the axis of a body of the core."""
        return self.bodies[0 if b == 0 else 1 if b <= self.count else 2].axial

    def mesh_records(self) -> list[Floats]:
        """Records of the meshes: those with the sun, then those with the ring."""
        n, sites = self.count, self.site_counts
        found = []
        for k, mesh in enumerate(self.pairing.meshes):
            own = self.meshes[k]
            j = mesh.planet
            with_ring = k >= n
            members = Members(
                (1 + j, n + 1) if with_ring else (0, 1 + j),
                (sites[j], sum(sites[n:k])) if with_ring else (sum(sites[:k]), 0),
                mesh.frame_rad,
                mesh.sense,
            )
            twist = own.body_1.axial.twist_rad_per_mm
            record = packed_mesh(own, self.grid, self.level, twist)
            found.append(with_members(record, members))
        return found


@dataclass(frozen=True)
class StageSweep:
    """States of a stage at P positions under one torque.

    Attributes
    ----------
    planets : Sweep
        With a site for each planet: its force in the mesh with the sun, the largest pressure of
        both its meshes.
    meshes : tuple of 2n Sweep
        Those with the sun, then those with the ring; the rotation is the approach of both flanks
        along the line of action over the base radius of body 1.
    moved_mm : (P, n + 2, 2) array
        Displacements of sun, planets and ring by motions and supports, in the frame of the carrier.
    resultants : (P, n + 2, 3) array
        Force (N) of all contacts on sun, planets and ring, and moment about their axes (N mm).
    carrier_mm : (P, 2) array
        Displacement of a floating carrier.
    motions : (P, q) array
        Motions in the order of `StageSupports.motions`.
    """

    planets: Sweep
    meshes: tuple[Sweep, ...]
    moved_mm: Floats
    resultants: Floats
    carrier_mm: Floats
    motions: Floats

    @property
    def certificate(self) -> Floats:
        """(P, 3) Certificate of each state."""
        return self.planets.certificate


def stage_problem(
    contact: StageContact, position_rad: Floats, torques_Nmm: Sequence[float]
) -> tuple[list[Floats], list[Floats], tuple[Motion, ...], Floats, Floats, Floats]:
    """Arguments of `solve_meshes`: records, motions, angles, loads, displacements.

    In place of the torque 0 there is a vanishing one, which keeps the flanks in contact.
    """
    pairing, supports = contact.pairing, contact.supports
    torques = np.asarray(torques_Nmm, dtype=float)
    least = VANISHING * contact.meshes[0].face_width_mm * pairing.center_distance_mm
    return (
        contact.body_records(),
        contact.mesh_records(),
        supports.motions(contact.count),
        np.stack([mesh.turns(position_rad) for mesh in pairing.meshes], axis=1),
        supports.loads(np.where(torques > 0.0, torques, least), contact.count),
        contact.errors.displacements(pairing, position_rad),
    )


def sweep_stage(
    contact: StageContact,
    position_rad: Floats,
    torques_Nmm: Sequence[float],
    *,
    keep_pairs: bool = True,
    account: Account | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[StageSweep, ...]:
    """Solve all positions for all torques.

    A state without torque is that of a vanishing one, with lumped contact, without its forces.

    Raises
    ------
    FlankloadError
        For the first position without a solution.
    """
    torques = np.asarray(torques_Nmm, dtype=float)
    if not torques.all() and (contact.level != "lumped" or torques.any()):
        parts = [replace(contact, level=contact.level if t else "lumped") for t in torques]
        return tuple(
            sweep_stage(part, position_rad, [t], keep_pairs=keep_pairs, account=account)[0]
            for part, t in zip(parts, torques, strict=True)
        )
    found = sweep_displaced(
        [contact], position_rad, torques_Nmm, keep_pairs=keep_pairs, account=account
    )
    if progress is not None:
        progress(position_rad.size, position_rad.size)
    return found[0]


def sweep_displaced(
    contacts: Sequence[StageContact],
    position_rad: Floats,
    torques_Nmm: Sequence[float],
    *,
    keep_pairs: bool = True,
    account: Account | None = None,
) -> tuple[tuple[StageSweep, ...], ...]:
    """Solve stages that differ by known displacements of their bodies only, as `sweep_stage` does.

    The core finds the places of contact of each position once, and starts each state from the one
    before. Torques are positive, or the contacts lumped and all torques 0.
    """
    torques = np.asarray(torques_Nmm, dtype=float)
    problem = stage_problem(contacts[0], position_rad, torques_Nmm)
    bodies, meshes, motions, angles, loads, moved = problem
    n = len(contacts)
    others = [one.errors.displacements(one.pairing, position_rad) for one in contacts[1:]]
    displacements = np.stack([moved, *others], axis=1).reshape(-1, *moved.shape[1:])
    found = solve_meshes(
        bodies,
        meshes,
        motions,
        np.repeat(angles, n, axis=0),
        loads,
        displacements,
        keep_pairs=keep_pairs,
    )
    if account is not None:
        sums = found.counters.sum(axis=(0, 1), dtype=np.int64).tolist()
        account.count(states=found.status.size, **dict(zip(CORE_COUNTERS, sums, strict=True)))
    raise_first_failure(
        found.status,
        np.repeat(position_rad, n),
        torques,
        found.certificate.transpose(2, 0, 1),
        has_friction=False,
    )
    if not torques.any():
        found = found.without_forces()
    return tuple(
        tuple(
            _sweep_of(one, of_one, t, float(torque))
            for of_one in [found if n == 1 else found.at(slice(k, None, n))]
            for t, torque in enumerate(torques)
        )
        for k, one in enumerate(contacts)
    )


def _sweep_of(contact: StageContact, found: MeshStates, t: int, torque_Nmm: float) -> StageSweep:
    """States under the torque with this index."""
    n = contact.count
    pairs, motions = found.pairs[t], found.motion[:, t]
    nominal = [_nominal_torque(contact, mesh, torque_Nmm) for mesh in contact.pairing.meshes]
    meshes = sweeps_of_meshes(found, t, contact.meshes, nominal)
    moved = _displacements(contact, motions, found.resultant[:, t], meshes)
    radii = [
        contact.bodies[mesh.with_ring].base_radius_mm or 1.0 for mesh in contact.pairing.meshes
    ]
    meshes = with_rotations(meshes, _approaches(contact, motions, moved) / radii)
    tangent = found.tangent[:, t]
    force = np.stack([mesh.site_force_N.sum(axis=1) for mesh in meshes[:n]], axis=-1)
    peak, corner = _largest_peaks(meshes, n)
    planets = Sweep(
        torque_Nmm=torque_Nmm,
        rotation_rad=motions[:, 0],
        tangent_rad_per_Nmm=tangent[:, 0, 0],
        **over_slices((force, peak, corner), plane_slice(1.0)),
        site_force_per_torque=force / (torque_Nmm or 1.0),
        n_pairs=pairs.count,
        pairs=pairs,
        **states_of_torque(found, t),
    )
    floats = contact.supports.moving == "carrier"
    carrier = motions[:, -2:] if floats else np.zeros((len(motions), 2))
    return StageSweep(planets, meshes, moved, found.resultant[:, t], carrier, motions)


def _largest_peaks(meshes: Sequence[Sweep], n: int) -> tuple[Floats, Numbers]:
    """(P, n) Largest force over cell width in both meshes of each planet, and the corner there."""
    found = []
    for both in zip(meshes[:n], meshes[n:], strict=True):
        peak = np.concatenate([mesh.site_peak_N_per_mm for mesh in both], axis=1)
        corner = np.concatenate([mesh.site_corner for mesh in both], axis=1)
        at = peak.argmax(axis=1)[:, None]
        found.append([np.take_along_axis(part, at, axis=1)[:, 0] for part in (peak, corner)])
    return tuple(np.stack(part, axis=-1) for part in zip(*found, strict=True))  # type: ignore[return-value]


def _nominal_torque(contact: StageContact, mesh: StageMesh, torque_Nmm: float) -> float:
    """Torque on body 1 of a mesh if all planets carry the same."""
    ratio = contact.pairing.teeth[1] / contact.pairing.teeth[0] if mesh.with_ring else 1.0
    return torque_Nmm * ratio / contact.count


def _displacements(
    contact: StageContact, motions: Floats, resultants: Floats, meshes: Sequence[Sweep]
) -> Floats:
    """(P, n + 2, 2) Displacements of sun, planets and ring by motions and supports, mm.

    Supports with a width also move by moments, which are known if pairs are stored.
    """
    supports, n = contact.supports, contact.count
    moved = np.zeros((*resultants.shape[:2], 2))
    for motion, column in zip(supports.motions(n), motions.T, strict=True):
        if motion.kind != "rotation":
            bodies = slice(motion.body, motion.through + 1)
            moved[:, bodies, "xy".index(motion.kind)] += motion.sign * column[:, np.newaxis]
    if contact.meshes[0].slices.plane:
        return moved + np.einsum(
            "bxcy,pcy->pbx", contact.springs[:, :2, :, :2], resultants[..., :2]
        )
    return moved + np.einsum("bxcy,pcy->pbx", contact.springs[:, :2], wrenches_of(contact, meshes))


def _approaches(contact: StageContact, motions: Floats, moved_mm: Floats) -> Floats:
    """(P, 2n) Approach of the flanks of each mesh along its line of action, mm."""
    paths, n = paths_of(contact.pairing), contact.count
    turns = np.nan_to_num(motions[:, : 1 + n])
    found = turns[:, :1] * paths.sun_rows[:, 0] + moved_mm[:, 0] @ paths.sun_rows[:, 1:].T
    found += moved_mm[:, -1] @ paths.ring_rows[:, 1:].T
    found += np.einsum("pn,mn->pm", turns[:, 1:], paths.planet_rows[:, :, 0])
    found += np.einsum("pnx,mnx->pm", moved_mm[:, 1:-1], paths.planet_rows[:, :, 1:])
    return np.asarray(found)
