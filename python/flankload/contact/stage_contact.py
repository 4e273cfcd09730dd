"""A planetary stage as bodies, gear meshes and motions for the core."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from flankload.base.rotation import directions
from flankload.contact.body_record import packed_body, packed_mesh
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.meshes import (
    Members,
    Motion,
    solve_meshes,
    with_members,
    with_support,
)
from flankload.contact.status import raise_first_failure
from flankload.contact.sweep import Sweep
from flankload.pairing.stage_paths import paths_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Body
    from flankload.contact.flank_contact import Level
    from flankload.contact.meshes import MeshStates
    from flankload.cost import Account
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.stage import StageMesh, StagePairing
    from flankload.pairing.stage_errors import StageErrors
    from flankload.scene.discretization import Grid

Floating = Literal["none", "sun", "ring", "carrier"]
#: Torque in place of none, N mm per mm of the centre distance and of the face width: deflections by
#: it are of the order of rounding errors. States without load are limits for vanishing torques, in
#: which the members that float still follow from the balance of their forces.
VANISHING = 1e-5


@dataclass(frozen=True)
class StageSupports:
    """How the members of a stage are held.

    Attributes
    ----------
    floating : str
        The member that is free to move in the plane.
    ring_free : bool
        Whether the rim of the ring bends freely, so that the ring floats, too.
    pin_N_per_mm : (float, float) or None
        Radial and tangential stiffness of each pin; None if they are rigid.
    sun_N_per_mm : float or None
        Radial stiffness of the support of a floating sun, if it has one.
    sun_load_N : (float, float)
        Weight of the sun in x and y.
    """

    floating: Floating = "none"
    ring_free: bool = False
    pin_N_per_mm: tuple[float, float] | None = None
    sun_N_per_mm: float | None = None
    sun_load_N: tuple[float, float] = (0.0, 0.0)

    def pin_compliance(self, angle_rad: float) -> Floats:
        """(2, 2) Displacement of a planet at a polar angle by its force on the pin, mm/N."""
        if self.pin_N_per_mm is None:
            return np.zeros((2, 2))
        axes = directions(np.array([angle_rad, angle_rad + 0.5 * np.pi]))
        found = axes.T @ np.diag(1.0 / np.array(self.pin_N_per_mm)) @ axes
        return np.asarray(0.5 * (found + found.T))

    def motions(self, count: int) -> tuple[Motion, ...]:
        """Rotations of the sun and of the planets, clockwise, then those of a floating member."""
        turning = [Motion(0), *(Motion(1 + j, sign=-1) for j in range(count))]
        bodies = {"sun": (0, 0), "carrier": (1, count), "ring": (1 + count, 1 + count)}
        member = self.moving
        if member is None:
            return tuple(turning)
        body, last = bodies[member]
        return (*turning, Motion(body, "x", last=last), Motion(body, "y", last=last))

    @property
    def moving(self) -> Literal["sun", "ring", "carrier"] | None:
        """The member that moves in the plane without springs."""
        if self.ring_free:
            return "ring"
        if self.floating == "none" or (self.floating == "sun" and self.sun_N_per_mm is not None):
            return None
        return self.floating

    def loads(self, torques_Nmm: Sequence[float] | Floats, count: int) -> Floats:
        """(T, q) Loads of the motions."""
        found = np.zeros((len(torques_Nmm), len(self.motions(count))))
        found[:, 0] = torques_Nmm
        if self.moving == "sun":
            found[:, 1 + count :] = self.sun_load_N
        return found


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
    errors : StageErrors
    supports : StageSupports
    face_width_mm : float
    grid : Grid
    level : str
        As of `FlankContact`.
    """

    bodies: tuple[Body, Body, Body]
    compliances: tuple[BodyCompliance, BodyCompliance, BodyCompliance]
    pairing: StagePairing
    errors: StageErrors
    supports: StageSupports
    face_width_mm: float
    grid: Grid
    level: Level = "pairs"

    @property
    def count(self) -> int:
        """Number of planets."""
        return self.pairing.count

    @property
    def site_counts(self) -> tuple[int, ...]:
        """(2n,) Number of sites of each mesh."""
        return tuple(mesh.pairing.sites.size for mesh in self.pairing.meshes)

    def body_records(self) -> list[Floats]:
        """Records of sun, planets and ring."""
        n, meshes = self.count, self.pairing.meshes
        planets = [
            self._record(1, [(meshes[j], 1), (meshes[n + j], 0)], working=1, planet=j)
            for j in range(n)
        ]
        return [
            self._record(0, [(mesh, 0) for mesh in meshes[:n]], working=n),
            *planets,
            self._record(2, [(mesh, 1) for mesh in meshes[n:]], working=0),
        ]

    def _record(
        self,
        which: int,
        places: list[tuple[StageMesh, int]],
        *,
        working: int,
        planet: int | None = None,
    ) -> Floats:
        """Record of a body with its places in meshes; the first ones are on its working flanks.

        Flanks of meshes with the ring are coast flanks, of the whole body in its mirror image.
        """
        body, compliance = self.bodies[which], self.compliances[which]
        pairings = [(mesh.pairing, z) for mesh, z in places]
        angles = np.concatenate([pairing.site_angles_rad[z] for pairing, z in pairings])
        deviations = np.concatenate([pairing.site_deviations_mm[z] for pairing, z in pairings])
        teeth = np.concatenate([pairing.site_teeth[z] for pairing, z in pairings])
        n_working = sum(pairing.sites.size for pairing, _ in pairings[:working])
        if not working:  # the mirror image of the whole body, whose teeth run clockwise
            teeth, n_working = -teeth % body.teeth, teeth.size
        support = np.zeros((3, 3))
        if planet is not None:
            deviations = deviations + 0.5 * self.errors.thickness_mm[planet]
            support[:2, :2] = self.supports.pin_compliance(float(self.pairing.angles_rad[planet]))
        elif which == 0 and self.supports.sun_N_per_mm is not None:
            support[:2, :2] = np.eye(2) / self.supports.sun_N_per_mm
        record = packed_body(
            body,
            compliance,
            angles_rad=angles,
            deviations_mm=deviations,
            block=compliance.blocks_of_sites(teeth, n_working, body.teeth),
            face_width_mm=self.face_width_mm,
        )
        return with_support(record, support) if support.any() else record

    def mesh_records(self) -> list[Floats]:
        """Records of the meshes: those with the sun, then those with the ring."""
        n, sites = self.count, self.site_counts
        found = []
        for k, mesh in enumerate(self.pairing.meshes):
            j = mesh.planet
            with_ring = k >= n
            members = Members(
                (1 + j, n + 1) if with_ring else (0, 1 + j),
                (sites[j], sum(sites[n:k])) if with_ring else (sum(sites[:k]), 0),
                mesh.frame_rad,
                mesh.sense,
            )
            distance = self.pairing.center_distance_mm
            found.append(
                with_members(packed_mesh(sites[k], distance, self.grid, self.level), members)
            )
        return found


