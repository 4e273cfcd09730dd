"""All positions and torques of a sweep: bodies and compliances go into one call of the core."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from flankload import _core
from flankload.contact.interruptible import call_and_watch
from flankload.contact.pair_table import COLUMNS, FRICTION_COLUMNS, PackedPairs, join_pairs
from flankload.contact.status import NO_ROOM, STOPPED
from flankload.contact.sweep_failure import raise_first_failure
from flankload.cost import Account, held_bytes
from flankload.errors import InputError
from flankload.pairing.friction import FrictionArguments

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from flankload.bodies.body import Body
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.friction import Friction
    from flankload.pairing.pairing import Pairing
    from flankload.scene.discretization import Grid

#: Levels of contact, cheapest last, as the core numbers them.
Level = Literal["pairs", "lumped"]
LEVELS: dict[Level, int] = {"pairs": 0, "lumped": 1}
#: Mark of an end of a curve that is cut: nothing touches first there.
CUT_END = 2
#: What the core notes at a site where an end that is left out would touch.
END_WOULD_TOUCH = -3
#: What the core counts of every state, in its order.
CORE_COUNTERS = (
    "pivots",
    "influence_columns",
    "contact_passes",
    "refactorisations",
    "influence_columns_tangential",
    "lumped_solutions",
    "finite_solutions",
)
#: Room for pairs in the first call, per position and torque: twice what most jobs need. Memory that
#: is never written costs nothing.
FIRST_ROOM = 256
#: The same where all teeth may carry, per site and cell between its middle and the edge of its
#: zone: two sides, finer cells at the ends of conforming flanks (2.8 in all), some to spare.
ROOM_OF_CELL = 3.2


@dataclass(frozen=True)
class CoastSweep:
    """What the core found on coast flanks, at the pair numbers of the working ones.

    Attributes
    ----------
    site_force_N, site_peak_N_per_mm, site_corner : (P, S) arrays
        As in `Sweep`.
    pairs : PackedPairs
        Their torque levers are negative.
    """

    site_force_N: NDArray[np.float64]
    site_peak_N_per_mm: NDArray[np.float64]
    site_corner: NDArray[np.int64]
    pairs: PackedPairs


@dataclass(frozen=True)
class Sweep:
    """What the core found at all positions (P) for one torque; S sites.

    Attributes
    ----------
    torque_Nmm : float
    status, rotation_rad, tangent_rad_per_Nmm : (P,) arrays
    certificate : (P, 3) array
        Backward error, condition, margin.
    counters : (P, 7) array
        What each state took: `CORE_COUNTERS`.
    site_force_N, site_peak_N_per_mm, site_corner : (P, S) arrays
        Force; peak of force over cell width; body whose sharp corner works (0: none; -1: the site
        that touches without torque, -2: a lumped contact that no parabola makes, both off corners;
        -3: an end that is left out would touch).
    site_force_per_torque : (P, S) array
        Derivative of the forces by the torque, 1/mm; as long as that is not known, their part.
    n_pairs : (P,) array
        Those of coast flanks included.
    pairs : PackedPairs
        Of working flanks; empty where pairs are not kept.
    coast : CoastSweep or None
        The same of the coast flanks, where they can carry.
    unloaded_rad : (P,) array or None
        Rotation without torque, where that has been looked at.
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
    coast: CoastSweep | None = None
    unloaded_rad: NDArray[np.float64] | None = None

    @property
    def turned_rad(self) -> NDArray[np.float64]:
        """(P,) Rotation beyond that without torque, as far as that is known."""
        unloaded = self.unloaded_rad
        return self.rotation_rad if unloaded is None else self.rotation_rad - unloaded


