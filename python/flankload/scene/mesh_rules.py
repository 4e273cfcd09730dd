"""Rules between the keys of a body from a mesh."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flankload.scene.mesh_tables import MeshBody
from flankload.scene.refusal import refuse, shown


def check_sets(body: MeshBody, given: Mapping[str, Any], key: str) -> None:
    """A sector has two cut faces, a whole body a set for each flank.

    Parameters
    ----------
    body : MeshBody
    given : mapping
        The keys that the scene names.
    key : str
        "body_1" or "body_2".

    Raises
    ------
    SceneError
        If keys of both are named, or one is missing.
    """
    if body.flank_sets is None:
        if body.teeth is None:
            refuse(
                f"{key}.teeth",
                f"an integer >= 3, since there is no {key}.flank_sets to count",
                "nothing",
            )
        if body.cut_sets[0] == body.cut_sets[1]:
            refuse(f"{key}.cut_sets", "two different names", shown(list(body.cut_sets)))
        return
    for name in ("cut_sets", "flank_set"):
        if name in given:
            refuse(
                f"{key}.{name}",
                f"nothing beside {key}.flank_sets: those are of a whole body",
                shown(given[name]),
            )
    for k, name in enumerate(body.flank_sets):
        if name in body.flank_sets[:k]:
            refuse(f"{key}.flank_sets[{k}]", "each set once", shown(name))
    count = len(body.flank_sets)
    if body.teeth is None and count < 3:
        refuse(f"{key}.teeth", "an integer >= 3, since few flanks are named", "nothing")
    if body.teeth is not None and body.teeth < count:
        refuse(f"{key}.teeth", f"at least {count}, as many as in {key}.flank_sets", f"{body.teeth}")
