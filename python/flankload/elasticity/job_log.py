"""Counters, CPU seconds and error estimates of one finite-element job."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter, process_time
from typing import TYPE_CHECKING

from flankload.cost import Account

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flankload.base.arrays import Floats

    Errors = tuple[Floats, float]


@dataclass(frozen=True, eq=False)
class JobCost:
    """Size and cost of a finite-element job.

    Attributes
    ----------
    asymmetry : float
        Largest relative difference between a response and its transpose: the rounding error.
    degrees_of_freedom : int
        Number of unknowns.
    counters : mapping of str to int
        Work by the names of `cost.COUNTERS`, without zeros.
    workspace_bytes : int
        Temporary memory of stiffness matrix, factors and solutions.
    seconds : dict of str to float
        CPU seconds of each step; "wall" is the elapsed time of the whole job.
    """

    asymmetry: float = 0.0
    degrees_of_freedom: int = 0
    counters: Mapping[str, int] = field(default_factory=dict)
    workspace_bytes: int = 0
    seconds: dict[str, float] = field(default_factory=dict)


class JobLog:
    """Record of a finite-element job.

    Parameters
    ----------
    account : Account, optional
        Counters and workspace; by default a new one.
    estimate : callable, optional
        Estimated errors of the displacements (2N, p) of all nodes under the unit loads of a flank:
        of the compliance (p, p), and a relative one of the root stress.

    Attributes
    ----------
    errors : list of ((p, p) array, float)
        Estimated errors, one per solution.
    """

    def __init__(
        self, account: Account | None = None, estimate: Callable[[Floats], Errors] | None = None
    ) -> None:
        self.account = Account() if account is None else account
        self.errors: list[Errors] = []
        self._estimate = estimate
        self._seconds: dict[str, float] = {}
        self._wall, self._clock = perf_counter(), process_time()

    def end_step(self, name: str) -> None:
        """Add the CPU time since the last step to the step that ends."""
        now = process_time()
        self._seconds[name] = self._seconds.get(name, 0.0) + now - self._clock
        self._clock = now

    def count_loads(self, columns: int, *, tangential: int) -> None:
        """Count the load cases of flanks and rim, of which some are tangential."""
        self.account.count(unit_loads_normal=columns - tangential, unit_loads_tangential=tangential)

    @property
    def estimates(self) -> bool:
        """Whether errors are estimated."""
        return self._estimate is not None

    def solution(self, moved: Floats) -> None:
        """Record the displacements (2N, p) under the unit loads of a flank."""
        if self._estimate is None:
            return
        self.end_step("solution")
        self.errors.append(self._estimate(moved))
        self.end_step("estimate")

    def cost(self, asymmetry: float, degrees_of_freedom: int) -> JobCost:
        """Size and cost of the job so far."""
        return JobCost(
            asymmetry,
            degrees_of_freedom,
            self.account.counters,
            self.account.workspace_bytes,
            self.seconds(),
        )

    def seconds(self) -> dict[str, float]:
        """CPU seconds of all steps, and the elapsed time ("wall")."""
        return {**self._seconds, "wall": perf_counter() - self._wall}
