"""Selection of the package that solves a scene; packages are imported on demand."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.analysis.stage_modes import StageModes
    from flankload.mechanisms.protocol import Mechanism
    from flankload.scene import Scene

#: Package by the kind of body 2; all other bodies touch on their flanks.
REGISTRY = {"belt": "belt", "chain": "chain"}
OTHERS = "flank_pair"
#: Packages of scenes with one of these tables, which have their names.
TABLES = ("stage", "train")


def mechanism_of(scene: Scene) -> Mechanism[Any, Any, Any]:
    """Kind of drive of a scene."""
    package = REGISTRY.get(scene.body_2.kind, OTHERS)
    package = next((name for name in TABLES if getattr(scene, name) is not None), package)
    found: Mechanism[Any, Any, Any]
    found = import_module(f"flankload.mechanisms.{package}.mechanism").MECHANISM
    return found


def require_flanks(scene: Scene) -> None:
    """Raise a SceneError for drives whose bodies have no flanks with finite elements."""
    reason = mechanism_of(scene).no_flanks_reason
    if reason is not None:
        raise SceneError(
            file=scene.file,
            key="body_2.kind",
            expected="bodies with flanks and elements for that",
            found=reason,
        )


def modes_of(scene: Scene) -> tuple[StageModes, ...]:
    """Natural modes of a stage, one entry per torque; a SceneError for other kinds of drive."""
    find = mechanism_of(scene).modes
    if find is None:
        expected = "a table, for natural modes"
        raise SceneError(file=scene.file, key="stage", expected=expected, found="nothing")
    return find(scene)
