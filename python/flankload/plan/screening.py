"""What a plan asks of a kind of drive, and which kind a scene has."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Protocol, cast

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.cost import Account
    from flankload.plan.effect_size import Size
    from flankload.plan.toggles import Toggle
    from flankload.scene import Scene

#: Module and class by the kind of body 2; of all other kinds the last.
KINDS = {
    "belt": ("flankload.plan.belt", "BeltScreening"),
    "chain": ("flankload.plan.chain", "ChainScreening"),
    "": ("flankload.plan.flank_pair", "FlankPairScreening"),
}


class Screening(Protocol):
    """A scene on a coarse discretization, with its effects and with each of them the other way.

    Attributes
    ----------
    rows : tuple of str
        Effects that the kind knows, in the order of the table of effects.
    toggles : mapping of str to Toggle
        The scene with each of them the other way; without those that nothing switches, and those
        that are not tried.
    """

    rows: tuple[str, ...]
    toggles: Mapping[str, Toggle]

    def size(self, name: str, *, on: bool) -> Size | None:
        """What a row changes that the scene has, or has not; None where it changes no state."""

    def change(self, scene: Scene) -> Size:
        """What another scene of the same bodies changes against this one."""

    def price(self, scene: Scene) -> Mapping[str, Account]:
        """CPU seconds, bytes and counters of the run of a scene with other effects, by stages."""


def screening_of(scene: Scene, *, levels: bool = False) -> Screening:
    """Screen a scene: build its bodies, solve its states on a coarse discretization.

    Parameters
    ----------
    scene : Scene
    levels : bool
        As of `plan`.

    Returns
    -------
    Screening

    Raises
    ------
    FlankloadError
        If the scene is impossible, breaks a premise or has no state.
    """
    module, name = KINDS.get(scene.body_2.kind, KINDS[""])
    return cast("Screening", getattr(import_module(module), name)(scene, levels=levels))
