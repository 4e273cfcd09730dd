"""Comparison of one position by flankload and by nonlinear finite elements."""

from __future__ import annotations

import shutil
import tempfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.arguments import require, require_path
from flankload.base.files import write_atomically
from flankload.mechanisms import run_once
from flankload.scene import Scene, SceneLike, scene_of
from flankload.scene.effects import is_spatial
from flankload.scene.refusal import refuse
from flankload.studies.plan import choose_effects
from flankload.studies.tolerance import first_scene
from flankload.studies.verification.calculix import JOB, Answer, find_program, run_deck
from flankload.studies.verification.compared import Verification, comparison_of
from flankload.studies.verification.deck import Deck, deck_text
from flankload.studies.verification.deck_model import Model, check_bodies, model_of
from flankload.studies.verification.size import (
    ITERATIONS,
    MOST_UNKNOWNS,
    coarse_result,
    least_seconds,
    require_size,
    rounded,
)
from flankload.studies.verification.solid_model import solid_model_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.result import Result

    Progress = Callable[[str, int, int, float | None], None]

#: Elements on the half-width of a contact by default, in the plane and of solids.
ELEMENTS, SOLID_ELEMENTS = 6.0, 1.0


def verify(
    scene: SceneLike,
    *,
    position: int = 0,
    folder: str | Path | None = None,
    run: bool = True,
    time_limit_s: float | None = None,
    elements_per_half_width: float | None = None,
    large_displacement: bool = False,
    program: str = "ccx",
    most_unknowns: int = MOST_UNKNOWNS,
    progress: Progress | None = None,
) -> Verification:
    """Solve one position of a scene by nonlinear finite elements as well.

    CalculiX gets both whole bodies at that position, fine at the contacts: plane triangles, or
    layers of wedges in three dimensions. Rotation, forces and pressures are its own output;
    flankload's solution determines only the element size and the flanks with a contact pair.

    Parameters
    ----------
    scene : Scene, path or mapping
        As for `solve`; the largest of a list of torques is used.
    position : int
        Index into the scene's positions.
    folder : path, optional
        Folder for deck.inp and the files of CalculiX, which are kept; by default a temporary
        folder, which is kept only if CalculiX was not run or found no solution.
    run : bool
        Whether CalculiX solves the deck.
    time_limit_s : float, optional
        Wall-clock limit of CalculiX.
    elements_per_half_width : float
        Elements on the half-width of a Hertz contact; 6 in the plane and 1 of solids by default.
        All other elements of solids follow in proportion.
    large_displacement : bool
        Whether CalculiX includes the deformation of the geometry.
    program : str
        Name or path of CalculiX.
    most_unknowns : int
        A larger deck is refused before the scene is solved: its size follows from a coarse run.
    progress : callable, optional
        Called as progress(stage, done, total, left_s); the last one are the least seconds left of
        all, or None. For solids these first follow from the time of a small part of the deck.

    Returns
    -------
    Verification

    Raises
    ------
    SceneError
        If there is no such position, a body has no elements, there is no torque, or the deck is too
        large; the message has its size and a number of elements that is not.
    OtherProgramError
        If CalculiX is missing or finds no solution; `folder` of the exception keeps its files.
    """
    require("position", position, "an integer", fits=isinstance(position, int | np.integer))
    require_path("folder", folder)
    require("most_unknowns", most_unknowns, "an integer > 0", fits=most_unknowns > 0)
    progress = progress or _silent
    scene = _checked(scene_of(scene))
    solid = is_spatial(scene).on
    kind, usual = ((model_of, ELEMENTS), (solid_model_of, SOLID_ELEMENTS))[solid]
    deck_of = partial(kind, large_displacement=large_displacement)
    elements = elements_per_half_width or usual
    if solid:  # its deck takes time to write
        progress("size of the deck", 0, 1, None)
        expected = partial(_expected, scene, coarse_result(scene), position, deck_of)
        deck = expected(elements)
        require_size(deck.unknowns, most_unknowns, elements, expected)
        seconds = least_seconds(deck, program) if run and shutil.which(program) else None
        progress(f"deck of about {rounded(deck.unknowns)} unknowns", 0, 1, seconds)
    result = _solved(scene, position, progress)
    progress("deck", 0, 1, None)
    model = deck_of(scene, result, position, elements_per_half_width=elements)
    require_size(model.deck.unknowns, most_unknowns, elements)
    path = _write(model.deck, folder)
    watched = partial(_tell_iteration, progress)
    keep = folder is not None
    answer = None
    if run:
        answer = _run(path.parent, model.deck, program, time_limit_s, keep=keep, watched=watched)
    return comparison_of(scene, result, position, model, path if path.exists() else None, answer)


def _silent(*_: object) -> None:
    """No progress."""


def _tell_iteration(progress: Progress, done: int) -> None:
    """Progress of CalculiX, whose number of iterations is not known."""
    progress(f"CalculiX, iteration {done + 1}", done, max(ITERATIONS, done + 1), None)


def _expected(
    scene: Scene, result: Result, position: int, deck_of: Callable[..., Model], elements: float
) -> Deck:
    """The deck by a coarse result, which has fewer positions if there are many."""
    near = min(position, result.position_rad.size - 1)
    return deck_of(scene, result, near, elements_per_half_width=elements).deck


def _write(deck: Deck, folder: str | Path | None) -> Path:
    """Write the deck into the folder, or into a new temporary one."""
    place = Path(folder) if folder is not None else Path(tempfile.mkdtemp(prefix="flankload_"))
    place.mkdir(parents=True, exist_ok=True)
    path = place / f"{JOB}.inp"
    write_atomically(path, deck_text(deck).encode("ascii", errors="replace"))
    return path


def _run(
    folder: Path,
    deck: Deck,
    program: str,
    time_limit_s: float | None,
    *,
    keep: bool,
    watched: Callable[[int], None],
) -> Answer:
    """Solution of CalculiX; the folder is deleted unless it is kept or there is no solution."""
    try:
        found, limit = find_program(program, folder), time_limit_s
        watched(0)
        return run_deck(found, folder, deck, time_limit_s=limit, on_iteration=watched)
    except Exception:
        keep = True
        raise
    finally:  # also after an interrupt
        if not keep:
            shutil.rmtree(folder)


def _checked(scene: Scene) -> Scene:
    """The scene with its effects chosen, of which a deck can be written."""
    scene, _ = choose_effects(first_scene(scene))
    check_bodies(scene)
    if not any(scene.torques_Nm):
        refuse("load.torque_Nm", "a torque > 0", "0", scene.file)
    return scene


def _solved(scene: Scene, position: int, progress: Progress) -> Result:
    """Flankload's own result for the largest torque."""
    results = run_once(scene, progress=lambda stage, done, of: progress(stage, done, of, None))
    result = max(results, key=lambda result: result.torque_Nm)
    count = result.position_rad.size
    if not 0 <= position < count:
        expected = f"an index from 0 to {count - 1}, since there are {count} positions"
        refuse("position", expected, f"{position}", scene.file)
    return result
