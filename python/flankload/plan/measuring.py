"""The size of each effect of a scene, from coarse sweeps with it and without."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.errors import FlankloadError, SceneError
from flankload.plan.nodes import nodal_size, part_of_wind_up
from flankload.plan.planned import IMPOSSIBLE
from flankload.plan.sizes import Size, States, scaled, size_of
from flankload.plan.variants import is_readable, other_way
from flankload.scene import Cam
from flankload.scene.discretization import Grid, choose_discretization
from flankload.scene.effects import EFFECTS, Effect

if TYPE_CHECKING:
    from flankload.plan.coarse import Coarse
    from flankload.scene import Scene
    from flankload.scene.effects import Switch

#: Cells on which finite forces are looked at: what they change goes with the width of a cell, and
#: what they cost with the square of the number of cells.
WIDE_STRIPS, WIDE_CORNER_STRIPS = 1.0, 3.0
#: Where a state has that many pairs already that it takes long, finite forces are not looked at:
#: with ten strips on a half-width no flank with few pairs has more than this. A spline has a
#: tenth.
DEAR_S, FINITE_STRIPS, FINITE_PART = 3e-3, 10.0, 3e-5
#: Effects that flanks do not know.
OF_DRIVES = ("large_displacement", "land_friction", "land_lift")


@dataclass(frozen=True)
class Measured:
    """What is known of an effect's size.

    Attributes
    ----------
    size : Size or None
    assumed : str or None
        What was taken for it, since the scene does not say it.
    unknown : str or None
        Why there is none.
    """

    size: Size | None = None
    assumed: str | None = None
    unknown: str | None = None


class Sizes:
    """Sizes of the effects of one scene.

    Parameters
    ----------
    scene : Scene
    coarse : Coarse
    """

    def __init__(self, scene: Scene, coarse: Coarse) -> None:
        self._scene, self._coarse = scene, coarse
        self._base = coarse.states(scene)
        (unloaded,) = coarse.states(scene, (0.0,)) if any(coarse.torques_Nm) else self._base
        self._unloaded = unloaded.rotation_rad

    def of(self, effect: Effect, switch: Switch) -> Measured:
        """Size of a row of the table, as the scene switches it."""
        if effect.size_by == "nothing":
            return Measured()
        try:
            variant = other_way(self._scene, effect.name, on=switch.on)
        except SceneError as error:
            return Measured(unknown=f"{IMPOSSIBLE}: {error}")
        if variant is None:
            return Measured()
        try:
            if effect.size_by == "spacing":
                nodal = self._scene if switch.on else variant.scene
                return Measured(nodal_size(nodal, self._coarse, self._base, self._unloaded))
            if effect.name == "finite_influence":
                return Measured(self._of_finite(variant.scene, on=switch.on))
            other, base = self._both(variant.scene, fine=effect.name == "lumped_contact")
        except FlankloadError as error:
            return Measured(unknown=" ".join(str(error).split()))
        size = self.between(base, other) if switch.on else self.between(other, base)
        return Measured(size, variant.assumed)

    def _of_finite(self, scene: Scene, *, on: bool) -> Size:
        """Size of finite forces under the largest torque, from wide cells to those of the run."""
        grid = choose_discretization(self._scene).grid
        if self._coarse.state_seconds(self._scene) > DEAR_S and not on:
            part = FINITE_PART * FINITE_STRIPS / grid.strips_per_half_width
            return part_of_wind_up(part, self._base[-1], self._unloaded, self._coarse)
        wide = Grid(WIDE_STRIPS, WIDE_CORNER_STRIPS, grid.zone_half_widths)
        most = self._coarse.torques_Nm[-1:]
        other, base = (self._coarse.states(one, most, grid=wide) for one in (scene, self._scene))
        size = self.between(base, other) if on else self.between(other, base)
        return scaled(size, WIDE_STRIPS / grid.strips_per_half_width)

    def _both(self, scene: Scene, *, fine: bool) -> tuple[list[States], list[States]]:
        """States of another scene and of this one; on fine cells where cells are what differs."""
        if not fine:
            return self._coarse.states(scene), self._base
        grid = choose_discretization(self._scene).grid
        other = self._coarse.states(scene, grid=grid)
        return other, self._coarse.states(self._scene, grid=grid)

    def against(self, scene: Scene) -> Size:
        """What another scene changes against this one."""
        return self.between(self._coarse.states(scene), self._base)

    def between(self, with_it: list[States], without: list[States]) -> Size:
        """Size from two lists of states."""
        return size_of(
            with_it,
            without,
            base=self._base[-len(with_it) :],
            unloaded_rad=self._unloaded,
            reference_radius_mm=self._coarse.reference_radius_mm,
        )


def rows(scene: Scene) -> tuple[Effect, ...]:
    """Rows of the table that a scene may have, with flanks of teeth or without teeth."""
    teeth = not isinstance(scene.body_2, Cam)
    return tuple(
        effect
        for effect in EFFECTS
        if effect.name not in OF_DRIVES and (teeth or not effect.of_teeth) and is_readable(effect)
    )
