"""The record of an effect: what calls for it, what it goes with, what it adds to a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from flankload.scene.effects.keys import EffectsAsked, has_amount

if TYPE_CHECKING:
    from flankload.scene.scene import Scene

#: How the size of an effect is found before the run: the same pair with another compliance, with
#: other gaps, with other places of contact, with other levers; by a law, from how far apart nodes
#: stand; or it changes no state at all.
SizeBy = Literal["compliance", "gaps", "places", "levers", "spacing", "nothing"]


@dataclass(frozen=True)
class Switch:
    """Whether a scene calls for an effect, and because of what.

    Attributes
    ----------
    on : bool
    because : str
        The key that says so, with its value; or what holds without a key.
    named : bool
        The scene names the key.
    """

    on: bool
    because: str
    named: bool


@dataclass(frozen=True)
class Work:
    """What an effect adds to a run, in units of what is there without it; negative: saves.

    Attributes
    ----------
    factorisations, growth_loads : float
        Of each body with finite elements; load cases that stand for the body's own forces.
    normal_loads, tangential_loads, coast_readings : float
        For each pressure mode of each loaded flank.
    recoveries : float
        For each place in the root fillets of a tooth.
    columns : float
        Influence columns, for each of the contact pairs of a position under a torque.
    solves : float
        Contact problems, for each position under a torque.
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
        Field of `Effects`.
    title : str
    keys : tuple of str
        What calls for it; "body_*" is either body. Absent: those of `on`.
    stages : tuple of str
        Stages of the run that do its work, as `result.cost["stages"]` names them.
    on : mapping of str to object
        Keys of [effects] with which a scene has the effect; None: the key is absent. The first one
        decides. A number is what is assumed where a scene names none: with any but 0 the effect
        is on.
    called_for : callable or None
        Scene to Switch, for an effect that no key of [effects] decides on.
    needs_load : bool
        Without load there is no such effect.
    work : Work
    counters : tuple of str
        Counters of `result.cost` that are 0 or absent without it.
    size_by : SizeBy
    refused_with : mapping of str to str
        Effects beside which the scene's key is refused, and what the refusal says is expected.
    excludes : tuple of str
        Effects that do not go with it, whichever of the two is refused.
    refused_for : mapping of str to str
        The same of kinds of bodies; "{body}" is the table of the body.
    only_for : str or None
        Kind of body 2 that alone knows the effect; a chain or a belt knows no other effects.
    of_teeth : bool
        Only bodies with teeth know it; a cam and its follower do not.
    coarser : bool
        With it less is computed than without: what it changes is an error.
    """

    name: str
    title: str
    keys: tuple[str, ...]
    stages: tuple[str, ...]
    on: Mapping[str, Any] = field(default_factory=dict)
    called_for: Callable[[Scene], Switch] | None = None
    needs_load: bool = False
    work: Work = Work()
    counters: tuple[str, ...] = ()
    size_by: SizeBy = "nothing"
    refused_with: Mapping[str, str] = field(default_factory=dict)
    excludes: tuple[str, ...] = ()
    refused_for: Mapping[str, str] = field(default_factory=dict)
    only_for: str | None = None
    of_teeth: bool = False
    coarser: bool = False

    @property
    def key(self) -> str | None:
        """The key of [effects] that decides."""
        return next(iter(self.on), None)

    @property
    def off(self) -> dict[str, Any]:
        """Keys of [effects] with which a scene has it not: as they are by default, or false."""
        plain = EffectsAsked()
        keys = [key.removeprefix("effects.") for key in self.keys if key.startswith("effects.")]
        defaults = {key: getattr(plain, key) for key in keys}
        return {key: False if value is True else value for key, value in defaults.items()}

    @property
    def numbers(self) -> dict[str, float]:
        """Keys of [effects] with the numbers that are assumed where a scene names none."""
        return {key: value for key, value in self.on.items() if type(value) in (int, float)}

    @property
    def is_quantity(self) -> bool:
        """Whether a number decides, not a level."""
        return self.key in self.numbers

    def is_asked(self, asked: EffectsAsked) -> bool:
        """Whether the key has the value of the effect; of a quantity, any but 0 itself."""
        if self.key is None:
            return False
        value = getattr(asked, self.key)
        return bool(value) if self.is_quantity else value == self.on[self.key]

    def switch(self, scene: Scene) -> Switch:
        """Whether a scene calls for the effect, and because of what."""
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
    """A value as a scene file has it, of a list no more than its length."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, tuple):
        return f"[{len(value)} entries]"
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"
