"""A train of three gears as bodies, gear meshes and motions for the core."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.contact.body_record import core_sites, packed_body, packed_mesh
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.mesh_sweeps import states_of_torque, sweeps_of_meshes, with_rotations
from flankload.contact.meshes import Members, Motion, solve_meshes, with_members, with_support
from flankload.contact.status import raise_first_failure
from flankload.contact.sweep import Sweep, over_slices
from flankload.pairing.slices import plane_slice

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.contact.flank_contact import Level
    from flankload.contact.meshes import MeshStates
    from flankload.cost import Account
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.pairing.train import TrainPairing
    from flankload.scene.discretization import Grid

#: As `stage_contact.VANISHING`.
VANISHING = 1e-5
#: Number of bodies.
BODIES = 3


@dataclass(frozen=True)
class TrainContact:
    """Both gear meshes of a train, for the core; its bodies are those of the train in their order.

    A body lists its places of contact mesh after mesh. An idler meets body 1 on its working flanks,
    body 2 on its coast flanks.

    Attributes
    ----------
    bodies, compliances : of bodies 1, 2, 3
    pairing : TrainPairing
    meshes : two GearMesh
    grid : Grid
    level : str
        As of `FlankContact`.
    bearing_N_per_mm : float or None
        Radial stiffness of the bearings of the common gear; None if they are rigid.
    floating : bool
        Whether the common gear moves along the push of the first mesh without resistance.
    timing_mm : float
        Rotation of body 3 from its place, on its base circle, counter-clockwise.
    coupled : bool
        Whether forces in a mesh deform the common gear in the other one.
    """

    bodies: tuple[Body, Body, Body]
    compliances: tuple[BodyCompliance, BodyCompliance, BodyCompliance]
    pairing: TrainPairing
    meshes: tuple[GearMesh, GearMesh]
    grid: Grid
    level: Level = "pairs"
    bearing_N_per_mm: float | None = None
    floating: bool = False
    timing_mm: float = 0.0
    coupled: bool = True

    @property
    def base_radii_mm(self) -> tuple[float, ...]:
        """Base radii of the bodies."""
        return tuple(body.base_radius_mm or 1.0 for body in self.bodies)

    @property
    def motions(self) -> tuple[Motion, ...]:
        """Rotation of body 1, of an idler, and displacement of a floating gear."""
        common = self.pairing.common
        turning = (Motion(0), Motion(common, sign=-1)) if self.pairing.is_idler else (Motion(0),)
        if not self.floating:
            return turning
        return (*turning, Motion(common, "x"))

    @property
    def turn_rad(self) -> float:
        """Angle from the frame of the core to that of the train; x of the core is a push."""
        if not self.floating:
            return 0.0
        x, y = self.pairing.pushes[0]
        return float(np.arctan2(y, x))

    @property
    def springs(self) -> Floats:
        """(3, 2, 2) Displacements of the bodies on their bearings by forces, mm/N."""
        found = np.zeros((BODIES, 2, 2))
        if self.bearing_N_per_mm is not None:
            found[self.pairing.common] = np.eye(2) / self.bearing_N_per_mm
        return found

    def places(self, body: int) -> list[tuple[int, int]]:
        """Mesh, and number of the body in it, of each mesh of a body."""
        every = enumerate(self.pairing.members)
        return [(m, both.index(body)) for m, both in every if body in both]

    def body_records(self) -> list[Floats]:
        """Records of the bodies."""
        return [self._record(body) for body in range(BODIES)]

    def _record(self, b: int) -> Floats:
        """Record of a body; flanks of meshes in a mirror image are coast flanks."""
        body, compliance = self.bodies[b], self.compliances[b]
        angles, deviations, teeth, working = [], [], [], 0
        for m, z in self.places(b):
            pairing = self.meshes[m].pairing
            angles.append(pairing.site_angles_rad[z])
            deviations.append(pairing.site_deviations_mm[z])
            teeth.append(pairing.site_teeth[z])
            working += pairing.sites.size if self.pairing.meshes[m].sense > 0 else 0
        numbers = np.concatenate(teeth)
        if not working:
            # coast flanks are the working flanks of the mirror image, whose teeth run clockwise
            numbers, working = -numbers % body.teeth, numbers.size
        block = compliance.blocks_of_sites(numbers, working, body.teeth)
        if not self.coupled and not compliance.is_rigid:
            mesh_of = np.repeat(np.arange(len(teeth)), [part.size for part in teeth])
            compliance, block = compliance.apart(mesh_of[:, None] != mesh_of, block)
        m, z = self.places(b)[0]
        record = packed_body(
            body,
            compliance,
            angles_rad=np.concatenate(angles),
            deviations_mm=np.concatenate(deviations),
            block=block,
            slices=self.meshes[m].slices,
            which=z,
        )
        springs = self.springs[b]
        if not springs.any():
            return record
        support = np.zeros((3, 3))
        support[:2, :2] = springs
        return with_support(record, support)

    def mesh_records(self) -> list[Floats]:
        """Records of the meshes."""
        found, before = [], [0] * BODIES
        for mesh, placed, (one, two) in zip(
            self.meshes, self.pairing.meshes, self.pairing.members, strict=True
        ):
            sites = before[one], before[two]
            frame = placed.frame_rad - self.turn_rad
            members = Members((one, two), sites, frame, placed.sense)
            found.append(with_members(packed_mesh(mesh, self.grid, self.level), members))
            for body in (one, two):
                before[body] += core_sites(mesh)
        return found


@dataclass(frozen=True)
class TrainSweep:
    """States of a train at P positions under one torque.

    Attributes
    ----------
    all_meshes : Sweep
        With a site for each mesh: its force, and its largest pressure.
    meshes : two Sweep
        The rotation is the approach of the flanks along the line of action over the base radius of
        body 1 of the mesh.
    moved_mm : (P, 3, 2) array
        Displacements of the bodies by motions and springs.
    resultants : (P, 3, 3) array
        Force (N) of all contacts on each body, and moment about its axis (N mm).
    """

    all_meshes: Sweep
    meshes: tuple[Sweep, ...]
    moved_mm: Floats
    resultants: Floats

    @property
    def certificate(self) -> Floats:
        """(P, 3) Certificate of each state."""
        return self.all_meshes.certificate


def train_problem(
    contact: TrainContact, position_rad: Floats, torques_Nmm: Sequence[float] | Floats
) -> tuple[list[Floats], list[Floats], tuple[Motion, ...], Floats, Floats, Floats]:
    """Arguments of `solve_meshes`: records, motions, angles, loads, displacements.

    In place of the torque 0 there is a vanishing one, which keeps the flanks in contact.
    """
    torques, motions = np.asarray(torques_Nmm, dtype=float), contact.motions
    mesh = contact.meshes[0]
    least = VANISHING * mesh.face_width_mm * mesh.pairing.center_distance_mm
    loads = np.zeros((torques.size, len(motions)))
    loads[:, 0] = np.where(torques > 0.0, torques, least)
    displacements = np.zeros((position_rad.size, BODIES, 3))
    displacements[:, 2, 2] = contact.timing_mm / contact.base_radii_mm[2]
    angles = np.stack([one.turns(position_rad) for one in contact.pairing.meshes], axis=1)
    return (contact.body_records(), contact.mesh_records(), motions, angles, loads, displacements)


def sweep_train(
    contact: TrainContact,
    position_rad: Floats,
    torques_Nmm: Sequence[float],
    *,
    keep_pairs: bool = True,
    account: Account | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[TrainSweep, ...]:
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
            sweep_train(part, position_rad, [t], keep_pairs=keep_pairs, account=account)[0]
            for part, t in zip(parts, torques, strict=True)
        )
    found = solve_meshes(*train_problem(contact, position_rad, torques), keep_pairs=keep_pairs)
    if account is not None:
        sums = found.counters.sum(axis=(0, 1), dtype=np.int64).tolist()
        account.count(states=found.status.size, **dict(zip(CORE_COUNTERS, sums, strict=True)))
    certificates = found.certificate.transpose(2, 0, 1)
    raise_first_failure(found.status, position_rad, torques, certificates, has_friction=False)
    if progress is not None:
        progress(position_rad.size, position_rad.size)
    if not torques.any():
        found = found.without_forces()
    return tuple(_sweep_of(contact, found, t, float(torque)) for t, torque in enumerate(torques))


def _sweep_of(contact: TrainContact, found: MeshStates, t: int, torque_Nmm: float) -> TrainSweep:
    """States under the torque with this index."""
    pairing, radii = contact.pairing, np.array(contact.base_radii_mm)
    motions, forces = found.motion[:, t], found.resultant[:, t].copy()
    forces[:, :, :2] = turned(forces[:, :, :2], contact.turn_rad)
    moved = np.einsum("pbx,bxy->pby", forces[:, :, :2], contact.springs)
    places = np.zeros((len(motions), BODIES, 3))
    for motion, column in zip(contact.motions, motions.T, strict=True):
        kind = ("x", "y", "rotation").index(motion.kind)
        places[:, motion.body, kind] += motion.sign * np.nan_to_num(column)
    moved += turned(places[:, :, :2], contact.turn_rad)
    places[:, :, :2] = moved
    approach = np.einsum("mbk,pbk->pm", pairing.rows(contact.base_radii_mm), places)
    first = np.array([one for one, _ in pairing.members])
    torques = torque_Nmm * radii[first] / radii[0] / (1 if pairing.is_idler else 2)
    meshes = sweeps_of_meshes(found, t, contact.meshes, torques.tolist())
    meshes = with_rotations(meshes, approach / radii[first])
    force = np.stack([mesh.site_force_N.sum(axis=1) for mesh in meshes], axis=-1)
    peaks = []
    for mesh in meshes:
        at = mesh.site_peak_N_per_mm.argmax(axis=1)[:, None]
        both = mesh.site_peak_N_per_mm, mesh.site_corner
        peaks.append([np.take_along_axis(part, at, axis=1)[:, 0] for part in both])
    peak, corner = (np.stack(part, axis=-1) for part in zip(*peaks, strict=True))
    pairs = found.pairs[t]
    every = Sweep(
        torque_Nmm=torque_Nmm,
        rotation_rad=motions[:, 0],
        tangent_rad_per_Nmm=found.tangent[:, t, 0, 0],
        **over_slices((force, peak, corner), plane_slice(1.0)),
        site_force_per_torque=force / (torque_Nmm or 1.0),
        n_pairs=pairs.count,
        pairs=pairs,
        **states_of_torque(found, t),
    )
    return TrainSweep(every, meshes, moved, forces)
