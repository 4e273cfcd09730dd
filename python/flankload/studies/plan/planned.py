"""What a run will simulate, what that costs and what it changes: the data of a plan."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from flankload.studies.plan.text import plan_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.mechanisms.effect_size import Size

#: How the reason begins why an effect has no size, where a scene cannot have it.
IMPOSSIBLE = "not with this scene"
#: The seconds of a run are within this factor of those predicted: 0.54 to 1.67 on the examples, in
#: three rounds on a busy machine. How many positions adaptive ones become is known to as much.
WITHIN, ADAPTIVE_WITHIN = 2.0, 2.0


@dataclass(frozen=True)
class PlannedEffect:
    """A row of the table of effects, for one scene.

    Attributes
    ----------
    name, title : str
        As in the table of effects.
    on : bool
        The run will have it.
    because : str
        The key that says so, with its value; or what holds without a key.
    named : bool
        The scene names that key.
    stages : tuple of str
        Stages of the run that do its work.
    extra_s, extra_bytes : float, int; or None
        CPU seconds and memory that it adds to the run; of an effect that is off: would add. None
        where that was not tried.
    size : Size or None
        What it changes: with it less without it. None where it changes no state, or where that
        cannot be told.
    assumed : str or None
        Of an effect that is off: what was taken for the size, since the scene does not say it.
    unknown : str or None
        Why there is no size.
    matters : bool
        It is significant: it changes more than a quarter of the tolerance.
    remark : str or None
        Where that is left out of the run, or is an error of it: a sentence.
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
        """Whether the scene can have it."""
        return self.unknown is None or not self.unknown.startswith(IMPOSSIBLE)


@dataclass(frozen=True)
class Chosen:
    """An effect that `effects.choose = "auto"` has decided on.

    Attributes
    ----------
    effect : str
        Row of the table of effects.
    key : str
        Dotted path of the key that says so.
    value : bool, str or None
        What it has to be; None: a number that stays, or is taken out where `on` is false.
    on : bool
        The run has the effect.
    why : str
        Its size against what matters.
    """

    effect: str
    key: str
    value: bool | str | None
    on: bool
    why: str

    def __str__(self) -> str:
        if self.value is not None:
            return f"{self.key} = {json.dumps(self.value)} ({self.why})"
        return f"{self.key} {'stays' if self.on else 'left out'} ({self.why})"


@dataclass(frozen=True)
class Plan:
    """What a run of a scene will simulate.

    Attributes
    ----------
    name : str
        Of the scene.
    tolerance : float
    effects : tuple of PlannedEffect
        In the order of the table of effects.
    predicted : mapping
        "stages": "cpu_s" (of a process that has loaded its packages), "bytes", "workspace_bytes"
        and "counters" by the names of `result.cost["stages"]`; "counters": the sums over all
        stages, of which factorisations, solutions with them and unit loads are exact.
    choice : tuple of Chosen
        What `effects.choose = "auto"` has decided on.
    left_out : Size or None
        What all that is changed by the choice together makes.
    picked : mapping or None
        What a tolerance that the scene names begins with: "keys" of the knobs by table, "errors"
        that are expected, "dominant_source" of the largest. The price is that of this run; a finer
        one may follow it.
    within : float
        Factor to which the seconds are known.
    cpu_s : float
        What the plan itself took.
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
        """Sentences on what is left out and likely to matter, and on errors that are."""
        return tuple(effect.remark for effect in self.effects if effect.remark is not None)

    @property
    def seconds(self) -> float:
        """CPU seconds of the run."""
        return sum(stage["cpu_s"] for stage in self.predicted["stages"].values())

    def effect(self, name: str) -> PlannedEffect:
        """A row by its name."""
        return next(effect for effect in self.effects if effect.name == name)

    def as_dict(self) -> dict[str, Any]:
        """All of it as plain data."""
        return {**asdict(self), "seconds": self.seconds, "remarks": list(self.remarks)}

    def to_json(self) -> str:
        """All of it as JSON."""
        return json.dumps(self.as_dict(), indent=2, ensure_ascii=False, allow_nan=False)

    def __str__(self) -> str:
        return plan_text(self)