def sweep(
    bodies: tuple[Body, Body],
    *,
    compliances: tuple[BodyCompliance, BodyCompliance],
    pairing: Pairing,
    position_rad: NDArray[np.float64],
    torques_Nmm: Sequence[float],
    face_width_mm: float,
    grid: Grid,
    level: Level = "pairs",
    friction: Friction | None = None,
    finite_steps: int = 0,
    keep_pairs: bool = True,
    account: Account | None = None,
    progress: Callable[[int, int], None] | None = None,
    watched: bool = True,
) -> tuple[Sweep, ...]:
    """Solve all positions for all torques in one call of the core.

    The core runs beside the main thread: Ctrl-C, or an exception from `progress`, stops it within
    milliseconds. The answer for a torque at a position depends on no other torque or position and
    not on the number of threads, to the last bit.

    Parameters
    ----------
    bodies, compliances, pairing
        From the stages before.
    position_rad : (P,) array
        Angle of body 1 from position zero.
    torques_Nmm : sequence of float
        Torques on body 1, >= 0.
    face_width_mm : float
        Width over which both bodies touch.
    grid : Grid
        How fine the cells are.
    level : str
        "pairs": contact pairs on cells. "lumped": one unknown for each place of contact, as wide as
        Hertz contact; no cells, hence no influence columns, and a pair for each place in the table.
        Its cell is π/2 half-widths, over which the largest pressure would carry the force. Flanks
        that conform have no such place.
    friction : Friction, optional
        Of the flanks; the compliances must have their tangential parts then.
    finite_steps : int
        Influence numbers of finite forces by so many steps of each force, 0: of small ones; the
        compliances must have their tangential parts then, with friction also those along.
    keep_pairs : bool
        Whether the single pairs are wanted; the numbers of the sites are there in any case.
    account : Account, optional
        Where all work of the core is counted, that for states without an answer too.
    progress : callable, optional
        Called as progress(done, P) several times a second.
    watched : bool
        Ctrl-C stops the core within milliseconds; a call that is over as soon needs no thread.

    Returns
    -------
    tuple of Sweep, one per torque

    Raises
    ------
    FlankloadError
        If a position has no answer for a torque; the message names the first one. `NoContactState`
        carries the largest torque that can be held there.
    """
    spent = Account() if account is None else account
    torques = np.asarray(torques_Nmm, dtype=float)
    positions = np.asarray(position_rad, dtype=float)
    arguments = _core_arguments(bodies, compliances, pairing, face_width_mm)
    along_flanks = _AlongFlanks.of(
        compliances if friction is not None or finite_steps else (), face_width_mm
    )

    def call(
        where: NDArray[np.float64],
        under: NDArray[np.float64],
        tell: Callable[[int, int], None] | None,
    ) -> _CoreCall:
        return _CoreCall(
            turns=pairing.turns(where),
            pairing=pairing,
            torques=under,
            arguments=arguments,
            grid=grid,
            level=level,
            rubbing=FrictionArguments.of(friction, pairing, where),
            along_flanks=along_flanks,
            finite_steps=finite_steps,
            account=spent,
            progress=tell,
            watched=watched,
        )

    def holds(k: int, under: NDArray[np.float64]) -> NDArray[np.bool_]:
        numbers = call(positions[k : k + 1], under, None).all_positions(0).numbers
        return np.asarray(numbers[0][0] >= 0)

    room = _first_room(pairing, grid) if keep_pairs else 0
    found = call(positions, torques, progress).all_positions(room)
    (status, rotation, tangent, certificate, counters, force, peak, corner, n_pairs) = found.numbers
    spent.workspace_bytes = max(spent.workspace_bytes, found.nbytes)
    raise_first_failure(
        status, positions, torques, certificate, rubs=friction is not None, holds=holds
    )
    working = slice(None, pairing.sites.size)

    def coast_of(t: int, pairs: PackedPairs) -> CoastSweep:
        behind = slice(pairing.sites.size, None)
        return CoastSweep(
            force[behind, :, t].T, peak[behind, :, t].T, corner[behind, :, t].T, pairs
        )

    def sweep_of(t: int) -> Sweep:
        pairs, coast = found.pairs_of(t), None
        if pairing.coast is not None:
            pairs, coast_pairs = pairs.parted_at(pairing.sites.size)
            coast = coast_of(t, coast_pairs)
        return Sweep(
            torque_Nmm=float(torques[t]),
            status=status[:, t],
            rotation_rad=rotation[:, t],
            tangent_rad_per_Nmm=tangent[:, t],
            certificate=certificate[..., t].T,
            counters=counters[..., t].T,
            site_force_N=force[working, :, t].T,
            site_peak_N_per_mm=peak[working, :, t].T,
            site_corner=corner[working, :, t].T,
            site_force_per_torque=force[working, :, t].T / (torques[t] or 1.0),
            n_pairs=n_pairs[:, t],
            pairs=pairs,
            coast=coast,
        )

    return tuple(sweep_of(t) for t in range(torques.size))


def _first_room(pairing: Pairing, grid: Grid) -> int:
    """Room for the pairs of a state that is enough for nearly all."""
    sides = 1 if pairing.coast is None else 2
    if not pairing.whole_circle:
        return sides * FIRST_ROOM
    cells = grid.zone_half_widths * grid.strips_per_half_width
    return sides * max(FIRST_ROOM, int(ROOM_OF_CELL * cells * pairing.sites.size))


def join_sweeps(parts: Sequence[Sweep], order: NDArray[np.int64]) -> Sweep:
    """One sweep of all positions of several, for the same torque and the same sites.

    Parameters
    ----------
    parts : sequence of Sweep
    order : (P,) array
        Numbers of the positions, as the parts have them one after the other, in their new order.

    Returns
    -------
    Sweep
    """
    coasts = [part.coast for part in parts if part.coast is not None]
    return Sweep(
        torque_Nmm=parts[0].torque_Nmm,
        coast=CoastSweep(**_joined(coasts, order)) if coasts else None,
        **_joined(parts, order),
    )


