"""All gear meshes of a drive as bodies, gear meshes and motions for the core."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

import numpy as np

from flankload.base.rotation import turned
from flankload.contact.body_record import (
    at_sites,
    core_sites,
    packed_body,
    packed_mesh,
    packed_parts,
)
from flankload.contact.clearances import settled
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.mesh_sweeps import states_of_torque, sweeps_of_meshes, with_rotations
from flankload.contact.meshes import (
    KINDS,
    Members,
    solve_meshes,
    with_members,
    with_shaft,
    with_support,
)
from flankload.contact.status import raise_first_failure
from flankload.contact.sweep import Sweep, over_slices
from flankload.contact.wrenches import wrenches_of
from flankload.pairing.gear_pair import cosine_base_helix
from flankload.pairing.placed_mesh import PlacedMeshes
from flankload.pairing.slices import plane_slice

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.base.arrays import Floats
    from flankload.bodies.axial_shape import AxialShape
    from flankload.bodies.body import Body
    from flankload.contact.flank_contact import Level
    from flankload.contact.meshes import MeshStates, Motion
    from flankload.cost import Account
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.scene.discretization import Grid

#: Torque that replaces zero, N mm per mm of the centre distance and of the face width: deflections
#: by it are of the order of rounding errors. States without load are limits for vanishing torques,
#: in which the places of floating members still follow from the balance of their forces.
VANISHING = 1e-5


class Supports(Protocol):
    """How the bodies of a drive are held; `pairing`: its meshes."""

    def carried(self, pairing: Any) -> range:
        """Bodies whose supports are coupled, by an elastic carrier or a common shaft."""

    def turn_rad(self, pairing: Any) -> float:
        """Angle from the frame of the motions to the common one."""

    def compliances(self, pairing: Any) -> Floats:
        """(B, 6, B, 6) Motions of the bodies on springs by forces and moments."""

    def play(self, pairing: Any) -> Floats:
        """(B, 2) Displacements of the bodies in their clearances under forces along the normals."""

    def motions(self, pairing: Any) -> tuple[Motion, ...]:
        """Motions without springs; the first one is the rotation of body 1."""

    def loads(self, pairing: Any, torques_Nmm: Floats) -> Floats:
        """(T, q) Loads of the motions."""


class Errors(Protocol):
    """Errors that displace whole bodies of a drive; `pairing`: its meshes."""

    def thickness(self, body: int) -> float:
        """Excess of the normal thickness of the teeth of a body, mm."""

    def tilt(self, body: int) -> Floats | None:
        """(2,) Rotation of a body about x and y, rad, if any body is tilted."""

    def displacements(self, pairing: Any, position_rad: Floats) -> Floats:
        """(P, B, 3) Displacements x, y (mm) and rotation of each body."""


PairingT = TypeVar("PairingT", bound=PlacedMeshes)
SupportsT = TypeVar("SupportsT", bound=Supports)


@dataclass(frozen=True, kw_only=True)
class MeshesContact(Generic[PairingT, SupportsT]):
    """All gear meshes of a drive of B bodies, for the core.

    A body lists its places of contact mesh after mesh. It meets the others on its working flanks,
    in meshes in the mirror image of the first one on its coast flanks.

    Attributes
    ----------
    bodies, compliances : by their tables
    pairing : PlacedMeshes
    meshes : tuple of GearMesh
        As in the pairing, with their slices.
    errors : Errors
    supports : Supports
    grid : Grid
    level : str
        As for `FlankContact`.
    coupled : bool
        Whether forces in a mesh deform the bodies in other meshes.
    """

    bodies: tuple[Body, ...]
    compliances: tuple[BodyCompliance, ...]
    pairing: PairingT
    meshes: tuple[GearMesh, ...]
    errors: Errors
    supports: SupportsT
    grid: Grid
    level: Level = "pairs"
    coupled: bool = True

    @property
    def base_radii_mm(self) -> tuple[float, ...]:
        """Base radii by tables."""
        return tuple(body.base_radius_mm or 1.0 for body in self.bodies)

    @property
    def motions(self) -> tuple[Motion, ...]:
        """Motions without springs."""
        return self.supports.motions(self.pairing)

    @cached_property
    def springs(self) -> Floats:
        """(B, 6, B, 6) Compliance of the supports of the bodies."""
        return self.supports.compliances(self.pairing)

    def axial_shape(self, b: int) -> AxialShape:
        """Shape along the axis of a body of the core."""
        return self.bodies[self.pairing.tables[b]].axial

    def body_records(self) -> list[Floats]:
        """Records of the bodies."""
        every = range(len(self.pairing.tables))
        return [self._on_springs(b, self._record(b)) for b in every]

    def _record(self, b: int) -> Floats:
        """Record of a body with its places in meshes; the first ones are on its working flanks."""
        table, places = self.pairing.tables[b], self.pairing.meshes_of(b)
        body, compliance = self.bodies[table], self.compliances[table]
        excess_mm = 0.5 * self.errors.thickness(b) / cosine_base_helix(body)
        angles, deviations, slices_of_sites, teeth, n_working = [], [], [], [], 0
        for m, z in places:
            pairing, slices = self.meshes[m].pairing, self.meshes[m].slices
            at, excess = at_sites(pairing, slices, z, excess_mm)
            angles.append(at)
            deviations.append(excess)
            slices_of_sites.append(np.full(pairing.sites.size, slices.count))
            teeth.append(pairing.site_teeth[z])
            n_working += 0 if self.pairing.is_image(m) else pairing.sites.size
        numbers = np.concatenate(teeth)
        if not n_working and compliance.coast is None:
            # coast flanks are the working flanks of the mirror image, whose teeth run clockwise
            numbers, n_working = -numbers % body.teeth, numbers.size
        block = compliance.blocks_of_sites(numbers, n_working, body.teeth)
        if not self.coupled and not compliance.is_rigid:
            mesh_of = np.repeat(np.arange(len(teeth)), [part.size for part in teeth])
            compliance, block = compliance.apart(mesh_of[:, None] != mesh_of, block)
        counts = np.concatenate(slices_of_sites)
        m, z = places[0]
        return packed_body(
            body,
            compliance,
            angles_rad=np.concatenate(angles),
            deviations_mm=np.concatenate(deviations),
            block=block.repeat(counts, axis=0).repeat(counts, axis=1),
            teeth=numbers,
            n_working=n_working,
            slices=self.meshes[m].slices,
            which=z,
            coast=compliance.coast is not None,
        )

    def _on_springs(self, b: int, record: Floats) -> Floats:
        """The record of a body of the core with its support, if that moves."""
        compliance, axial = self.springs[b, :, b], self.axial_shape(b)
        tilt, carried = self.errors.tilt(b), self.supports.carried(self.pairing)
        if tilt is not None:
            record = packed_parts(record, [("tilt", np.append(tilt, axial.middle_mm))])
        if not compliance.any():
            return record
        if not axial.plane:
            record = with_shaft(record, compliance, axial.middle_mm)
            if b in carried:
                blocks = self.springs[b][:, carried].transpose(0, 2, 1).ravel(order="F")
                # the core counts bodies from 1
                first = 1.0 + carried.start
                record = packed_parts(record, [("carrier", np.append(first, blocks))])
            return record
        support = np.zeros((3, 3))
        support[:2, :2] = compliance[:2, :2]
        return with_support(record, support)

    def mesh_records(self) -> list[Floats]:
        """Records of the meshes."""
        found, before = [], [0] * len(self.pairing.tables)
        turn_rad = self.supports.turn_rad(self.pairing)
        for own, mesh in zip(self.meshes, self.pairing.meshes, strict=True):
            one, two = mesh.members
            sites, frame = (before[one], before[two]), mesh.frame_rad - turn_rad
            record = packed_mesh(own, self.grid, self.level)
            found.append(with_members(record, Members((one, two), sites, frame, mesh.sense)))
            for b in mesh.members:
                before[b] += core_sites(own)
        return found


AnyContact = MeshesContact[Any, Any]


@dataclass(frozen=True)
class MeshesSweep:
    """States of a drive of B bodies at P positions under one torque.

    Attributes
    ----------
    whole : Sweep
        With the sites of the result: the force in the first mesh of each, the largest pressure of
        all of them.
    meshes : tuple of Sweep
        The rotation is the approach of both flanks along the line of action over the base radius of
        body 1.
    moved_mm : (P, B, 2) array
        Displacements of the bodies by motions and supports, in the common frame.
    resultants : (P, B, 3) array
        Force (N) of all contacts on the bodies, and moment about their axes (N mm).
    motions : (P, q) array
        Motions in the order of `Supports.motions`.
    """

    whole: Sweep
    meshes: tuple[Sweep, ...]
    moved_mm: Floats
    resultants: Floats
    motions: Floats

    @property
    def certificate(self) -> Floats:
        """(P, 3) Certificate of each state."""
        return self.whole.certificate


def meshes_problem(
    contact: AnyContact, position_rad: Floats, torques_Nmm: Sequence[float] | Floats
) -> tuple[list[Floats], list[Floats], tuple[Motion, ...], Floats, Floats, Floats]:
    """Arguments of `solve_meshes`: records, motions, angles, loads, displacements.

    The torque 0 is replaced by a vanishing one, which keeps the flanks in contact.
    """
    pairing, mesh = contact.pairing, contact.meshes[0]
    torques = np.asarray(torques_Nmm, dtype=float)
    least = VANISHING * mesh.face_width_mm * mesh.pairing.center_distance_mm
    return (
        contact.body_records(),
        contact.mesh_records(),
        contact.motions,
        np.stack([one.turns(position_rad) for one in pairing.meshes], axis=1),
        contact.supports.loads(pairing, np.where(torques > 0.0, torques, least)),
        contact.errors.displacements(pairing, position_rad),
    )


def sweep_meshes(
    contact: AnyContact,
    position_rad: Floats,
    torques_Nmm: Sequence[float],
    *,
    keep_pairs: bool = True,
    account: Account | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[MeshesSweep, ...]:
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
            sweep_meshes(part, position_rad, [t], keep_pairs=keep_pairs, account=account)[0]
            for part, t in zip(parts, torques, strict=True)
        )
    found = sweep_displaced(
        [contact], position_rad, torques_Nmm, keep_pairs=keep_pairs, account=account
    )
    if progress is not None:
        progress(position_rad.size, position_rad.size)
    return found[0]


def sweep_displaced(
    contacts: Sequence[AnyContact],
    position_rad: Floats,
    torques_Nmm: Sequence[float],
    *,
    keep_pairs: bool = True,
    account: Account | None = None,
) -> tuple[tuple[MeshesSweep, ...], ...]:
    """Solve drives that differ by known displacements of their bodies only, as `sweep_meshes` does.

    The core finds the places of contact of each position once, and starts each state from the one
    before. Torques are positive, or the contacts lumped and all torques 0.
    """
    torques = np.asarray(torques_Nmm, dtype=float)
    play, n = contacts[0].supports.play(contacts[0].pairing), len(contacts)
    if play.any() and torques.size > 1:
        each = [
            sweep_displaced(contacts, position_rad, [t], keep_pairs=keep_pairs, account=account)
            for t in torques_Nmm
        ]
        return tuple(tuple(part[k][0] for part in each) for k in range(n))
    problem = meshes_problem(contacts[0], position_rad, torques_Nmm)
    bodies, meshes, motions, angles, loads, moved = problem
    others = [one.errors.displacements(one.pairing, position_rad) for one in contacts[1:]]
    displacements = np.stack([moved, *others], axis=1).reshape(-1, *moved.shape[1:])

    def solved(in_clearances: Floats) -> MeshStates:
        known = displacements.copy()
        known[..., :2] += in_clearances
        found = solve_meshes(
            bodies,
            meshes,
            motions,
            np.repeat(angles, n, axis=0),
            loads,
            known,
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
        return found

    found, play = settled(solved, np.broadcast_to(play, (len(displacements), *play.shape)))
    if not torques.any():
        found = found.without_forces()
    return tuple(
        tuple(
            _sweep_of(one, of_one, t, float(torque), play[k::n])
            for of_one in [found if n == 1 else found.at(slice(k, None, n))]
            for t, torque in enumerate(torques)
        )
        for k, one in enumerate(contacts)
    )


def _sweep_of(
    contact: AnyContact, found: MeshStates, t: int, torque_Nmm: float, play_mm: Floats
) -> MeshesSweep:
    """States under the torque with this index; `play_mm` (P, B, 2): places in clearances."""
    pairing, pairs, motions = contact.pairing, found.pairs[t], found.motion[:, t]
    # on body 1 of each mesh, if all meshes of the first table carry the same
    share = torque_Nmm / pairing.paths
    meshes = sweeps_of_meshes(
        found, t, contact.meshes, [share / mesh.rate for mesh in pairing.meshes]
    )
    turn_rad, resultants = contact.supports.turn_rad(pairing), found.resultant[:, t]
    if turn_rad:
        resultants = resultants.copy()
        resultants[..., :2] = turned(resultants[..., :2], turn_rad)
    places = _places(contact, motions, turn_rad) + _on_supports(contact, resultants, meshes)
    places[..., :2] += play_mm
    rows = pairing.rows(contact.base_radii_mm)
    radii = [contact.base_radii_mm[pairing.tables[mesh.members[0]]] for mesh in pairing.meshes]
    meshes = with_rotations(meshes, np.einsum("mbk,pbk->pm", rows, places) / radii)
    force = np.stack([meshes[m].site_force_N.sum(axis=1) for m, *_ in pairing.site_meshes], axis=-1)
    peaks = [_largest_peak([meshes[m] for m in of_site]) for of_site in pairing.site_meshes]
    peak, corner = (np.stack(part, axis=-1) for part in zip(*peaks, strict=True))
    # the rotation on which the torque works
    parts = np.diff(contact.supports.loads(pairing, np.array([0.0, 1.0])), axis=0)[0]
    own = np.flatnonzero(parts)
    whole = Sweep(
        torque_Nmm=torque_Nmm,
        rotation_rad=motions[:, own] @ parts[own],
        tangent_rad_per_Nmm=parts[own] @ found.tangent[:, t, own][:, :, own] @ parts[own],
        **over_slices((force, peak, corner), plane_slice(1.0)),
        site_force_per_torque=force / (torque_Nmm or 1.0),
        n_pairs=pairs.count,
        pairs=pairs,
        **states_of_torque(found, t),
    )
    return MeshesSweep(whole, meshes, places[..., :2], resultants, motions)


def _largest_peak(meshes: Sequence[Sweep]) -> list[Floats]:
    """(P,) Largest force over cell width of all sites of meshes, and the corner there."""
    peak = np.concatenate([mesh.site_peak_N_per_mm for mesh in meshes], axis=1)
    corner = np.concatenate([mesh.site_corner for mesh in meshes], axis=1)
    at = peak.argmax(axis=1)[:, None]
    return [np.take_along_axis(part, at, axis=1)[:, 0] for part in (peak, corner)]


def _places(contact: AnyContact, motions: Floats, turn_rad: float) -> Floats:
    """(P, B, 3) Displacements x, y (mm) and rotations of the bodies by motions."""
    found = np.zeros((len(motions), len(contact.pairing.tables), 3))
    for motion, column in zip(contact.motions, motions.T, strict=True):
        # the rotation of a body without load is arbitrary: 0
        moved = np.nan_to_num(column) if motion.kind == "rotation" else column
        bodies = slice(motion.body, motion.through + 1)
        found[:, bodies, KINDS[motion.kind] - 1] += motion.sign * moved[:, np.newaxis]
    found[..., :2] = turned(found[..., :2], turn_rad)
    return found


def _on_supports(contact: AnyContact, resultants: Floats, meshes: Sequence[Sweep]) -> Floats:
    """(P, B, 3) Displacements x, y of the bodies on their supports, mm, and rotations.

    Supports with a width also move by moments, which are known if pairs are stored. A displacement
    along the axis moves flanks as a rotation by its negative times their twist.
    """
    springs = contact.springs
    twists = [contact.axial_shape(b).twist_rad_per_mm for b in range(len(springs))]
    if contact.meshes[0].slices.plane:
        moved = np.einsum("bxcy,pcy->pbx", springs[:, :3, :, :2], resultants[..., :2])
        moved[..., 2] *= -np.array(twists)
        return moved
    found = np.einsum("bxcy,pcy->pbx", springs, wrenches_of(contact, meshes))
    rotation = found[..., 5] - np.array(twists) * found[..., 2]
    return np.concatenate([found[..., :2], rotation[..., np.newaxis]], axis=2)
