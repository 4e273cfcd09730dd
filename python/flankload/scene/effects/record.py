"""The record of an effect: its keys, the effects it excludes, the work it adds to a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from flankload.scene.effects.keys import EffectsAsked, has_amount

if TYPE_CHECKING:
    from flankload.scene.scene import Scene

#: Change of the pair that gives the size of an effect: compliance, gaps, places of contact or lever
#: arms; proportional to the node spacing or to the cell width; "nothing": no contact state changes.
SizeBy = Literal["compliance", "gaps", "places", "levers", "spacing", "cells", "nothing"]


@dataclass(frozen=True)
class Switch:
    """Whether a scene requests an effect, and the reason.

    Attributes
    ----------
    on : bool
    because : str
        The deciding key with its value, or the condition that decides without a key.
    named : bool
        The scene sets the key.
    """

    on: bool
    because: str
    named: bool


@dataclass(frozen=True)
class Work:
    """Work that an effect adds to a run, relative to the run without it; negative if it saves work.

    Attributes
    ----------
    factorisations, growth_loads : float
        Per body with finite elements; growth loads are load cases of expansion.
    normal_loads, tangential_loads, coast_readings : float
        Per pressure mode of each loaded flank.
    recoveries : float
        Per place in the root fillets of a tooth.
    columns : float
        Influence columns, per contact pair of a position under a torque.
    solves : float
        Contact problems, per position under a torque.
    """

    factorisations: float = 0
    growth_loads: float = 0
    normal_loads: float = 0
    tangential_loads: float = 0
    coast_readings: float = 0
    recoveries: float = 0
    columns: float = 0
    solves: float = 0


@dataclass(frozen=True)
class Effect:
    """The record of an effect.

    Attributes
    ----------
    name : str
        Name of the field of `Effects`.
    title : str
    stages : tuple of str
        Stages of the run that do its work, with the names of `result.cost["stages"]`.
    keys : tuple of str
        Keys that switch the effect on; "body_*": either body. Default: the keys of `on`.
    on : mapping of str to object
        Keys of [effects] and the values with which the effect is on; None: the key is absent. The
        first key decides. A number is the value assumed if the scene sets none; the effect is on
        with any number except 0.
    called_for : callable or None
        Function from Scene to Switch, for an effect without a key in [effects].
    needs_load : bool
        The effect needs a load.
    work : Work
    counters : tuple of str
        Counters of `result.cost` that are zero or absent without the effect.
    size_by : SizeBy
    refused_with : mapping of str to str
        Excluded effects, each with the text "expected" of the error line.
    refused_for : mapping of str to str
        Excluded kinds of bodies, each with the text "expected"; "{body}" is the table of the body.
    only_for : str or None
        The only kind of body 2 with this effect; chains and belts have no other effects. "stage":
        scenes with a table [stage].
    of_teeth : bool
        Only bodies with teeth have the effect, not a cam and its follower.
    coarser : bool
        The effect simplifies the model, so that the change of the result is an error.
    """

    name: str
    title: str
    stages: tuple[str, ...]
    keys: tuple[str, ...] = ()
    on: Mapping[str, Any] = field(default_factory=dict)
    called_for: Callable[[Scene], Switch] | None = None
    needs_load: bool = False
    work: Work = Work()
    counters: tuple[str, ...] = ()
    size_by: SizeBy = "nothing"
    refused_with: Mapping[str, str] = field(default_factory=dict)
    refused_for: Mapping[str, str] = field(default_factory=dict)
    only_for: str | None = None
    of_teeth: bool = False
    coarser: bool = False

    def __post_init__(self) -> None:
        """Complete the keys."""
        switches = tuple(f"effects.{key}" for key, value in self.on.items() if value is not None)
        object.__setattr__(self, "keys", self.keys or switches)

    @cached_property
    def key(self) -> str | None:
        """The deciding key of [effects]."""
        return next(iter(self.on), None)

    @property
    def off(self) -> dict[str, Any]:
        """Keys of [effects] with the values that switch the effect off: the defaults, or false."""
        plain = EffectsAsked()
        keys = [key.removeprefix("effects.") for key in self.keys if key.startswith("effects.")]
        defaults = {key: getattr(plain, key) for key in keys}
        return {key: False if value is True else value for key, value in defaults.items()}

    @cached_property
    def numbers(self) -> dict[str, float]:
        """Keys of [effects] with the numbers that are assumed if a scene sets none."""
        return {key: value for key, value in self.on.items() if type(value) in (int, float)}

    @cached_property
    def is_quantity(self) -> bool:
        """Whether the deciding key is a number."""
        return self.key in self.numbers

    def is_asked(self, asked: EffectsAsked) -> bool:
        """Whether the key has the value of the effect; for a quantity, any number except 0."""
        if self.key is None:
            return False
        value = getattr(asked, self.key)
        return bool(value) if self.is_quantity else value == self.on[self.key]

    def switch(self, scene: Scene) -> Switch:
        """Whether a scene requests the effect, and the reason."""
        switch = self.called_for(scene) if self.called_for else self._switch_by_key(scene)
        if switch.on and self.needs_load and not scene.is_loaded:
            return Switch(False, "load.torque_Nm = 0", True)
        return switch

    def _switch_by_key(self, scene: Scene) -> Switch:
        key = self.key
        assert key is not None
        value = getattr(scene.effects, key)
        named = key in scene.named_effects
        on = self.is_asked(scene.effects)
        if self.is_quantity:
            named = value is not None and (named or on)
            on = on and has_amount(value)
        return Switch(on, f"effects.{key} " + (f"= {as_key(value)}" if named else "absent"), named)


def as_key(value: Any) -> str:
    """A value as in a scene file; of a list only its length."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, tuple):
        return f"[{len(value)} entries]"
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"