def _joined(
    parts: Sequence[Sweep] | Sequence[CoastSweep], order: NDArray[np.int64]
) -> dict[str, Any]:
    """What has a row for each position, and the pairs."""
    single = ("torque_Nmm", "pairs", "coast", "unloaded_rad")
    names = [item.name for item in fields(parts[0]) if item.name not in single]
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return {name: values[order] for name, values in joined.items()} | {
        "pairs": join_pairs([part.pairs for part in parts], order)
    }


def _core_arguments(
    bodies: tuple[Body, Body],
    compliances: tuple[BodyCompliance, BodyCompliance],
    pairing: Pairing,
    face_width_mm: float,
) -> list[tuple[NDArray[Any] | float, ...]]:
    """Per body: curve, compliance and shift arrays, in the layout of the flat door."""
    arguments: list[tuple[NDArray[Any] | float, ...]] = []
    for z, (body, compliance) in enumerate(zip(bodies, compliances, strict=True)):
        teeth, angles = pairing.site_teeth[z], pairing.site_angles_rad[z]
        deviations = pairing.site_deviations_mm[z]
        if pairing.coast is not None:
            teeth = np.concatenate([teeth, pairing.coast.site_teeth[z]])
            angles = np.concatenate([angles, pairing.coast.site_angles_rad[z]])
            deviations = np.concatenate([deviations, np.zeros_like(deviations)])
        block = compliance.blocks_of_sites(teeth, pairing.sites.size, body.teeth)
        blocks, _ = compliance.all_blocks()
        smooth = np.asfortranarray(blocks.transpose(1, 2, 0) / face_width_mm)
        shift = compliance.shift_of(teeth)
        curve, corners = body.curve, body.curve.corners.astype(np.intc)
        if body.active_range_mm is not None:
            curve = curve.cut(*body.active_range_mm)
            corners = curve.corners.astype(np.intc)
            corners[[0, -1]] = CUT_END
        arguments.append(
            (
                curve.breaks,
                np.asfortranarray(curve.coefficients.transpose(2, 1, 0)),
                corners,
                angles,
                deviations,
                np.asarray(compliance.mode_range_mm, dtype=float),
                compliance.kernel / face_width_mm,
                np.asarray(compliance.wedge, dtype=float),
                smooth,
                np.asfortranarray(block + 1, dtype=np.intc),
                np.empty(0) if compliance.nodes is None else compliance.nodes,
                len(shift),
                shift.ravel(),
            )
        )
    return arguments


@dataclass(frozen=True)
class _AlongFlanks:
    """What loads along the flanks move, in the layout of the flat door; empty where none rub.

    Attributes
    ----------
    across : two tuples
        Of each body number of loads along its flank, what they move out of the material (flat) and
        the strength of the jump.
    along : tuple
        For body 1, then body 2, number of these loads and what they move along (flat).
    """

    across: tuple[tuple[int, NDArray[np.float64], float], ...]
    along: tuple[NDArray[np.float64] | int, ...]

    @classmethod
    def of(cls, compliances: Sequence[BodyCompliance], face_width_mm: float) -> _AlongFlanks:
        """Arguments; rigid bodies have none, nor do those of which none is asked for."""
        across: list[tuple[int, NDArray[np.float64], float]] = []
        along: list[NDArray[np.float64] | int] = []
        for compliance in compliances or (None, None):
            blocks = None if compliance is None else compliance.all_blocks()[1]
            count, flat = _flat(blocks, face_width_mm)
            jump = compliance.jump / face_width_mm if compliance is not None else 0.0
            across.append((count, flat, jump))
            along += _flat(None if compliance is None else compliance.along, face_width_mm)
        return cls(tuple(across), tuple(along))


def _flat(
    blocks: NDArray[np.float64] | None, face_width_mm: float
) -> tuple[int, NDArray[np.float64]]:
    """Number of loads of blocks of a compliance, and the blocks one after the other."""
    if blocks is None:
        return 0, np.empty(0)
    return blocks.shape[2], blocks.transpose(1, 2, 0).ravel(order="F") / face_width_mm


