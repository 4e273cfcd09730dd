"""Base class of the screenings: a scene on a coarse discretization, with each effect switched."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from flankload.mechanisms.effect_size import size_of
from flankload.scene.effects import EFFECTS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.base.arrays import Floats
    from flankload.cost import Account
    from flankload.mechanisms.effect_size import Size, States
    from flankload.mechanisms.toggles import Toggle
    from flankload.scene import Scene


class Screening(ABC):
    """A scene on a coarse discretization, with its effects and with each of them the other way.

    Attributes
    ----------
    rows : tuple of str
        Effects that the kind knows, in the order of the table of effects.
    toggles : mapping of str to Toggle
        The scene with each of them the other way; without those that nothing switches, and those
        that are not tried.
    base : list of States
        States of the scene without changes.
    unloaded_rad : (P,) array
        Its rotation without torque.
    """

    rows: tuple[str, ...]
    toggles: Mapping[str, Toggle]
    base: list[States]
    unloaded_rad: Floats
    reference_radius_mm: float

    @abstractmethod
    def states(self, scene: Scene) -> list[States]:
        """States of the scene with other effects."""

    @abstractmethod
    def price(self, scene: Scene) -> Mapping[str, Account]:
        """CPU seconds, bytes and counters of the run of a scene with other effects, by stages."""

    def size(self, name: str, *, on: bool) -> Size | None:
        """Return the size of an effect, which the scene has if `on`; None if no state changes."""
        scene = self.toggles[name].scene
        row = next(row for row in EFFECTS if row.name == name)
        if scene is None or row.size_by == "nothing":
            return None
        return self.between(self.states(scene), on=on)

    def change(self, scene: Scene) -> Size:
        """Return the size of the change from this scene to another one."""
        return self.between(self.states(scene), on=False)

    def between(
        self,
        other: list[States],
        *,
        on: bool,
        mine: list[States] | None = None,
        which: slice = slice(None),
    ) -> Size:
        """Return the size of an effect from the states of the scene with the effect switched.

        The scene has the effect if `on`. `mine` replaces the states of the scene itself.
        """
        base = [part.at(which) for part in self.base[-len(other) :]]
        mine = mine or base
        return size_of(
            *((mine, other) if on else (other, mine)),
            base=base,
            unloaded_rad=self.unloaded_rad[which],
            reference_radius_mm=self.reference_radius_mm,
        )
