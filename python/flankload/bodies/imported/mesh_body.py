"""Bodies of kind "mesh": one sector or the whole body from a mesh file with named sets.

The file contains the body at position zero, with its axis at the origin. Linear elements are
converted to quadratic ones; flanks are ordered from root to tip with the material on their right.
The flank curve is the exact profile, rotated to fit the nodes, or a smooth curve through them.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import Body, Material, SectorMesh, WholeMesh
from flankload.bodies.imported.mesh_curve import fit_flank
from flankload.bodies.imported.mesh_sector import sector_of
from flankload.bodies.imported.mesh_source import (
    MeshSource,
    check_axis,
    faces_clockwise,
    flank_edges,
    in_order,
    read_source,
)
from flankload.bodies.imported.mesh_whole import whole_of
from flankload.bodies.plane import sketched_tooth
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.imported.mesh_curve import FlankFit
    from flankload.scene import MeshBody

#: Largest relative difference of elastic constants in the file from those of the scene.
MATERIAL_TOLERANCE = 1e-3


def build_mesh_body(spec: MeshBody, key: str, *, folder: Path) -> Body:
    """Build a body from a mesh file.

    Raises
    ------
    MeshError, SceneError
        If the file is missing or unreadable, its mesh, sets, flanks or cuts are faulty, or the
        profile does not fit.
    """
    source = read_source(spec, key, folder=folder)
    notes = source.body.notes
    named, bare = _named_flanks(source), _is_bare(source)
    flanks, radii = list(named.values()), np.hypot(*source.body.nodes.T)
    inwards = _is_ring(source, radii, radii[flanks[0][:, 0]], bare=bare)
    if mirrored := faces_clockwise(source.body.nodes, flanks[0], inwards=inwards):
        source, flanks = source.mirrored(), [flank[::-1][:, [1, 0, 2]] for flank in flanks]
        notes = (*notes, "the flank faces clockwise: the mirror image of the body is used")
    fixed = np.empty(0, dtype=np.int64) if bare else _fixed_nodes(source, named)
    fit = fit_flank(source, flanks[0])
    mesh: SectorMesh | WholeMesh | None = None
    turns: tuple[float, ...] = ()
    if bare:
        outline = sketched_tooth(source.body.nodes[in_order(fit.edges)], spec.number_of_teeth)
    elif spec.flank_sets is None:
        mesh, outline = sector_of(source, flanks[0], fixed, fit)
    else:
        mesh, outline, turns, more = whole_of(source, flanks, fixed, fit)
        notes = (*notes, *more)
    body = Body(
        kind="mesh",
        curve=fit.curve,
        teeth=spec.number_of_teeth,
        material=Material(spec.young_modulus_MPa, spec.poisson_ratio),
        rigid=spec.rigid,
        mesh=None if spec.rigid else mesh,
        mode_range_mm=fit.mode_range_mm,
        reference_radius_mm=_reference_radius(spec, key, fit),
        involute=fit.involute,
        flank_angle_known=fit.involute is not None,
        pitch_errors_um=tuple(spec.pitch_errors_um),
        outline=outline,
        bore_radius_mm=float(
            (radii.max() if inwards else radii.min()) if bare else radii[fixed].mean()
        ),
        notes=(*notes, *_material_notes(source), *fit.notes),
        flank_turns_rad=turns,
        named_teeth=_named_teeth(mesh, spec.number_of_teeth),
        flank_nodes=fit.nodes,
        mirrored=mirrored,
    )
    if fit.modified is None:
        return body
    curve, span = fit.modified.curve, fit.modified.mode_range_mm
    elements = None if body.rigid else body
    return replace(body, curve=curve, mode_range_mm=span, elements=elements)


def _named_flanks(source: MeshSource) -> dict[str, Numbers]:
    """Edges of each flank by the name of its set, tooth 0 first."""
    spec = source.spec
    names = [("flank_set", spec.flank_set)]
    if spec.flank_sets is not None:
        names = [(f"flank_sets[{k}]", name) for k, name in enumerate(spec.flank_sets)]
    return {name: flank_edges(source, where, name) for where, name in names}


def _named_teeth(mesh: SectorMesh | WholeMesh | None, teeth: int) -> tuple[int, ...]:
    """Teeth with a flank in a whole mesh, unless all have one."""
    if not isinstance(mesh, WholeMesh) or len(mesh.flanks) == teeth:
        return ()
    return tuple(flank.tooth for flank in mesh.flanks)


def _reference_radius(spec: MeshBody, key: str, fit: FlankFit) -> float:
    """The given radius, or that of the base circle of the profile."""
    if spec.reference_radius_mm is not None:
        return spec.reference_radius_mm
    if fit.involute is None:
        expected = "a radius in mm, since without a profile there is no base circle"
        refuse(f"{key}.reference_radius_mm", expected, "nothing")
    return fit.involute.base_radius_mm


def _is_bare(source: MeshSource) -> bool:
    """Whether the file of a rigid body has only a flank, without the sets of rim and cuts."""
    spec = source.spec
    others = (spec.fixed_set, *spec.cut_sets)
    missing = any(source.raw.set_name(name) is None for name in others)
    return spec.rigid and spec.flank_sets is None and missing


def _is_ring(source: MeshSource, radii: Floats, flank: Floats, *, bare: bool) -> bool:
    """Whether the body is fixed, or if bare extends farther, outside than inside its flank."""
    if bare:
        return bool(radii.max() - flank.max() > flank.min() - radii.min())
    held = radii[source.nodes_of("fixed_set", source.spec.fixed_set)]
    return bool(held.size and held.min() > flank.max())


def _fixed_nodes(source: MeshSource, flanks: dict[str, Numbers]) -> Numbers:
    """Fixed nodes, checked: at least two, not on the flanks, on a circle about the axis."""
    spec = source.spec
    fixed = source.nodes_of("fixed_set", spec.fixed_set)
    if fixed.size < 2:
        source.refuse(
            "fixed_set", "at least 2 nodes, to hold the body", f"{fixed.size} in {spec.fixed_set!r}"
        )
    for name, flank in flanks.items():
        held = np.isin(flank, fixed)
        if held.any():
            source.refuse(
                "fixed_set",
                f"fixed nodes that are not on the flank ({name!r})",
                f"{np.unique(flank[held]).size} nodes of {spec.fixed_set!r} on it",
            )
    check_axis(source, fixed)
    return fixed


def _material_notes(source: MeshSource) -> list[str]:
    """Note on the material in the file, if it differs from that of the scene."""
    if source.raw.elastic is None:
        return []
    (modulus, ratio), spec = source.raw.elastic, source.spec
    same = (
        abs(modulus - spec.young_modulus_MPa) <= MATERIAL_TOLERANCE * spec.young_modulus_MPa
        and abs(ratio - spec.poisson_ratio) <= MATERIAL_TOLERANCE
    )
    if same:
        return []
    note = (
        f"the file's own material (E = {modulus:g}, nu = {ratio:g}) is not used: "
        f"{source.key}.young_modulus_MPa = {spec.young_modulus_MPa:g} and poisson_ratio = "
        f"{spec.poisson_ratio:g} are"
    )
    return [note]
