"""Positions of a report: those of the scene, or adaptive ones where it names none."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.errors import SceneError
from flankload.scene.axial import three_dimensional_key

if TYPE_CHECKING:
    from flankload.scene import Scene


def scene_of_report(scene: Scene) -> Scene:
    """Return the scene with adaptive positions if it leaves the positions to the program.

    A report quotes peak to peak and harmonics, which a few even positions miss.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Scene
        The scene itself if it names a key of [positions] other than `driver`, if its tolerance
        chooses the positions, or if its bodies have no adaptive positions: belts and chains, cams,
        three-dimensional bodies, whose positions cost more, and splines on common axes.
    """
    named = {key for key in scene.named_discretization_keys if key.startswith("positions.")}
    if (
        named - {"positions.driver"}
        or scene.names_tolerance
        or scene.is_drive
        or scene.is_concentric
    ):
        return scene
    three = three_dimensional_key(scene) is not None
    if not scene.body_2.has_teeth or three:
        return scene
    try:
        return scene.replace({"positions.adaptive": True})
    except SceneError:  # an effect that does not go with them
        return scene
