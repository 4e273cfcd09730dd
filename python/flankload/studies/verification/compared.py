"""One position by both programs: its values, and their comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.card import Card
from flankload.studies.verification.report import json_of, text_of

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.result import Result
    from flankload.result.slices import SliceLoads
    from flankload.scene import Scene
    from flankload.studies.verification.calculix import Answer
    from flankload.studies.verification.deck_model import Model


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


def comparison_of(
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
