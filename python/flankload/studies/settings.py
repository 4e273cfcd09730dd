"""Settings of many runs of one scene: what no wanted quantity needs is left out."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

from flankload.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

    from flankload.scene import Scene

ESTIMATE = "accuracy.estimate"
#: Keys that are false in many runs, with their words and the part of the name of the quantities
#: that need them.
LEFT_OUT = {
    ESTIMATE: ("error estimates", "estimate"),
    "accuracy.tangents": ("states for the tangent stiffness", "stiffness_tangent"),
}


def settings_for(
    scene: Scene, quantities: Iterable[str], given: Collection[str] = ()
) -> dict[str, bool]:
    """Keys with which many runs of a scene leave out what none of the quantities needs.

    A key that the scene names is kept, and so is one of `given`, the paths that designs change. A
    scene with a tolerance keeps all, since estimates control its discretization.
    """
    found: dict[str, bool] = {}
    if scene.names_tolerance:
        return found
    names = list(quantities)
    for key, (_, part) in LEFT_OUT.items():
        if key in scene.named_discretization_keys or key in given:
            continue
        if any(part in name for name in names):
            continue
        with suppress(SceneError):  # some drives have no tangents
            scene.replace({key: False})
            found[key] = False
    return found


def left_out(settings: Mapping[str, Any]) -> list[str]:
    """A line that names what settings leave out, if anything."""
    words = [f"{LEFT_OUT[key][0]} ({key})" for key in settings if key in LEFT_OUT]
    if not words:
        return []
    return [f"left out, since no quantity needs them: {', '.join(words)}"]


#: Names of estimates of key figures that are the largest of several values.
OF_LARGEST = {"peak_pressure_MPa": "largest_pressure"}


def estimated_error(estimate: Mapping[str, Any] | None, quantity: str) -> float | None:
    """Estimated relative error of a quantity, by the longest name of an estimate that begins it."""
    quantity = OF_LARGEST.get(quantity, quantity)
    known = [
        name
        for name, error in (estimate or {}).items()
        if isinstance(error, float) and quantity.startswith(name)
    ]
    return None if not known else float((estimate or {})[max(known, key=len)])
