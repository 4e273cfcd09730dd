"""Mesh of a whole body from a file: several flanks of one shape.

The first set is the flank of tooth 0; the tooth numbers of the others follow from their angles. The
deviation of an angle from a multiple of the pitch is a pitch deviation.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import MeshedFlank, WholeMesh
from flankload.bodies.imported.mesh_curve import edges_between, fitted_turn
from flankload.bodies.imported.mesh_source import faces_clockwise, in_order, middles_are_straight
from flankload.meshes.plane_mesh import boundary_edges, chain

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Cells, Floats, Numbers
    from flankload.bodies.imported.mesh_curve import FlankFit
    from flankload.bodies.imported.mesh_source import MeshSource


#: Largest difference in shape of flanks, over the body's radius, to which five times the deviation
#: of the curve through the nodes, or of the nodes from the profile, is added.
SHAPE_TOLERANCE = 2e-5
#: Largest difference of the ends of flanks, over their length.
END_TOLERANCE = 1e-4
#: Largest pitch deviation, in pitches.
LARGEST_PITCH_DEVIATION = 0.1
#: Least pitch deviation, rad; smaller ones are rounding errors of nodes in files.
LEAST_PITCH_DEVIATION_RAD = 2e-7


def whole_of(
    source: MeshSource, flanks: list[Numbers], fixed: Numbers, fit: FlankFit
) -> tuple[WholeMesh, Floats, tuple[float, ...], tuple[str, ...]]:
    """Whole mesh, outer contour (k, 2) of one tooth, pitch deviations, rad, and notes.

    The deviations are empty if all are 0. The edges (m, 3) of the flanks are in order, tooth 0
    first, whose curve is `fit`.

    Raises
    ------
    MeshError
        If the flanks differ in shape or are not at multiples of the pitch.
    """
    spec, nodes, cells = source.spec, source.body.nodes, source.body.cells
    teeth, names = spec.number_of_teeth, spec.flank_sets or ()
    turns = np.zeros(teeth)
    meshed: dict[int, MeshedFlank] = {}
    first = nodes[in_order(flanks[0])]
    for k, (name, flank) in enumerate(zip(names, flanks, strict=True)):
        turn, edges, s = 0.0, fit.edges, fit.s
        if k > 0:
            turn, edges, s = _turn_of(source, flank, first, fit, k)
        tooth, beside = _tooth_at(source, turn, k)
        if tooth in meshed:
            source.refuse(f"flank_sets[{k}]", "one flank to a tooth", f"{name!r} on another one")
        arc_length = np.full(len(nodes), np.nan)
        arc_length[in_order(edges)] = s
        meshed[tooth] = MeshedFlank(tooth, nodes, edges, arc_length)
        turns[tooth] = beside if abs(beside) > LEAST_PITCH_DEVIATION_RAD else 0.0
    in_order_of_teeth = tuple(meshed[tooth] for tooth in sorted(meshed))
    mesh = WholeMesh(nodes=nodes, cells=cells, fixed_nodes=fixed, flanks=in_order_of_teeth)
    outline = _outline(nodes, cells, flanks[0], 2 * np.pi / teeth)
    notes = tuple(_notes(turns, len(meshed)))
    return mesh, outline, tuple(turns.tolist()) if turns.any() else (), notes


def _tooth_at(source: MeshSource, turn: float, k: int) -> tuple[int, float]:
    """Number of the tooth of set k at an angle from tooth 0, and its deviation, rad."""
    teeth, names = source.spec.number_of_teeth, source.spec.flank_sets or ()
    pitch = 2 * np.pi / teeth
    tooth = round(turn / pitch) % teeth
    beside = (turn - pitch * tooth + np.pi) % (2 * np.pi) - np.pi
    if abs(beside) > LARGEST_PITCH_DEVIATION * pitch:
        expected = f"flanks that are whole pitches (360/{teeth} deg) from {names[0]!r}"
        source.refuse(f"flank_sets[{k}]", expected, f"{names[k]!r} at {turn / pitch:.3f} pitches")
    return tooth, beside


def _notes(turns: Floats, with_flank: int) -> Iterator[str]:
    if turns.any():
        yield (
            f"the flanks deviate by up to {np.degrees(np.abs(turns).max()):.2g} deg from equal "
            "shares of the body: used as pitch deviations"
        )
    if with_flank < turns.size:
        yield (
            f"{with_flank} of {turns.size} teeth have a flank in the file: "
            "the others cannot carry load"
        )


def _turn_of(
    source: MeshSource, edges: Numbers, first: Floats, fit: FlankFit, k: int
) -> tuple[float, Numbers, Floats]:
    """Angle of flank k from that of tooth 0 (`first`: nodes), edges with modes, arc lengths."""
    nodes, name = source.body.nodes, (source.spec.flank_sets or ())[k]
    key = f"flank_sets[{k}]"
    inwards = bool(np.hypot(*first[0]) > np.hypot(*first[-1]))
    if faces_clockwise(nodes, edges, inwards=inwards):
        source.refuse(key, "flanks that all face the same way", f"{name!r} facing the other way")
    points = nodes[in_order(edges)]
    there, here = points[[0, -1]].sum(axis=0), first[[0, -1]].sum(axis=0)
    start = float(np.arctan2(there[1], there[0]) - np.arctan2(here[1], here[0]))
    straight = middles_are_straight(nodes, edges)
    turn, _, worst = fitted_turn(fit.curve, points[::2] if straight else points, start)
    deviation = fit.nodes.deviation_mm if fit.nodes is not None else fit.misfit_mm
    radius = float(np.hypot(*nodes.T).max())
    allowed = SHAPE_TOLERANCE * radius + 5 * (deviation if np.isfinite(deviation) else 0.0)
    if worst > allowed:
        source.refuse(
            key,
            f"flanks of one shape (to {allowed:.2g} mm)",
            f"{name!r}, up to {worst:.3g} mm beside the first one turned onto it",
        )
    span = (float(fit.s[0]), float(fit.s[-1]))
    edges, s = edges_between(source, key, fit.curve.rotated(turn), span, edges)
    beside = max(abs(s[0] - fit.s[0]), abs(s[-1] - fit.s[-1]))
    if beside > END_TOLERANCE * fit.curve.length_mm + allowed:
        expected = "flanks that end at the same places"
        source.refuse(key, expected, f"{name!r}, which ends {beside:.3g} mm beside the first one")
    return turn % (2 * np.pi), edges, s


def _outline(nodes: Floats, cells: Cells, flank: Numbers, pitch: float) -> Floats:
    """Outer contour from the root of tooth 0's flank to the same point of the next tooth."""
    edges = boundary_edges(cells)
    root = flank[0, 0]
    run = next(run for run in chain(edges) if (run[:, :2] == root).any())
    path = run[:, [0, 2]].ravel()
    places = nodes[np.roll(path, -int(np.flatnonzero(path == root)[0]))]
    end = int(np.argmin(np.linalg.norm(places - turned(places[:1], pitch), axis=1)))
    return np.asarray(places[: end + 1] if end else places)
