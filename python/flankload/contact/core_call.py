"""Interruptible calls of the sweep of the core, with progress."""

from __future__ import annotations

from dataclasses import dataclass, replace
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from flankload import _core
from flankload.contact.pair_table import PackedPairs, columns_of
from flankload.contact.status import Status, checked
from flankload.cost import Account, held_bytes

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flankload.contact.flank_contact import FlankContact

    Outcome = TypeVar("Outcome")

#: Number of lumped contacts, or of cells, summed over the states, that take less than 0.02 s.
SHORT_CALL = 1000
#: Seconds between two readings of the core's progress.
TICK_S = 0.05
#: Counters of the core for every state, in its order.
CORE_COUNTERS = (
    "pivots",
    "influence_columns",
    "contact_passes",
    "refactorisations",
    "influence_columns_tangential",
    "lumped_solutions",
    "finite_solutions",
)


@dataclass
class CoreOutput:
    """Outputs of the core for P positions and T torques; S sites.

    Arrays are (P, T), with another axis in front for certificate (3), counters (7) and sites (S).
    `first_pair` is -1 if no pair is stored; `pair_site` (N,) and `pair_table` (N, columns) contain
    the pairs of all states.
    """

    status: NDArray[np.int64]
    rotation_rad: NDArray[np.float64]
    tangent_rad_per_Nmm: NDArray[np.float64]
    certificate: NDArray[np.float64]
    counters: NDArray[np.int64]
    site_force_N: NDArray[np.float64]
    site_peak_N_per_mm: NDArray[np.float64]
    site_corner: NDArray[np.int64]
    n_pairs: NDArray[np.int64]
    first_pair: NDArray[np.int64]
    pair_site: NDArray[np.intc]
    pair_table: NDArray[np.float64]

    @property
    def states(self) -> dict[str, NDArray[Any]]:
        """Outputs for each position, by name."""
        pairs = ("first_pair", "pair_site", "pair_table")
        return {name: values for name, values in vars(self).items() if name not in pairs}

    @property
    def nbytes(self) -> int:
        """Bytes of all outputs, and of the influence coefficients of the state with most pairs."""
        influence = 8 * int(self.n_pairs.max(initial=0)) ** 2
        table = self.pair_site.nbytes + self.pair_table.nbytes
        return influence + table + held_bytes(tuple(self.states.values()))

    def pairs_of(self, t: int) -> PackedPairs:
        """Pairs of a torque."""
        first = self.first_pair[:, t]
        count = np.where(first >= 0, self.n_pairs[:, t], 0)
        return PackedPairs(self.pair_site, self.pair_table, first, count)

    def replace_positions(self, other: CoreOutput, positions: NDArray[np.int64]) -> None:
        """Replace positions by those of another call."""
        for name, values in self.states.items():
            values[..., positions, :] = other.states[name]
        self.first_pair[positions] = other.first_pair + len(self.pair_site)
        self.pair_site = np.concatenate([self.pair_site, other.pair_site])
        self.pair_table = np.concatenate([self.pair_table, other.pair_table])


@dataclass(frozen=True)
class KnownContacts:
    """Pairs in contact in a sweep, for a similar one.

    `touches` (N,): 1 for a pair in contact, 0 otherwise; `count`, `first` (P, T): number of pairs
    of each state, 0 if they are not used, -1 for those of the torque before, whose state is
    continued; index of the first one.
    """

    touches: NDArray[np.intc]
    count: NDArray[np.int64]
    first: NDArray[np.int64]

    @classmethod
    def none(cls, n_positions: int, n_torques: int) -> KnownContacts:
        """No known pairs."""
        nothing = np.zeros((n_positions, n_torques), dtype=np.int64)
        return cls(np.zeros(0, dtype=np.intc), nothing, nothing)

    @classmethod
    def of_torque_before(cls, n_positions: int, n_torques: int) -> KnownContacts:
        """For torques, each followed by one under which its states are continued."""
        count = np.tile([0, -1], (n_positions, n_torques))
        return cls(np.zeros(0, dtype=np.intc), count, np.zeros_like(count))

    def for_torques(self, n_torques: int) -> KnownContacts:
        """With unknown pairs of further torques."""
        more = ((0, 0), (0, n_torques - self.count.shape[1]))
        return KnownContacts(self.touches, np.pad(self.count, more), np.pad(self.first, more))

    def at(self, which: NDArray[np.int64]) -> tuple[NDArray[Any], ...]:
        """Arguments of the core for some positions."""
        tables = (self.count[which], self.first[which] + 1)
        return self.touches, *(np.asfortranarray(table, dtype=np.intc) for table in tables)


