"""Comparison of one position by flankload and by nonlinear finite elements."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.arguments import require, require_path
from flankload.base.card import Card
from flankload.base.files import write_atomically
from flankload.mechanisms import run_once
from flankload.scene import Scene, SceneLike, scene_of
from flankload.scene.effects import is_spatial
from flankload.scene.refusal import refuse
from flankload.studies.plan import choose_effects
from flankload.studies.tolerance import first_scene
from flankload.studies.verification.calculix import JOB, Answer, find_program, run_deck
from flankload.studies.verification.deck import Deck, deck_text
from flankload.studies.verification.deck_model import Model, check_bodies, model_of
from flankload.studies.verification.report import json_of, text_of
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

    from numpy.typing import NDArray

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.result import Result
    from flankload.result.slices import SliceLoads

    Progress = Callable[[str, int, int, float | None], None]

#: Elements on the half-width of a contact by default, in the plane and of solids.
ELEMENTS, SOLID_ELEMENTS = 6.0, 1.0


@dataclass(frozen=True, eq=False)
class Layers:
    """Layers of solid bodies over the common width, and the load in each; S pairs, L layers.

    `edges_mm` (L + 1,) are their ends along the axes; `line_load_N_per_mm` (S, L), of flankload, is
    the mean over the parts of its slices that lie in a layer; `unknowns` counts the independent
    displacements of the deck; `half_width_mm` is that of the widest contact, by flankload.
    """

    edges_mm: Floats
    line_load_N_per_mm: Floats
    unknowns: int
    half_width_mm: float

    def line_load_factor(self, line_load_N_per_mm: Floats) -> float:
        """Largest line load, summed over the pairs, over its mean; NaN without load."""
        summed = line_load_N_per_mm.sum(axis=0)
        mean = np.average(summed, weights=np.diff(self.edges_mm))
        return float(summed.max() / mean) if mean > 0 else float("nan")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class SolvedPosition(Card):
    """Values of flankload at a position, as `Verification` describes them."""

    name: str
    position: int
    position_rad: float
    torque_Nm: float
    face_width_mm: float
    reference_radius_mm: float
    sites: Numbers
    rotation_rad: float
    site_force_N: Floats
    peak_pressure_MPa: Floats
    corner_contact: Flags
    job_cpu_s: float
    position_cpu_s: float
    positions: int


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Verification(SolvedPosition):
    """One position by both programs; S pairs that may touch.

    Attributes
    ----------
    name : str
        Name of the scene.
    position : int
        Index of the position.
    position_rad, torque_Nm, face_width_mm, reference_radius_mm : float
    sites : (S,) array
        Pair numbers.
    rotation_rad : float
        Rotation of body 1, by flankload.
    site_force_N, peak_pressure_MPa : (S,) arrays
        Values of flankload; pressures of solid bodies are NaN, since they are not compared.
    corner_contact : (S,) bool array
        Contact on a sharp corner, where no finite peak pressure exists.
    job_cpu_s, position_cpu_s : float
        Flankload's CPU seconds for all positions of the scene, including finite elements, and for
        one more position.
    positions : int
        Number of positions of the scene.
    nodes, elements : int
        Size of the deck.
    finest_mm : float
        Length of its elements at the contacts.
    deck : Path or None
        The input file; None if it was in a deleted temporary folder.
    calculix : Answer or None
        Solution of CalculiX, per mm of width; None if it was not run.
    layers : Layers or None
        Layers of solid bodies; None in a plane scene.
    """

    nodes: int
    elements: int
    finest_mm: float
    deck: Path | None
    calculix: Answer | None
    layers: Layers | None = None

    @property
    def rotation_difference(self) -> float:
        """Flankload's rotation divided by that of CalculiX, minus one; NaN if that was not run."""
        if self.calculix is None:
            return float("nan")
        return self.rotation_rad / self.calculix.rotation_rad - 1.0

    @property
    def share_difference(self) -> Floats:
        """(S,) Flankload's load shares minus those of CalculiX; NaN if that was not run."""
        if self.calculix is None:
            return np.full(self.sites.size, np.nan)
        other = self.calculix.force_N_per_mm
        return np.asarray(self.site_force_N / self.site_force_N.sum() - other / other.sum())

    def to_json(self) -> str:
        """Return everything as strict JSON (null for what is not a number)."""
        return json_of(self)

    def table(self) -> str:
        """Return the results of both programs side by side as text."""
        return text_of(self)


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
        As of `solve`; the largest of a list of torques is used.
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
    plane = not is_spatial(scene).on
    deck_of = partial(model_of if plane else solid_model_of, large_displacement=large_displacement)
    elements = elements_per_half_width or (ELEMENTS if plane else SOLID_ELEMENTS)
    if not plane:
        expected = partial(_expected, scene, coarse_result(scene), position, deck_of)
        deck = expected(elements)
        require_size(deck.unknowns, most_unknowns, elements, expected)
        seconds = least_seconds(deck, program) if run and shutil.which(program) else None
        stage = f"deck of about {rounded(deck.unknowns)} unknowns"
        progress(stage, 0, 1, seconds)
    result = _solved(scene, position, progress)
    model = deck_of(scene, result, position, elements_per_half_width=elements)
    if plane:
        require_size(model.deck.unknowns, most_unknowns, elements)
    path = _write(model.deck, folder)
    watched = partial(_tell_iteration, progress)
    keep = folder is not None
    answer = None
    if run:
        answer = _run(path.parent, model.deck, program, time_limit_s, keep=keep, watched=watched)
    return _comparison(scene, result, position, model, path if path.exists() else None, answer)


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


