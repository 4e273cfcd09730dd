"""Data of a plan: effects of a run, their cost and their size."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from flankload.base.card import Card
from flankload.studies.plan.coarse_runs import IMPOSSIBLE
from flankload.studies.plan.text import plan_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.mechanisms.effect_size import Size

#: The seconds of a run are within this factor of those predicted: 0.54 to 1.67 on the examples, in
#: three rounds on a busy machine. The final number of adaptive positions has the same factor.
WITHIN, ADAPTIVE_WITHIN = 2.0, 2.0


@dataclass(frozen=True)
class PlannedEffect:
    """A row of the table of effects, for one scene.

    Attributes
    ----------
    name, title : str
        As in the table of effects.
    on : bool
        Whether the run has the effect.
    because : str
        The key that sets the effect, with its value; or the rule that applies without a key.
    named : bool
        Whether the scene names that key.
    stages : tuple of str
        Stages of the run that do the work of the effect.
    extra_s, extra_bytes : float, int; or None
        CPU seconds and memory that it adds to the run, or would add if it is off. None if that was
        not tried.
    size : Size or None
        Change by the effect: results with it minus results without it. None if it changes no state,
        or if its size is unknown.
    assumed : str or None
        For an effect that is off: value assumed for the size, since the scene does not set it.
    unknown : str or None
        Reason for a missing size.
    matters : bool
        Whether it is significant: it changes more than a quarter of the tolerance.
    remark : str or None
        A sentence for a significant effect that the run omits, or that is an error of the run.
    """

    name: str
    title: str
    on: bool
    because: str
    named: bool
    stages: tuple[str, ...]
    extra_s: float | None
    extra_bytes: int | None
    size: Size | None = None
    assumed: str | None = None
    unknown: str | None = None
    matters: bool = False
    remark: str | None = None

    @property
    def possible(self) -> bool:
        """Whether the scene can have the effect."""
        return self.unknown is None or not self.unknown.startswith(IMPOSSIBLE)


@dataclass(frozen=True)
class Chosen:
    """An effect decided by `effects.choose = "auto"`.

    Attributes
    ----------
    effect : str
        Row of the table of effects.
    key : str
        Dotted path of the key that sets it.
    value : bool, str or None
        Required value; None: a value that is kept, or removed if `on` is false.
    on : bool
        Whether the run has the effect.
    why : str
        Its size compared with the threshold.
    """

    effect: str
    key: str
    value: bool | str | None
    on: bool
    why: str

    def __str__(self) -> str:
        if self.value is not None:
            return f"{self.key} = {json.dumps(self.value)} ({self.why})"
        return f"{self.key} {'kept' if self.on else 'omitted'} ({self.why})"


@dataclass(frozen=True, repr=False)
class Plan(Card):
    """Plan of a run of a scene.

    Attributes
    ----------
    name : str
        Name of the scene.
    tolerance : float
    effects : tuple of PlannedEffect
        In the order of the table of effects.
    predicted : mapping
        "stages": "cpu_s" (for a process that has loaded its packages), "bytes", "workspace_bytes"
        and "counters" by the names of `result.cost["stages"]`; "counters": the sums over all
        stages, in which factorisations, solutions and unit loads are exact.
    choice : tuple of Chosen
        Choices of `effects.choose = "auto"`.
    left_out : Size or None
        Combined size of all changes by the choice.
    picked : mapping or None
        Initial discretization for a tolerance that the scene names: "keys" of the discretization by
        table, expected "errors", and "dominant_source" of the largest. The cost is that of this
        run; a finer one may follow.
    within : float
        Factor of uncertainty of the seconds.
    cpu_s : float
        CPU seconds of the plan itself.
    """

    name: str
    tolerance: float
    effects: tuple[PlannedEffect, ...]
    predicted: Mapping[str, Any]
    choice: tuple[Chosen, ...] = ()
    left_out: Size | None = None
    picked: Mapping[str, Any] | None = None
    within: float = WITHIN
    cpu_s: float = 0.0

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on omitted effects that are probably significant, and on significant errors."""
        return tuple(effect.remark for effect in self.effects if effect.remark is not None)

    @property
    def seconds(self) -> float:
        """CPU seconds of the run."""
        return sum(stage["cpu_s"] for stage in self.predicted["stages"].values())

    def effect(self, name: str) -> PlannedEffect:
        """The row of an effect."""
        return next(effect for effect in self.effects if effect.name == name)

    def as_dict(self) -> dict[str, Any]:
        """The plan as plain data."""
        return {**asdict(self), "seconds": self.seconds, "remarks": list(self.remarks)}

    def to_json(self) -> str:
        """The plan as JSON."""
        return json.dumps(self.as_dict(), indent=2, ensure_ascii=False, allow_nan=False)

    def __str__(self) -> str:
        return plan_text(self)