@dataclass(frozen=True)
class CoreCall:
    """The constant arguments of the core, and its call.

    `n_sites`: sites of the core, several for each pair of flanks; `motion` (4, P): angles of both
    bodies, rad, and their speeds, rad per rad of the position; `own`: torques whose states are
    counted, those of the others are beside them.
    """

    contact: FlankContact
    n_sites: int
    motion: NDArray[np.float64]
    torques_Nmm: NDArray[np.float64]
    account: Account
    progress: Callable[[int, int], None] | None
    watched: bool
    known: KnownContacts | None
    own: slice

    def holds(self, position: int, torques_Nmm: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether a position has a state under each of other torques (T,)."""
        alone = replace(
            self,
            motion=self.motion[:, position : position + 1],
            torques_Nmm=torques_Nmm,
            progress=None,
            known=None,
            own=slice(None),
        )
        return np.asarray(alone.all_positions(0).status[0] >= 0)

    def all_positions(self, capacity: int) -> CoreOutput:
        """Solve every position; repeat those whose pairs exceeded the allocated number.

        `capacity` is the number of allocated pairs of a state in the first call; 0: none are
        stored.
        """
        n = self.motion.shape[1]
        found = self._call(np.arange(n), capacity * n, done=0)
        while True:
            short = np.flatnonzero((found.status == Status.NO_ROOM).any(axis=1))
            if short.size == 0:
                return found
            capacity = max(2 * capacity, 2 * len(found.pair_site) // max(1, n - short.size))
            found.replace_positions(
                self._call(short, capacity * short.size, done=n - short.size), short
            )

    def _call(self, which: NDArray[np.int64], capacity: int, *, done: int) -> CoreOutput:
        """Solve some positions; `done`: number of positions that are already solved."""
        control = np.zeros(2, dtype=np.intc)
        capacity *= len(self.torques_Nmm)
        site = np.empty(capacity, dtype=np.intc)
        n_columns = len(columns_of(friction=self.contact.mesh.friction is not None))
        table = np.empty(capacity * n_columns)

        known = self.known or KnownContacts.none(self.motion.shape[1], len(self.torques_Nmm))

        def call() -> tuple[Any, ...]:
            found: tuple[Any, ...] = _core.flankload_sweep_mesh(
                self.n_sites,
                np.asfortranarray(self.motion[:, which]),
                self.torques_Nmm,
                *self.contact.records,
                n_columns,
                control,
                site,
                table,
                *known.at(which),
            )
            checked(found[-1])
            return found

        def report(now: int) -> None:
            if self.progress is not None:
                self.progress(done + now, self.motion.shape[1])

        watched = self.watched and not self._is_short(which.size)
        outputs = call_and_watch(call, control, report=report) if watched else call()
        found = self._found(outputs, site, table.reshape(-1, n_columns))
        _count(found, self.account, self.own)
        report(int(control[1]))
        return found

    def _is_short(self, n_positions: int) -> bool:
        """Whether the call ends before the first reading of its progress."""
        contact, each = self.contact, 1.0
        if contact.level != "lumped":  # forces of finite size are iterated
            each = 2.0 * contact.grid.strips_per_half_width * (1 + contact.finite_steps)
        return n_positions * self.torques_Nmm.size * self.n_sites * each <= SHORT_CALL

    def _found(
        self, outputs: tuple[Any, ...], site: NDArray[np.intc], table: NDArray[np.float64]
    ) -> CoreOutput:
        """Outputs by name, with pairs numbered from 0."""
        status, rotation, tangent, certificate, counters, force, peak, corner, _ = outputs
        work = np.asfortranarray(counters[: len(CORE_COUNTERS)])
        n_pairs, first_pair = (np.asfortranarray(part) for part in counters[len(CORE_COUNTERS) :])
        used = int(np.max(first_pair - 1 + n_pairs, initial=0, where=first_pair > 0))
        site[:used] -= 1
        states = (status, rotation, tangent, certificate, work, force, peak, corner, n_pairs)
        return CoreOutput(*states, first_pair - 1, site[:used], table[:used])


def _count(found: CoreOutput, account: Account, own: slice) -> None:
    """Count the work of a call of the core, including states that exceeded the allocation."""
    undone = (found.status == Status.NO_ROOM) | (found.status == Status.STOPPED)
    begun = (~undone | found.counters.any(axis=0))[:, own]
    sums = found.counters.sum(axis=(1, 2), dtype=np.int64).tolist()
    account.count(states=int(begun.sum()), **dict(zip(CORE_COUNTERS, sums, strict=True)))


def call_and_watch(
    call: Callable[[], Outcome],
    control: NDArray[np.intc],
    *,
    report: Callable[[int], None] | None = None,
) -> Outcome:
    """Run a call of the core in a separate thread without the GIL; returns its value.

    An exception during the waiting (Ctrl-C, or from `report`) stops the core and is raised again
    once the core has returned. `control`, two C ints, is shared with the core: [0] requests it to
    stop, [1] is the completed work, with which `report` is called several times a second.
    """
    outcome: list[Outcome] = []
    failure: list[BaseException] = []
    ended = Event()

    def work() -> None:
        try:
            outcome.append(call())
        except BaseException as error:
            failure.append(error)
        finally:
            ended.set()

    Thread(target=work, name="flankload core").start()
    try:
        while not ended.wait(TICK_S):
            if report is not None:
                report(int(control[1]))
    except BaseException:
        control[0] = 1
        ended.wait()
        raise
    if failure:
        raise failure[0]
    return outcome[0]