@dataclass(frozen=True)
class StageSweep:
    """States of a stage at P positions under one torque.

    Attributes
    ----------
    planets : Sweep
        With a site for each planet: its force in the mesh with the sun, the largest pressure of
        both its meshes. Without pairs.
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
) -> tuple[list[Floats], list[Floats], tuple[Motion, ...], Floats, Floats, Floats | None]:
    """Arguments of `solve_meshes`: records, motions, angles, loads, displacements.

    In place of the torque 0 there is a vanishing one, which keeps the flanks in contact.
    """
    pairing, supports = contact.pairing, contact.supports
    torques = np.asarray(torques_Nmm, dtype=float)
    least = VANISHING * contact.face_width_mm * pairing.center_distance_mm
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
    problem = stage_problem(contact, position_rad, torques_Nmm)
    found = solve_meshes(*problem, keep_pairs=keep_pairs)
    if account is not None:
        sums = found.counters.sum(axis=(0, 1), dtype=np.int64).tolist()
        account.count(states=found.status.size, **dict(zip(CORE_COUNTERS, sums, strict=True)))
    raise_first_failure(
        found.status,
        position_rad,
        torques,
        found.certificate.transpose(2, 0, 1),
        has_friction=False,
    )
    if progress is not None:
        progress(position_rad.size, position_rad.size)
    if not torques.any():
        found = found.without_forces()
    return tuple(_sweep_of(contact, found, t, float(torque)) for t, torque in enumerate(torques))


def _sweep_of(contact: StageContact, found: MeshStates, t: int, torque_Nmm: float) -> StageSweep:
    """States under the torque with this index."""
    n = contact.count
    of_torque: dict[str, Any] = {
        name: getattr(found, name)[:, t] for name in ("status", "certificate", "counters")
    }
    ends = np.cumsum(contact.site_counts)
    sites = {
        name: np.split(getattr(found, name)[:, t], ends[:-1], axis=1)
        for name in ("site_force_N", "site_peak_N_per_mm", "site_corner")
    }
    pairs = found.pairs[t]
    n_pairs, motions = pairs.count, found.motion[:, t]
    moved = _displacements(contact, motions, found.resultant[:, t])
    approach = _approaches(contact, motions, moved)
    tangent = found.tangent[:, t]
    meshes = []
    for m, mesh in enumerate(contact.pairing.meshes):
        first, pairs = pairs.split_at(contact.site_counts[m])
        base_radius = contact.bodies[1 if mesh.with_ring else 0].base_radius_mm or 1.0
        own: dict[str, Any] = {name: parts[m] for name, parts in sites.items()}
        meshes.append(
            Sweep(
                torque_Nmm=_nominal_torque(contact, mesh, torque_Nmm),
                rotation_rad=approach[:, m] / base_radius,
                tangent_rad_per_Nmm=np.zeros(len(approach)),
                site_force_per_torque=np.zeros_like(own["site_force_N"]),
                n_pairs=first.count,
                pairs=first,
                **of_torque,
                **own,
            )
        )
    planets = Sweep(
        torque_Nmm=torque_Nmm,
        rotation_rad=motions[:, 0],
        tangent_rad_per_Nmm=tangent[:, 0, 0],
        site_force_N=_by_planet(sites["site_force_N"][:n], np.sum),
        site_peak_N_per_mm=_largest_peaks(sites, n)[0],
        site_corner=_largest_peaks(sites, n)[1],
        site_force_per_torque=_by_planet(sites["site_force_N"][:n], np.sum) / (torque_Nmm or 1.0),
        n_pairs=n_pairs,
        pairs=found.pairs[t],
        **of_torque,
    )
    floats = contact.supports.moving == "carrier"
    carrier = motions[:, -2:] if floats else np.zeros((len(motions), 2))
    return StageSweep(planets, tuple(meshes), moved, found.resultant[:, t], carrier, motions)


def _by_planet(parts: Sequence[Floats], reduce: Any) -> Floats:
    """(P, n) Reduction of the sites of one mesh per planet."""
    return np.stack([reduce(part, axis=1) for part in parts], axis=-1)


def _largest_peaks(sites: dict[str, list[Any]], n: int) -> tuple[Floats, Numbers]:
    """(P, n) Largest force over cell width in both meshes of each planet, and the corner there."""
    peaks, corners = sites["site_peak_N_per_mm"], sites["site_corner"]
    found = []
    for j in range(n):
        peak = np.concatenate([peaks[j], peaks[n + j]], axis=1)
        corner = np.concatenate([corners[j], corners[n + j]], axis=1)
        at = peak.argmax(axis=1)[:, None]
        found.append([np.take_along_axis(part, at, axis=1)[:, 0] for part in (peak, corner)])
    return tuple(np.stack(part, axis=-1) for part in zip(*found, strict=True))  # type: ignore[return-value]


def _nominal_torque(contact: StageContact, mesh: StageMesh, torque_Nmm: float) -> float:
    """Torque on body 1 of a mesh if all planets carry the same."""
    ratio = contact.pairing.teeth[1] / contact.pairing.teeth[0] if mesh.with_ring else 1.0
    return torque_Nmm * ratio / contact.count


def _displacements(contact: StageContact, motions: Floats, resultants: Floats) -> Floats:
    """(P, n + 2, 2) Displacements of sun, planets and ring by motions and supports, mm."""
    supports, n = contact.supports, contact.count
    moved = np.zeros((*resultants.shape[:2], 2))
    for motion, column in zip(supports.motions(n), motions.T, strict=True):
        if motion.kind != "rotation":
            bodies = slice(motion.body, motion.through + 1)
            moved[:, bodies, "xy".index(motion.kind)] += motion.sign * column[:, np.newaxis]
    if supports.sun_N_per_mm is not None:
        moved[:, 0] += resultants[:, 0, :2] / supports.sun_N_per_mm
    for j, angle in enumerate(contact.pairing.angles_rad):
        moved[:, 1 + j] += resultants[:, 1 + j, :2] @ supports.pin_compliance(float(angle))
    return moved


def _approaches(contact: StageContact, motions: Floats, moved_mm: Floats) -> Floats:
    """(P, 2n) Approach of the flanks of each mesh along its line of action, mm."""
    paths, n = paths_of(contact.pairing), contact.count
    turns = np.nan_to_num(motions[:, : 1 + n])
    found = turns[:, :1] * paths.sun_rows[:, 0] + moved_mm[:, 0] @ paths.sun_rows[:, 1:].T
    found += moved_mm[:, -1] @ paths.ring_rows[:, 1:].T
    found += np.einsum("pn,mn->pm", turns[:, 1:], paths.planet_rows[:, :, 0])
    found += np.einsum("pnx,mnx->pm", moved_mm[:, 1:-1], paths.planet_rows[:, :, 1:])
    return np.asarray(found)
