"""Likely mistakes in a scene whose bodies cannot be made or paired, for its error line."""

from __future__ import annotations

from dataclasses import replace
from math import cos
from typing import TYPE_CHECKING

from msgspec import structs

from flankload.errors import SceneError
from flankload.scene import Gear, Ring
from flankload.scene.derived import source_of
from flankload.scene.usual import with_questions

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.scene import Scene


def explained(error: SceneError, scene: Scene, paired: Callable[[Scene], object]) -> SceneError:
    """The error of an impossible pair, with the likely mistake if there is one.

    `paired` pairs the bodies of a scene; it raises a SceneError if they are impossible. Errors of
    files are returned unchanged.
    """
    if type(error) is not SceneError:
        return error
    if error.key in scene.derived:
        found = f"{error.found}, by {source_of(scene, error.key)}"
        error = SceneError(key=error.key, expected=error.expected, found=found, file=error.file)
    return with_questions(_transverse_module(error, scene, paired) or error, scene)


def _transverse_module(
    error: SceneError, scene: Scene, paired: Callable[[Scene], object]
) -> SceneError | None:
    """Error about the module of helical gears that mesh if it is the transverse module."""
    one, two = scene.body_1, scene.body_2
    if not (isinstance(one, Gear) and isinstance(two, Gear | Ring) and one.helix_rad):
        return None
    normal_mm = one.module_mm * cos(one.helix_rad)
    changes = {f"body_{z}.module_mm": normal_mm for z in (1, 2)}
    try:
        other = scene.replace(changes)
        rigid_1 = structs.replace(other.body_1, rigid=True)
        rigid_2 = structs.replace(other.body_2, rigid=True)
        paired(replace(other, body_1=rigid_1, body_2=rigid_2))
    except SceneError:
        return None
    return SceneError(
        key="body_1.module_mm",
        expected=f"{normal_mm:.4g}, the normal module, with which the gears mesh",
        found=f"{one.module_mm:g}, the transverse module, which is impossible ({error.key}: "
        f"expected {error.expected}, found {error.found})",
        file=error.file,
    )
