"""Sweep over all positions and torques in one call of the core."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from flankload.contact.body_record import core_sites
from flankload.contact.core_call import CORE_COUNTERS, CoreCall, CoreOutput, KnownContacts
from flankload.contact.pair_table import PackedPairs, join_pairs
from flankload.contact.status import (
    SiteCorner,
    is_marked,
    raise_first_failure,
    with_sharp_ends,
    worst_corner,
)
from flankload.cost import Account

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from flankload.contact.flank_contact import FlankContact
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.pairing.slices import Slices

    Record = TypeVar("Record", "Sweep", "CoastSweep", "SliceStates", "UnloadedStates")

#: Fields of a sweep without an axis of positions.
WITHOUT_POSITIONS = ("torque_Nmm", "edges_mm", "line_load_mm", "sharp_ends", "conforming", "plane")
#: Results of the core for each site and slice.
SITE_RESULTS = ("site_force_N", "site_peak_N_per_mm", "site_corner")
#: Relative step of the torque for tangents: the error is below 1e-7 by the curvature, as well as by
#: rounding.
STEP = 1e-4
#: Allocated pairs in the first call, per position and torque: twice the usual number.
INITIAL_PAIRS = 256
#: The same for contact on all teeth, per site and cell between the middle and the edge of its zone:
#: 2.8 for two sides and finer cells at the ends of conforming flanks, and a reserve.
PAIRS_PER_CELL = 3.2
#: Further cells of a flank or slice besides those of its zone; in slices, number of flanks in mesh.
LEAST_CELLS, MESHING_FLANKS = 8, 4


@dataclass(frozen=True)
class CoastSweep:
    """Results on coast flanks, as in `Sweep`; the lever arms of their pairs are negative."""

    site_force_N: NDArray[np.float64]
    site_peak_N_per_mm: NDArray[np.float64]
    site_corner: NDArray[np.int64]
    pairs: PackedPairs


@dataclass(frozen=True)
class SliceStates:
    """Results in J slices of the flanks.

    Attributes
    ----------
    force_N, peak_MPa, corner : (P, S, J) arrays
        Force, largest pressure and corner (as `Sweep.site_corner`) of each slice.
    edges_mm : (J + 1,) array
        Ends of the slices along the axis.
    line_load_mm : float
        Length over which line loads are means.
    sharp_ends : (int, int)
        As in `Slices`.
    conforming : bool
        Whether the flanks conform; pressures are then means over the height.
    plane : bool
        Whether this is the only slice of a plane mesh, whose peaks are forces over cell widths.
    """

    force_N: NDArray[np.float64]
    peak_MPa: NDArray[np.float64]
    corner: NDArray[np.int64]
    edges_mm: NDArray[np.float64]
    line_load_mm: float
    sharp_ends: tuple[int, int]
    conforming: bool = False
    plane: bool = False

    @property
    def corner_off_ends(self) -> NDArray[np.int64]:
        """(P, S, J) Corners, but contact on sharp ends only as one that no parabola approximates.

        A corner of a tip, whose force turns, also in such a slice is found in its neighbours.
        """
        corner = self.corner.copy()
        for j, body in ((0, self.sharp_ends[0]), (-1, self.sharp_ends[1])):
            if body:
                corner[..., j] = np.minimum(corner[..., j], SiteCorner.NOT_PARABOLIC)
        return corner


@dataclass(frozen=True)
class UnloadedStates:
    """States without torque.

    Attributes
    ----------
    rotation_rad : (P,) array
    touches : (P, S) array of bool
        Sites that touch.
    """

    rotation_rad: NDArray[np.float64]
    touches: NDArray[np.bool_]


@dataclass(frozen=True)
class Sweep:
    """Results of the core at all positions (P) for one torque; S sites.

    Attributes
    ----------
    torque_Nmm : float
    status, rotation_rad, tangent_rad_per_Nmm : (P,) arrays
    certificate : (P, 3) array
        Backward error, condition, margin.
    counters : (P, 7) array
        Cost of each state: `core_call.CORE_COUNTERS`.
    site_force_N, site_peak_N_per_mm, site_corner : (P, S) arrays
        Force; largest force over cell width; `status.SiteCorner`. With slices: sum of the forces,
        largest pressure, MPa.
    site_force_per_torque : (P, S) array
        Derivative of the forces with respect to the torque, 1/mm; force over torque until it is
        computed.
    n_pairs : (P,) array
        Including those of coast flanks.
    pairs : PackedPairs
        Pairs of working flanks; empty if they are not stored.
    coast : CoastSweep or None
        Results of the coast flanks, if they can carry load.
    slices : SliceStates
        Results in slices, a single one in the plane.
    unloaded : UnloadedStates or None
        Results without torque, if computed.
    """

    torque_Nmm: float
    status: NDArray[np.int64]
    rotation_rad: NDArray[np.float64]
    tangent_rad_per_Nmm: NDArray[np.float64]
    certificate: NDArray[np.float64]
    counters: NDArray[np.int64]
    site_force_N: NDArray[np.float64]
    site_peak_N_per_mm: NDArray[np.float64]
    site_corner: NDArray[np.int64]
    site_force_per_torque: NDArray[np.float64]
    n_pairs: NDArray[np.int64]
    pairs: PackedPairs
    slices: SliceStates
    coast: CoastSweep | None = None
    unloaded: UnloadedStates | None = None

    @property
    def turned_rad(self) -> NDArray[np.float64]:
        """(P,) Rotation minus that without torque, if computed."""
        if self.unloaded is None:
            return self.rotation_rad
        return self.rotation_rad - self.unloaded.rotation_rad


def sweep(
    contact: FlankContact,
    position_rad: NDArray[np.float64],
    torques_Nmm: Sequence[float],
    *,
    known: KnownContacts | None = None,
    tangents: bool = False,
    unloaded: bool = False,
    keep_pairs: bool = True,
    account: Account | None = None,
    progress: Callable[[int, int], None] | None = None,
    watched: bool = True,
) -> tuple[Sweep, ...]:
    """Solve all positions for all torques in one call of the core: a Sweep for each torque.

    If `watched`, the core runs in another thread: Ctrl-C, or an exception from `progress`, stops it
    within milliseconds. The result for a torque at a position is bitwise independent of other
    torques, other positions and the number of threads.

    Parameters
    ----------
    position_rad : (P,) array
        Angle of body 1 from position zero.
    torques_Nmm : sequence of float
        Torques on body 1, >= 0.
    known : KnownContacts, optional
        Pairs in contact in a similar sweep (`known_contacts`), which are used for states with the
        same number of pairs, without a search and a certificate.
    tangents : bool
        Whether the derivatives of rotation and forces follow cells that move with the torque: the
        states are continued to a slightly larger torque. For fixed cells, derivatives are 0.1 to
        0.3 % off on gears with ten cells on the half-width, since contacts become longer.
    unloaded : bool
        Whether the states without torque are added, from which the deflection under torque is
        measured: deviations of pitch and profile, an offset of the axes, expansion and preload
        rotate body 1 without any torque. They are None if there is no such state at a position.
    keep_pairs : bool
        Whether single pairs are stored, besides results per site.
    account, progress : optional
        Account of all work, also that for states without a solution; progress(done, P) is called
        several times a second.

    Raises
    ------
    FlankloadError
        For the first position without a solution for a torque. `NoContactState` contains the
        largest possible torque there.
    """
    spent, mesh = Account() if account is None else account, contact.mesh
    torques = np.asarray(torques_Nmm, dtype=float)
    positions = np.asarray(position_rad, dtype=float)
    beside = [1.0, 1.0 + STEP] if tangents else [1.0]
    asked = np.outer(torques, beside).ravel()
    own = slice(0, asked.size, len(beside))
    if tangents:
        known = KnownContacts.of_torque_before(positions.size, torques.size)
    if unloaded and torques.all():
        asked = np.append(asked, 0.0)
    core = CoreCall(
        contact=contact,
        n_sites=core_sites(mesh),
        motion=motion_of(mesh, positions),
        torques_Nmm=asked,
        account=spent,
        progress=progress,
        watched=watched,
        known=None if known is None else known.for_torques(asked.size),
        own=own,
    )
    found = core.all_positions(_initial_capacity(contact) if keep_pairs else 0)
    spent.workspace_bytes = max(spent.workspace_bytes, found.nbytes)
    raise_first_failure(
        found.status[:, own],
        positions,
        torques,
        found.certificate[..., own],
        has_friction=mesh.friction is not None,
        holds=core.holds,
    )
    if not mesh.slices.plane:
        spent.count(slices=mesh.slices.count * positions.size * torques.size)
    sweeps = tuple(_sweep_of(found, mesh, t, torque) for t, torque in enumerate(asked))
    parts = sweeps[own]
    if tangents:
        parts = tuple(map(_differenced, parts, sweeps[1::2]))
    none = next((part for part in sweeps if part.torque_Nmm == 0.0), None) if unloaded else None
    if none is None or (none.status < 0).any():
        return parts
    states = UnloadedStates(none.rotation_rad, is_marked(none.site_corner))
    return tuple(replace(part, unloaded=states) for part in parts)


def known_contacts(found: Sequence[Sweep]) -> KnownContacts | None:
    """Pairs in contact in sweeps of the same positions, one for each torque, for similar sweeps.

    None for lumped contacts. States with repeated divisions into cells are left out,
    since their cells depend on previous forces.
    """
    passes = CORE_COUNTERS.index("contact_passes")
    if not any(part.counters[:, passes].any() for part in found):
        return None
    touches, count = [], []
    for part in found:
        # at each position, pairs of coast flanks are behind those of working flanks
        both = [part.pairs] if part.coast is None else [part.pairs, part.coast.pairs]
        position = np.concatenate([pairs.position for pairs in both])
        forces = np.concatenate([pairs.column("force") for pairs in both])
        touches.append(forces[np.argsort(position, kind="stable")] > 0.0)
        count.append(sum(pairs.count for pairs in both))
    ends = np.cumsum(np.concatenate(count))
    first = (ends - np.concatenate(count)).reshape(len(found), -1).T
    laid_once = np.column_stack([part.counters[:, passes] == 1 for part in found])
    return KnownContacts(
        touches=np.concatenate(touches).astype(np.intc),
        count=np.where(laid_once, np.column_stack(count), 0),
        first=first,
    )


def over_slices(parts: Sequence[NDArray[Any]], slices: Slices) -> dict[str, Any]:
    """Results of the sites and of their slices by name, from `SITE_RESULTS` (P, S J) of these."""
    shape = len(parts[0]), parts[0].shape[1] // slices.count, slices.count
    force, peak, corner = (part.reshape(shape) for part in parts)
    corner = with_sharp_ends(corner, force, slices.sharp_ends)
    states = SliceStates(
        force,
        peak,
        corner,
        slices.edges_mm,
        slices.line_load_mm,
        slices.sharp_ends,
        conforming=slices.conforming is not None,
        plane=slices.plane,
    )
    return {
        "site_force_N": force.sum(axis=2),
        "site_peak_N_per_mm": peak.max(axis=2),
        "site_corner": worst_corner(corner),
        "slices": states,
    }


def motion_of(mesh: GearMesh, position_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """(4, P) angles of both bodies, rad, and their speeds, which are 0 without friction."""
    motion = np.zeros((4, position_rad.size))
    motion[:2] = mesh.pairing.turns(position_rad)
    if mesh.friction is not None:
        motion[2:] = mesh.friction.speeds(mesh.pairing, position_rad)
    return motion


def _sweep_of(found: CoreOutput, mesh: GearMesh, t: int, torque_Nmm: float) -> Sweep:
    """Results for one torque, with separate results of the coast flanks."""
    of_torque: dict[str, Any] = {name: part[..., t].T for name, part in found.states.items()}
    sites = [of_torque.pop(name) for name in SITE_RESULTS]
    pairs = replace(found.pairs_of(t), slice_count=mesh.slices.count)
    coast = None
    if mesh.pairing.coast is not None:
        n = sites[0].shape[1] // 2
        pairs, coast_pairs = pairs.split_at(n)
        own = over_slices([part[:, n:] for part in sites], mesh.slices)
        coast = CoastSweep(**{name: own[name] for name in SITE_RESULTS}, pairs=coast_pairs)
        sites = [part[:, :n] for part in sites]
    of_torque |= over_slices(sites, mesh.slices)
    return Sweep(
        torque_Nmm=float(torque_Nmm),
        site_force_per_torque=of_torque["site_force_N"] / (torque_Nmm or 1.0),
        pairs=pairs,
        coast=coast,
        **of_torque,
    )


def _differenced(part: Sweep, beside: Sweep) -> Sweep:
    """With derivatives from the states beside; those of fixed cells where there are none."""
    step = beside.torque_Nmm - part.torque_Nmm
    if not step:
        return part
    solved = beside.status >= 0
    # the mean tangent over the step, less its change over half of the step
    bend = 0.5 * (beside.tangent_rad_per_Nmm - part.tangent_rad_per_Nmm)
    tangent = (beside.rotation_rad - part.rotation_rad) / step - bend
    forces = (beside.site_force_N - part.site_force_N) / step
    return replace(
        part,
        tangent_rad_per_Nmm=np.where(solved, tangent, part.tangent_rad_per_Nmm),
        site_force_per_torque=np.where(solved[:, None], forces, part.site_force_per_torque),
    )


def _initial_capacity(contact: FlankContact) -> int:
    """Number of allocated pairs per state, sufficient for nearly all states."""
    pairing, slices = contact.mesh.pairing, contact.mesh.slices
    sides, sites = 1 if pairing.coast is None else 2, pairing.sites.size
    cells = contact.grid.zone_half_widths * contact.grid.strips_per_half_width
    if not slices.plane:
        of_cells = int(min(sites, MESHING_FLANKS) * (2.0 * cells + LEAST_CELLS))
        lumped = contact.level == "lumped" or slices.conforming is not None
        return sides * slices.count * (2 * sites if lumped else of_cells)
    if not pairing.whole_circle:
        return sides * INITIAL_PAIRS
    return sides * max(INITIAL_PAIRS, int(PAIRS_PER_CELL * (cells + LEAST_CELLS) * sites))


def join_sweeps(parts: Sequence[Record], order: NDArray[np.int64]) -> Record:
    """Join sweeps of different positions for the same torque and the same sites, field by field.

    `order` (P,) are indices into the concatenated positions of the parts, in their new order.
    """
    joined: dict[str, Any] = {}
    for item in fields(parts[0]):
        values = [getattr(part, item.name) for part in parts]
        if item.name in WITHOUT_POSITIONS:
            continue
        if any(value is None for value in values):
            joined[item.name] = None
        elif isinstance(values[0], PackedPairs):
            joined[item.name] = join_pairs(values, order)
        elif isinstance(values[0], np.ndarray):
            joined[item.name] = np.concatenate(values)[order]
        else:
            joined[item.name] = join_sweeps(values, order)
    return replace(parts[0], **joined)
