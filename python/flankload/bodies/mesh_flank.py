"""The flank of a body from a mesh: its edges in order, the curve through its nodes or its profile.

A flank runs from root to tip with the material on its right. Middle nodes that lie on the chords of
their edges (linear elements, straight-sided quadratic ones) say nothing of the profile: the curve
then goes through the corner nodes alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import FlankNodes
from flankload.bodies.gear_profile import gear_profile
from flankload.errors import SceneError
from flankload.flank_curve import FlankCurve, curve_through_nodes, nodes_deviation
from flankload.plane_mesh import chain

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.involute import Involute
    from flankload.bodies.mesh_source import MeshSource
    from flankload.scene import MeshBody

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: A flank's nodes must lie on the given profile to this part of its module, and the tip circle must
#: be that of the mesh to the second one.
PROFILE_TOLERANCE, TIP_TOLERANCE = 0.005, 0.02
#: Ends of the flank's nodes nearer than this to an end of the profile's flank are that end, mm.
SNAP_MM = 1e-6
#: Neighbouring edges of a flank turn by less than this, degrees: beyond it stands a corner.
LARGEST_BEND_DEG = 40.0
#: Middle nodes that stand out of their chords by less than this part of what the corner nodes let
#: expect lie on the chords.
STRAIGHT = 0.05
#: A flank whose curve leaves its chords by less than this part of their length is straight itself.
FLAT = 1e-5


@dataclass(frozen=True)
class FlankFit:
    """The curve of a flank and where its nodes lie on it.

    Attributes
    ----------
    curve : FlankCurve
    involute : Involute or None
    s : (2 m + 1,) array
        Arc lengths of the flank's nodes in order.
    mode_range_mm : (float, float)
    nodes : FlankNodes or None
        None where the profile is given.
    notes : tuple of str
    """

    curve: FlankCurve
    involute: Involute | None
    s: Floats
    mode_range_mm: tuple[float, float]
    nodes: FlankNodes | None
    notes: tuple[str, ...]


def flank_edges(source: MeshSource, key: str, name: str) -> Numbers:
    """Boundary edges of a flank in order, the material on their right.

    Parameters
    ----------
    source : MeshSource
    key : str
        Key that names the set, without the body's.
    name : str
        The set.

    Returns
    -------
    (m, 3) array
        First, last and middle node.

    Raises
    ------
    MeshError
        If the set is missing or is not one open line without corners.
    """
    members = source.nodes_of(key, name)
    edges = source.body.edges
    chosen = edges[np.isin(edges[:, :2], members).all(axis=1)][:, [1, 0, 2]]
    runs = chain(chosen)
    expected = f"set {name!r} to be one open line of at least 2 edges of the boundary"
    if len(runs) != 1 or len(chosen) < 2:
        separate = f"{len(runs)} separate lines" if len(chosen) >= 2 else f"{len(chosen)} edges"
        source.refuse(key, expected, separate)
    (run,) = runs
    if run[0, 0] == run[-1, 1]:
        source.refuse(key, expected, "a closed line")
    nodes = source.body.nodes
    steps = nodes[run[:, 1]] - nodes[run[:, 0]]
    angles = np.degrees(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))
    bends = np.abs(np.diff(angles))
    if bends.max(initial=0.0) > LARGEST_BEND_DEG:
        x, y = nodes[run[int(np.argmax(bends)), 1]]
        source.refuse(
            key,
            f"set {name!r} to be a smooth flank",
            f"a corner of {bends.max():.0f} deg at x = {x:.4f}, y = {y:.4f} mm",
        )
    return run


def in_order(edges: Numbers) -> Numbers:
    """Nodes of consecutive edges in order, middle nodes included: (2 m + 1,)."""
    return np.append(edges[:, [0, 2]].ravel(), edges[-1, 1])


def faces_clockwise(nodes: Floats, edges: Numbers, *, inwards: bool) -> bool:
    """Whether a flank is that of the mirror image: on the way with the material on its right the
    tip comes first. Of teeth that stand inwards the radius falls towards the tip."""
    middle = nodes[edges[len(edges) // 2]]
    return (float(middle.mean(axis=0) @ (middle[1] - middle[0])) < 0.0) != inwards


def middles_are_straight(nodes: Floats, edges: Numbers) -> bool:
    """Whether a flank is curved, but its middle nodes lie on the chords of its edges."""
    first, last, middle = (nodes[edges[:, k]] for k in range(3))
    chord = last - first
    length = np.linalg.norm(chord, axis=1)
    away = middle - 0.5 * (first + last)
    out = np.abs(chord[:, 0] * away[:, 1] - chord[:, 1] * away[:, 0]) / length
    angles = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    # an arc of length h that turns by t leaves its chord by h t/8
    turn = np.abs(np.gradient(angles)) if len(angles) > 1 else np.zeros(1)
    wanted = length * turn / 8
    return bool(wanted.sum() > FLAT * length.sum() and out.sum() < STRAIGHT * wanted.sum())


def fit_flank(
    source: MeshSource, spec: MeshBody, key: str, nodes: Floats, edges: Numbers
) -> FlankFit:
    """Find the curve of a flank.

    Parameters
    ----------
    source : MeshSource
    spec : MeshBody
    key : str
        Key that names the flank's set, without the body's.
    nodes : (N, 2) array
        Of the body, mirrored where need be.
    edges : (m, 3) array
        The flank in order.

    Returns
    -------
    FlankFit

    Raises
    ------
    MeshError
        If the nodes are too few or double back.
    SceneError
        If the given profile does not fit.
    """
    straight = middles_are_straight(nodes, edges)
    points = nodes[in_order(edges)]
    on_profile = points[::2] if straight else points
    fit = (
        _through_nodes(source, key, on_profile)
        if spec.profile is None
        else _on_profile(source, spec, on_profile)
    )
    s, _ = fit.curve.arc_length_of(points)
    if not (np.diff(s) > 0).all():
        x, y = points[int(np.argmin(np.diff(s)))]
        source.refuse(
            key,
            "flank nodes that follow each other along the flank",
            f"nodes that turn back at x = {x:.4f}, y = {y:.4f} mm",
        )
    notes = fit.notes
    if straight and not source.body.linear:
        note = (
            "the middle nodes of the flank lie on straight edges: the curve goes through its "
            "corner nodes alone"
        )
        notes = (note, *notes)
    return replace(fit, s=s, notes=notes)


def _through_nodes(source: MeshSource, key: str, points: Floats) -> FlankFit:
    """A smooth curve through the nodes."""
    if len(points) < 4:
        source.refuse(
            key,
            "at least 4 nodes on the profile for a curve through them",
            f"{len(points)} nodes",
        )
    curve = curve_through_nodes(points)
    spacing = float(np.linalg.norm(np.diff(points, axis=0), axis=1).max())
    found = FlankNodes(len(points), spacing, nodes_deviation(points))
    deviation = (
        f"estimated deviation from the true profile {1000 * found.deviation_mm:.2g} um"
        if np.isfinite(found.deviation_mm)
        else "too few to tell how far it deviates from the true profile"
    )
    note = f"the flank is a smooth curve through {found.count} nodes, {deviation}"
    return FlankFit(curve, None, np.empty(0), (0.0, curve.length_mm), found, (note,))


def _on_profile(source: MeshSource, spec: MeshBody, points: Floats) -> FlankFit:
    """The exact profile, turned so that it fits the flank's nodes (least squares)."""
    given = spec.profile
    assert given is not None
    profile = gear_profile(given, f"{source.key}.profile", teeth=spec.number_of_teeth)
    tip = float(np.hypot(*source.body.nodes.T).max())
    if abs(tip - profile.involute.tip_radius_mm) > TIP_TOLERANCE * given.module_mm:
        raise SceneError(
            key=f"{source.key}.profile.tip_diameter_mm",
            expected=f"the tip circle of the mesh, {2 * tip:.4f} mm",
            found=f"{given.tip_diameter_mm:g}",
        )
    radii = np.hypot(points[:, 0], points[:, 1])
    inside = np.clip(radii, profile.involute.form_radius_mm, profile.involute.tip_radius_mm)
    angles = np.arctan2(points[:, 1], points[:, 0])
    start = np.array([profile.involute.polar_angle_at(radius) for radius in inside])
    apart = np.angle(np.exp(1j * (angles - start)).sum())
    turn, s, worst = fitted_turn(profile.curve, points, float(apart))
    if worst > PROFILE_TOLERANCE * given.module_mm:
        raise SceneError(
            key=f"{source.key}.profile",
            expected=f"a profile on which the nodes of the flank lie to "
            f"{PROFILE_TOLERANCE * given.module_mm:.3g} mm",
            found=f"nodes up to {worst:.3g} mm beside it",
        )
    low, high = float(s[0]), float(s[-1])
    flank = profile.mode_range_mm
    low = flank[0] if abs(low - flank[0]) < SNAP_MM else low
    high = flank[1] if abs(high - flank[1]) < SNAP_MM else high
    involute = replace(profile.involute, turn_rad=profile.involute.turn_rad + turn)
    note = (
        f"the given profile is turned by {np.degrees(turn):.6f} deg to fit {len(s)} flank nodes, "
        f"which lie within {1000 * worst:.2g} um of it"
    )
    return FlankFit(profile.curve.rotated(turn), involute, np.empty(0), (low, high), None, (note,))


def fitted_turn(curve: FlankCurve, points: Floats, start: float) -> tuple[float, Floats, float]:
    """Turn about the origin that brings a curve nearest to points (least squares).

    Parameters
    ----------
    curve : FlankCurve
    points : (m, 2) array
    start : float
        A turn to begin with, rad.

    Returns
    -------
    turn : float
        rad.
    s : (m,) array
        Arc lengths of the points.
    worst : float
        Largest distance that is left, mm.
    """
    turn = start
    for _ in range(12):
        turned = curve.rotated(turn)
        s, _ = turned.arc_length_of(points)
        # a curve turned by d moves by d (P . t) along its normal: Gauss-Newton
        place = turned.point(s)
        lever = np.sum(place * turned.tangent(s), axis=1)
        distance = np.sum((points - place) * turned.normal(s), axis=1)
        step = float(lever @ distance / (lever @ lever))
        turn += step
        if abs(step) < 1e-15:
            break
    s, away = curve.rotated(turn).arc_length_of(points)
    return turn, s, float(away.max())
