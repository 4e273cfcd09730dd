"""The command plan: print the effects of a run, their cost and their size."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from argparse import Namespace


def plan(arguments: Namespace) -> None:
    """Print the plan of a scene."""
    from flankload.scene import read_scene

    scene = read_scene(arguments.scene)
    from flankload.studies.plan import plan as plan_of

    found = plan_of(scene, levels=arguments.levels, dimension=arguments.dimension)
    print(found.to_json() if arguments.json else found)