@dataclass
class _Found:
    """Outputs of the core: numbers with shape (…, P, T), and the packed pairs."""

    numbers: tuple[NDArray[Any], ...]
    first_pair: NDArray[np.int64]
    pair_site: NDArray[np.intc]
    pair_table: NDArray[np.float64]

    @property
    def nbytes(self) -> int:
        """Of all outputs, and of the influence numbers of the state with most pairs."""
        influence = 8 * int(self.numbers[-1].max(initial=0)) ** 2
        table = self.pair_site.nbytes + self.pair_table.nbytes
        return influence + table + held_bytes(self.numbers)

    def pairs_of(self, t: int) -> PackedPairs:
        """Pairs of a torque."""
        first = self.first_pair[:, t]
        count = np.where(first >= 0, self.numbers[-1][:, t], 0)
        return PackedPairs(self.pair_site, self.pair_table, first, count)

    def take_over(self, other: _Found, positions: NDArray[np.int64]) -> None:
        """Fill in positions that another call has found."""
        for mine, theirs in zip(self.numbers, other.numbers, strict=True):
            mine[..., positions, :] = theirs
        self.first_pair[positions] = other.first_pair + len(self.pair_site)
        self.pair_site = np.concatenate([self.pair_site, other.pair_site])
        self.pair_table = np.concatenate([self.pair_table, other.pair_table])


@dataclass
class _CoreCall:
    """The arguments of the core that stay, and how it is called with them."""

    turns: tuple[NDArray[np.float64], NDArray[np.float64]]
    pairing: Pairing
    torques: NDArray[np.float64]
    arguments: list[tuple[NDArray[Any] | float, ...]]
    grid: Grid
    level: Level
    rubbing: FrictionArguments
    along_flanks: _AlongFlanks
    finite_steps: int
    account: Account
    progress: Callable[[int, int], None] | None
    watched: bool

    def all_positions(self, room: int) -> _Found:
        """Solve every position; those whose pairs found no room again, with more."""
        n = len(self.turns[0])
        found = self._call(np.arange(n), room * n, done=0)
        while True:
            short = np.flatnonzero((found.numbers[0] == NO_ROOM).any(axis=1))
            if short.size == 0:
                return found
            room = max(2 * room, 2 * len(found.pair_site) // max(1, n - short.size))
            found.take_over(self._call(short, room * short.size, done=n - short.size), short)

    def _call(self, which: NDArray[np.int64], room: int, *, done: int) -> _Found:

        (curve_1, curve_2) = (argument[:3] for argument in self.arguments)
        (site_1, site_2) = (argument[3:5] for argument in self.arguments)
        (field_1, field_2) = (argument[5:11] for argument in self.arguments)
        (shift_1, shift_2) = (argument[11:] for argument in self.arguments)
        (tangential_1, tangential_2) = self.along_flanks.across
        grid = self.grid
        knobs = (
            grid.strips_per_half_width,
            grid.corner_strips_per_half_width,
            grid.zone_half_widths,
        )
        sides = np.empty(0, dtype=np.intc)
        if self.pairing.coast is not None:
            sides = np.repeat(np.array([1, -1], dtype=np.intc), self.pairing.sites.size)
        control = np.zeros(2, dtype=np.intc)
        room *= len(self.torques)
        site = np.empty(room, dtype=np.intc)
        columns = len(COLUMNS) + (len(FRICTION_COLUMNS) if self.rubbing.present else 0)
        table = np.empty(room * columns)

        def call() -> tuple[Any, ...]:
            found: tuple[Any, ...] = _core.flankload_sweep(
                self.turns[0][which],
                self.turns[1][which],
                self.pairing.center_distance_mm,
                self.torques,
                *curve_1,
                *curve_2,
                site_1[0],
                site_2[0],
                site_1[1],
                site_2[1],
                sides.size,
                sides,
                *field_1,
                *field_2,
                np.array(knobs),
                LEVELS[self.level],
                *self.rubbing.at(which),
                *tangential_1,
                *shift_1,
                *tangential_2,
                *shift_2,
                *self.along_flanks.along,
                self.finite_steps,
                columns,
                control,
                site,
                table,
            )
            return found

        def tell(now: int) -> None:
            if self.progress is not None:
                self.progress(done + now, len(self.turns[0]))

        found = call_and_watch(call, control, tell=tell) if self.watched else call()
        *numbers, first_pair, info = found
        if info < 0:
            raise InputError(f"argument {-info} of flankload_sweep is not valid")
        tell(int(control[1]))
        _count(numbers[0], numbers[4], self.account)
        used = int(np.max(first_pair - 1 + numbers[-1], initial=0, where=first_pair > 0))
        site[:used] -= 1
        return _Found(
            numbers=tuple(numbers),
            first_pair=first_pair - 1,
            pair_site=site[:used],
            pair_table=table.reshape(-1, columns)[:used],
        )


def _count(status: NDArray[Any], counters: NDArray[Any], account: Account) -> None:
    """Count what a call of the core has done, also for states that found no room."""
    begun = ~np.isin(status, (NO_ROOM, STOPPED)) | counters.any(axis=0)
    sums = counters.sum(axis=(1, 2), dtype=np.int64).tolist()
    account.count(states=int(begun.sum()), **dict(zip(CORE_COUNTERS, sums, strict=True)))
