"""Accounts of the stages of a run, and progress reports."""

from __future__ import annotations

from collections.abc import Callable, MutableMapping
from typing import TYPE_CHECKING, Any

from flankload.cost import Account

if TYPE_CHECKING:
    from collections.abc import Mapping

Progress = Callable[[str, int, int], None]
#: Compliance of each body by the name of its table in the scene, with its cost.
Kept = MutableMapping[str, tuple[Any, Account]]

#: Progress steps for the bodies, the finite elements of all bodies, and each sweep.
BODY_STEPS, COMPLIANCE_STEPS, SWEEP_STEPS = 1, 100, 200
#: Progress steps before the first sweep.
FIXED_STEPS = BODY_STEPS + COMPLIANCE_STEPS
#: Progress steps completed at the beginning of a stage.
STEPS_BEFORE = {
    "plan": 0,
    "bodies": 0,
    "sweep": FIXED_STEPS,
    "estimate": FIXED_STEPS + SWEEP_STEPS,
}
#: Beginning of the names of stages of finite elements.
ELEMENTS = "compliance "


def elements_stage(body: str) -> str:
    """Stage of the finite elements of a body, by the name of its table in the scene."""
    return ELEMENTS + body.replace("_", " ")


def end_of_phase(stage: str, total: int) -> int:
    """Steps completed when the phase of a stage ends: finite elements, or states."""
    return FIXED_STEPS if stage.startswith(ELEMENTS) else total


class StageClock:
    """Accounts by stage, and progress reports.

    Parameters
    ----------
    progress : callable or None
        Called as progress(stage, done, total).
    bodies : tuple of str
        Names of the bodies, in the order of their stages.
    sweeps : int
        Largest number of sweeps over the positions.
    stages : mapping of str to Account
        Completed stages.
    """

    def __init__(
        self,
        progress: Progress | None,
        bodies: tuple[str, ...],
        sweeps: int,
        stages: Mapping[str, Account],
    ) -> None:
        self.stages: dict[str, Account] = dict(stages)
        self._part = COMPLIANCE_STEPS // len(bodies)  # of a body
        self._before = STEPS_BEFORE | {
            elements_stage(body): BODY_STEPS + k * self._part for k, body in enumerate(bodies)
        }
        self._progress = progress
        self._total = FIXED_STEPS + sweeps * SWEEP_STEPS
        self._last = ("", 0)

    def stage(self, name: str) -> Account:
        """Report the beginning of a stage and return its account."""
        self.report(name, self._before.get(name, self._total))
        return self.account(name)

    def account(self, name: str) -> Account:
        """Account of a stage."""
        return self.stages.setdefault(name, Account())

    def report(self, name: str, done: int) -> None:
        """Report progress if it has changed."""
        if self._progress is not None and self._last != (name, done):
            self._last = (name, done)
            self._progress(name, done, self._total)

    def part_progress(self, name: str) -> Callable[[float], None]:
        """Progress of the elements of a body, by the completed part of their work."""
        return lambda part: self.report(name, self._before[name] + int(part * self._part))

    def sweep_progress(
        self, name: str, *, sweep: int = 0, number: int | None = None
    ) -> Callable[[int, int], None]:
        """Progress of the positions in a sweep of a stage, by completed positions and their total.

        `sweep` is the number of earlier sweeps of the stage, `number` the index of a round of
        positions; the number of rounds is unknown, so each counts as half of the remaining one.
        """
        before = self._before[name] + sweep * SWEEP_STEPS
        left, part = (1.0, 1.0) if number is None else (0.5**number, 0.5 ** (number + 1))

        def report(done: int, total: int) -> None:
            steps = SWEEP_STEPS * (1.0 - left + part * done / max(1, total))
            self.report(name, before + int(steps + 1e-9))

        return report

    def move(self, seconds: Mapping[str, float], name: str, step: str) -> None:
        """Move the time of a step from a stage to the stage that has the step's name."""
        if step in seconds:
            for account, sign in ((self.stages[name], -1), (self.stages[step], 1)):
                account.wall_s += sign * seconds[step]
                account.cpu_s += sign * seconds[step]

    def finish(self) -> None:
        """Report the end."""
        self.report("done", self._total)
