"""The curve of a flank from a mesh: a smooth curve through its nodes, or the exact profile.

Middle nodes on the chords of their edges (linear or straight-sided elements) are ignored.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import FlankNodes
from flankload.bodies.imported.mesh_source import in_order, middles_are_straight
from flankload.bodies.profile.gear_profile import gear_profile
from flankload.flank import FlankCurve, curve_through_nodes, nodes_deviation
from flankload.scene.refusal import refuse
from flankload.scene.unmodified import unmodified

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.imported.mesh_source import MeshSource
    from flankload.bodies.profile.involute import Involute
    from flankload.scene import Profile


#: Largest distance of a flank's nodes from the exact profile, and largest difference of the tip
#: radii of mesh and profile; both in modules.
PROFILE_TOLERANCE, TIP_TOLERANCE = 0.005, 0.02
#: Distance below which the ends of the nodes are moved to the ends of the profile's flank, over its
#: length.
SNAP_TOLERANCE = 1e-7
#: Largest excess of edges beyond the profile's flank, over its length.
END_TOLERANCE = 1e-4


@dataclass(frozen=True)
class ModifiedFlank:
    """A modified flank and the arc lengths on it between which the nodes have pressure modes."""

    curve: FlankCurve
    mode_range_mm: tuple[float, float]


@dataclass(frozen=True)
class FlankFit:
    """The curve of a flank and the arc lengths of its nodes.

    Attributes
    ----------
    curve : FlankCurve
    involute : Involute or None
    mode_range_mm : (float, float)
    misfit_mm : float
        Largest distance of the nodes from the exact profile.
    nodes : FlankNodes or None
        None with an exact profile.
    notes : tuple of str
    edges : (m, 3) array
        Edges of the flank with pressure modes; with an exact profile, those between its fillet and
        its tip rounding.
    s : (2 m + 1,) array
        Arc lengths of their nodes in order.
    modified : ModifiedFlank or None
        The flank in contact, if the nodes lie on the profile without its modifications.
    """

    curve: FlankCurve
    involute: Involute | None
    mode_range_mm: tuple[float, float]
    misfit_mm: float
    nodes: FlankNodes | None
    notes: tuple[str, ...]
    edges: Numbers = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))
    s: Floats = field(default_factory=lambda: np.empty(0))
    modified: ModifiedFlank | None = None


def fit_flank(source: MeshSource, edges: Numbers) -> FlankFit:
    """Find the curve of the flank of tooth 0, whose edges (m, 3) are in order.

    Raises
    ------
    MeshError
        If there are too few nodes, or they are out of order.
    SceneError
        If the exact profile does not fit.
    """
    spec, nodes = source.spec, source.body.nodes
    key = "flank_set" if spec.flank_sets is None else "flank_sets[0]"
    straight = middles_are_straight(nodes, edges)
    points = nodes[in_order(edges)]
    on_profile = points[::2] if straight else points
    if spec.profile is None:
        fit = _through_nodes(source, key, on_profile)
    else:
        fit = _on_profile(source, spec.profile, on_profile)
    edges, s = edges_between(source, key, fit.curve, fit.mode_range_mm, edges)
    ends = fit.mode_range_mm
    snap = SNAP_TOLERANCE * (ends[1] - ends[0])
    low = ends[0] if abs(s[0] - ends[0]) < snap else float(s[0])
    high = ends[1] if abs(s[-1] - ends[1]) < snap else float(s[-1])
    modified = fit.modified
    if modified is not None:
        first, last = modified.mode_range_mm
        scale = (last - first) / (ends[1] - ends[0])
        span = (first + scale * (low - ends[0]), last + scale * (high - ends[1]))
        modified = replace(modified, mode_range_mm=span)
    notes = fit.notes
    if straight and not source.body.linear:
        note = (
            "the middle nodes of the flank lie on straight edges: the curve goes through its "
            "corner nodes alone"
        )
        notes = (note, *notes)
    return replace(fit, edges=edges, s=s, mode_range_mm=(low, high), notes=notes, modified=modified)


def edges_between(
    source: MeshSource, key: str, curve: FlankCurve, span: tuple[float, float], edges: Numbers
) -> tuple[Numbers, Floats]:
    """Edges (k, 3) of a flank between two arc lengths, and arc lengths (2 k + 1,) of their nodes.

    The edges are those of the flank of the curve, in order; the key names their set.

    Raises
    ------
    MeshError
        If the nodes are out of order, or fewer than 2 edges remain.
    """
    points = source.body.nodes[in_order(edges)]
    s, _ = curve.arc_length_of(points)
    if not (np.diff(s) > 0).all():
        x, y = points[int(np.argmin(np.diff(s)))]
        expected = "flank nodes that follow each other along the flank"
        source.refuse(key, expected, f"nodes that turn back at x = {x:.4f}, y = {y:.4f} mm")
    spare = END_TOLERANCE * (span[1] - span[0])
    inside = np.flatnonzero((s[:-2:2] >= span[0] - spare) & (s[2::2] <= span[1] + spare))
    if inside.size < 2:
        expected = "at least 2 edges between root fillet and tip rounding of the profile"
        source.refuse(key, expected, f"{inside.size}")
    first, last = int(inside[0]), int(inside[-1])
    return edges[first : last + 1], s[2 * first : 2 * last + 3]


def _through_nodes(source: MeshSource, key: str, points: Floats) -> FlankFit:
    """A smooth curve through the nodes."""
    if len(points) < 4:
        expected = "at least 4 nodes on the profile for a curve through them"
        source.refuse(key, expected, f"{len(points)} nodes")
    curve = curve_through_nodes(points)
    spacing = float(np.linalg.norm(np.diff(points, axis=0), axis=1).max())
    found = FlankNodes(len(points), spacing, nodes_deviation(points))
    deviation = (
        f"estimated deviation from the true profile {1000 * found.deviation_mm:.2g} um"
        if np.isfinite(found.deviation_mm)
        else "too few to estimate its deviation from the true profile"
    )
    note = f"the flank is a smooth curve through {found.count} nodes, {deviation}"
    return FlankFit(
        curve=curve,
        involute=None,
        mode_range_mm=(0.0, curve.length_mm),
        misfit_mm=0.0,
        nodes=found,
        notes=(note,),
    )


def _on_profile(source: MeshSource, spec: Profile, points: Floats) -> FlankFit:
    """The exact profile, rotated to fit the flank's nodes (least squares).

    The nodes lie on the modified or on the unmodified flank.
    """
    key, teeth = f"{source.key}.profile", source.spec.number_of_teeth
    modified = gear_profile(spec, key, teeth=teeth)
    tip = float(np.hypot(*source.body.nodes.T).max())
    if abs(tip - modified.involute.tip_radius_mm) > TIP_TOLERANCE * spec.module_mm:
        expected = f"the tip circle of the mesh, {2 * tip:.4f} mm"
        refuse(f"{key}.tip_diameter_mm", expected, f"{spec.tip_diameter_mm:g}")
    radii = np.hypot(points[:, 0], points[:, 1])
    inside = np.clip(radii, modified.involute.form_radius_mm, modified.involute.tip_radius_mm)
    angles = np.arctan2(points[:, 1], points[:, 0])
    start = np.array([modified.involute.polar_angle_at(radius) for radius in inside])
    apart = float(np.angle(np.exp(1j * (angles - start)).sum()))
    profiles, plain = [modified], unmodified(spec)
    if plain != spec:
        profiles.append(gear_profile(plain, key, teeth=teeth))
    fits = [fitted_turn(profile.curve, points, apart) for profile in profiles]
    best = min(range(len(fits)), key=lambda k: fits[k][2])
    turn, s, worst = fits[best]
    if worst > PROFILE_TOLERANCE * spec.module_mm:
        expected = "a profile on which the nodes of the flank lie to "
        expected += f"{PROFILE_TOLERANCE * spec.module_mm:.3g} mm"
        refuse(key, expected, f"nodes up to {worst:.3g} mm beside it")
    profile, contact = profiles[best].rotated(turn), modified.rotated(turn)
    without = " without its modifications" if best else ""
    note = (
        f"the given profile is turned by {np.degrees(turn):.6f} deg to fit {len(s)} flank nodes, "
        f"which lie within {1000 * worst:.2g} um of it{without}"
    )
    return FlankFit(
        curve=profile.curve,
        involute=profile.involute,
        mode_range_mm=profile.mode_range_mm,
        misfit_mm=worst,
        nodes=None,
        notes=(note,),
        modified=ModifiedFlank(contact.curve, contact.mode_range_mm) if best else None,
    )


def fitted_turn(curve: FlankCurve, points: Floats, start: float) -> tuple[float, Floats, float]:
    """Rotation about the origin, rad, that brings a curve closest to points (least squares).

    Returns also the arc lengths (m,) of the points and their largest remaining distance, mm.
    """
    turn = start
    for _ in range(12):
        here = turned(points, -turn)
        s, _ = curve.arc_length_of(here)
        # Gauss-Newton: a rotation by d moves the curve by d (P . t) along its normal
        place = curve.point(s)
        lever = np.sum(place * curve.tangent(s), axis=1)
        distance = np.sum((here - place) * curve.normal(s), axis=1)
        step = float(lever @ distance / (lever @ lever))
        turn += step
        if abs(step) < 1e-15:
            break
    s, away = curve.arc_length_of(turned(points, -turn))
    return turn, s, float(away.max())