def _comparison(
    scene: Scene,
    result: Result,
    position: int,
    model: Model,
    deck: Path | None,
    answer: Answer | None,
) -> Verification:
    """Flankload's values at the sites of the deck, beside the solution of CalculiX."""
    sites = np.array(model.deck.sites)
    column = {site: s for s, site in enumerate(result.sites.tolist())}
    rows = [column.get(site, -1) for site in sites.tolist()]

    def of_sites(values: NDArray[Any]) -> NDArray[Any]:
        return np.append(values[position], np.zeros(1, values.dtype))[rows]

    layers = None if result.slices is None else _layers(result.slices, position, model, rows)
    stages, positions = result.cost["stages"], result.position_rad.size
    return Verification(
        name=result.name,
        position=position,
        position_rad=float(result.position_rad[position]),
        torque_Nm=result.torque_Nm,
        face_width_mm=result.face_width_mm,
        reference_radius_mm=result.reference_radius_mm,
        sites=sites,
        rotation_rad=float(result.rotation_rad[position]),
        site_force_N=of_sites(result.site_force_N),
        peak_pressure_MPa=of_sites(result.peak_pressure_MPa)
        if layers is None
        else np.full(sites.size, np.nan),
        corner_contact=of_sites(result.corner_contact),
        job_cpu_s=sum(stage["cpu_s"] for stage in stages.values()),
        position_cpu_s=stages["sweep"]["cpu_s"] / (positions * len(scene.torques_Nm)),
        positions=positions,
        nodes=model.deck.node_count,
        elements=sum(len(part.cells) for part in model.deck.parts),
        finest_mm=model.finest_mm,
        deck=deck,
        calculix=answer,
        layers=layers,
    )


def _layers(slices: SliceLoads, position: int, model: Model, rows: list[int]) -> Layers:
    """Flankload's line load in the layers of the deck; rows: of its sites, -1 if it has none."""
    edges = model.deck.edges_mm
    assert edges is not None
    half = 0.5 * slices.width_mm
    low = np.maximum(edges[:-1, np.newaxis], slices.z_mm - half)
    high = np.minimum(edges[1:, np.newaxis], slices.z_mm + half)
    parts = np.maximum(high - low, 0.0) / np.diff(edges)[:, np.newaxis]
    ours = slices.line_load_N_per_mm[position]
    return Layers(
        edges_mm=edges,
        line_load_N_per_mm=np.append(ours, np.zeros((1, slices.z_mm.size)), axis=0)[rows] @ parts.T,
        unknowns=model.deck.unknowns,
        half_width_mm=model.half_width_mm,
    )


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
