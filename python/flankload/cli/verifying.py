"""The command verify: compare flankload with CalculiX at one position."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from flankload.cli.outputs import check_apart, check_folder
from flankload.errors import SceneError

if TYPE_CHECKING:
    from argparse import Namespace

#: Range of elements on the half-width of a contact: fewer do not resolve the pressure, more take
#: hours. Solids do not need the pressure.
FEWEST, FEWEST_SOLID, MOST = 1.0, 0.2, 100.0


def verify(arguments: Namespace) -> None:
    """Print both solutions side by side."""
    if arguments.folder is not None:
        check_folder("-o", arguments.folder, content="the deck")
    limit = arguments.time_limit
    if limit is not None and not (isfinite(limit) and limit > 0):
        raise SceneError(key="--time-limit", expected="seconds > 0", found=f"{limit:g}")
    from flankload.scene import read_scene
    from flankload.scene.effects import is_spatial

    scene = read_scene(arguments.scene)
    if arguments.dimension is not None:
        scene = scene.replace({"effects.dimension": arguments.dimension})
    _check_elements(arguments.elements, solid=is_spatial(scene).on)
    from flankload.studies.verification import files_of_deck
    from flankload.studies.verification import verify as compared

    if arguments.folder is not None:
        check_apart((("-o", path) for path in files_of_deck(arguments.folder)), scene)

    found = compared(
        scene,
        position=arguments.position,
        folder=arguments.folder,
        run=not arguments.no_run,
        time_limit_s=limit,
        elements_per_half_width=arguments.elements,
        large_displacement=arguments.large_displacement,
        program=arguments.program,
    )
    print(found.to_json() if arguments.json else found.table(), end="" if arguments.json else "\n")


def _check_elements(elements: float | None, *, solid: bool) -> None:
    """Refuse a number of elements on the half-width outside its range."""
    fewest = FEWEST_SOLID if solid else FEWEST
    if elements is not None and not fewest <= elements <= MOST:
        raise SceneError(
            key="--elements",
            expected=f"a number from {fewest:g} to {MOST:g}",
            found=f"{elements:g}",
        )
