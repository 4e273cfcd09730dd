"""kind = "mesh": one sector of a body from a mesh file with named sets.

The file stands as the body stands at position zero, its axis at the origin. The flank is put in
order (material on its right, from root to tip), the cut faces are matched, linear elements are
raised to quadratic ones. With the exact profile given, that is the flank's curve, turned so that it
fits the nodes; else a smooth curve goes through the nodes and its deviation is reported.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import Body, Material, SectorMesh
from flankload.bodies.gear_profile import gear_profile
from flankload.errors import MeshError, SceneError
from flankload.flank_curve import FlankCurve, curve_through_nodes, nodes_deviation
from flankload.mesh_io import RawMesh, read_mesh
from flankload.plane_mesh import REVERSED, boundary_edges, chain, jacobians, raise_to_quadratic

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.involute import Involute
    from flankload.scene import MeshBody

#: Nodes of both cuts must match to this part of the body's size.
CUT_TOLERANCE = 1e-6
#: A flank's nodes must lie on the given profile to this part of its module.
PROFILE_TOLERANCE = 0.02
#: Ends of the flank's nodes nearer than this to an end of the profile's flank are that end, mm.
SNAP_MM = 1e-6


@dataclass(frozen=True)
class _Sector:
    """A sector mesh in the making: quadratic, counter-clockwise, flank in order."""

    nodes: NDArray[np.float64]
    cells: tuple[tuple[str, NDArray[np.int64]], ...]
    flank: NDArray[np.int64]
    fixed: NDArray[np.int64]
    left: NDArray[np.int64]
    right: NDArray[np.int64]
    outer: NDArray[np.int64]
    notes: tuple[str, ...]

    @property
    def flank_nodes(self) -> NDArray[np.int64]:
        """Nodes of the flank in order, middle nodes included."""
        return np.append(self.flank[:, [0, 2]].ravel(), self.flank[-1, 1])


def build_mesh_body(spec: MeshBody, key: str, *, folder: Path) -> Body:
    """Body from a mesh file.

    Parameters
    ----------
    spec : MeshBody
        Keys of the scene.
    key : str
        "body_1" or "body_2".
    folder : Path
        Folder that the file's name is relative to.

    Returns
    -------
    Body

    Raises
    ------
    MeshError
        If the file is missing or unreadable, a set is missing, the cut faces do not match, elements
        are inverted, or the flank is not one line.
    SceneError
        If the profile does not fit the mesh.
    """
    path = folder / spec.file
    sector = _read_sector(spec, key, path)
    if spec.profile is None:
        curve = curve_through_nodes(sector.nodes[sector.flank_nodes])
        s, _ = curve.arc_length_of(sector.nodes[sector.flank_nodes])
        involute: Involute | None = None
        mode_range = (0.0, curve.length_mm)
        deviation = nodes_deviation(sector.nodes[sector.flank_nodes])
        note = (
            f"the flank is a smooth curve through {len(s)} nodes, estimated deviation from the "
            f"true profile {1000 * deviation:.2g} um"
        )
    else:
        curve, involute, s, mode_range, note = _fit_profile(spec, key, sector)
    arc_length = np.full(len(sector.nodes), np.nan)
    arc_length[sector.flank_nodes] = s
    mesh = SectorMesh(
        nodes=sector.nodes,
        cells=sector.cells,
        flank_edges=sector.flank,
        flank_arc_length=arc_length,
        fixed_nodes=sector.fixed,
        left_nodes=sector.left,
        right_nodes=sector.right,
        teeth=spec.teeth,
    )
    reference = spec.reference_radius_mm
    if reference is None and involute is not None:
        reference = involute.base_radius_mm
    if reference is None:
        raise SceneError(
            key=f"{key}.reference_radius_mm",
            expected="a radius in mm, since without a profile there is no base circle",
            found="nothing",
        )
    return Body(
        kind="mesh",
        curve=curve,
        teeth=spec.teeth,
        material=Material(spec.young_modulus_MPa, spec.poisson_ratio),
        rigid=spec.rigid,
        mesh=None if spec.rigid else mesh,
        mode_range_mm=mode_range,
        reference_radius_mm=reference,
        involute=involute,
        flank_angle_known=involute is not None,
        pitch_errors_um=tuple(spec.pitch_errors_um),
        outline=sector.nodes[_consecutive(sector.outer)],
        bore_radius_mm=float(np.hypot(*sector.nodes[sector.fixed].T).mean()),
        notes=(*sector.notes, note),
    )


def _read_sector(spec: MeshBody, key: str, path: Path) -> _Sector:
    """Read, raise to quadratic, orient, and find flank, rim and cuts."""
    raw = read_mesh(path, f"{key}.file")
    wanted = {
        f"{key}.flank_set": spec.flank_set,
        f"{key}.fixed_set": spec.fixed_set,
        f"{key}.cut_sets": spec.cut_sets[0],
        f"{key}.cut_sets ": spec.cut_sets[1],
    }
    for where, name in wanted.items():
        if name not in raw.sets or not raw.sets[name].size:
            raise MeshError(
                file=path,
                key=where.strip(),
                expected=f"a set named {name!r} in the mesh",
                found="the sets " + (", ".join(sorted(raw.sets)) or "none at all"),
            )
    notes = []
    if any(kind in ("triangle", "quad") for kind, _ in raw.cells):
        notes.append(
            "linear elements are raised to quadratic ones on straight edges: finer elements, or "
            "quadratic ones with their middle nodes on the profile, follow the flank better"
        )
    nodes, cells = raise_to_quadratic(raw.nodes, raw.cells)
    cells = _counter_clockwise(nodes, cells, path, key)
    edges = boundary_edges(cells)
    flank = _flank_edges(
        nodes, edges, _grown(raw, spec.flank_set, edges), path, key, spec.flank_set
    )
    fixed = _grown(raw, spec.fixed_set, edges)
    middle = nodes[flank[len(flank) // 2]]
    along = middle[1] - middle[0]
    # what is held outside its flank is a ring: from root to tip its radius falls
    held_outside = np.hypot(*nodes[fixed].T).min() > np.hypot(*middle.T).max()
    if (float(middle.mean(axis=0) @ along) < 0.0) != held_outside:
        # on the way that has the material on its right the tip comes first
        nodes = nodes * np.array([1.0, -1.0])
        cells = tuple((kind, data[:, REVERSED[kind]]) for kind, data in cells)
        flank = flank[::-1][:, [1, 0, 2]]
        edges = edges[:, [1, 0, 2]]
        notes.append("the flank faces clockwise: the body is taken in its mirror image")
    if np.isin(flank, fixed).any():
        raise MeshError(
            file=path,
            key=f"{key}.fixed_set",
            expected=f"nodes that are held to stay clear of the flank ({spec.flank_set!r})",
            found=f"{np.unique(flank[np.isin(flank, fixed)]).size} nodes of {spec.fixed_set!r} "
            "on it",
        )
    left, right = _match_cuts(
        nodes,
        [np.setdiff1d(_grown(raw, name, edges), fixed) for name in spec.cut_sets],
        spec,
        path,
        key,
    )
    for side in (left, right):
        if np.isin(flank, side).any():
            raise MeshError(
                file=path,
                key=f"{key}.flank_set",
                expected="a flank that stays clear of the cut faces",
                found="nodes that belong to both",
            )
    inner = [np.union1d(side, fixed) for side in (left, right)] + [fixed]
    outer = ~np.any([np.isin(edges, members).all(axis=1) for members in inner], axis=0)
    return _Sector(nodes, cells, flank, fixed, left, right, edges[outer], tuple(notes))


def _grown(raw: RawMesh, name: str, edges: NDArray[np.int64]) -> NDArray[np.int64]:
    """Nodes of a set, with the middle nodes of boundary edges both of whose ends are in it.

    A set that names only corners would otherwise leave out the middle nodes; one that names edges
    of the boundary is not changed.
    """
    members = raw.sets[name]
    whole = np.isin(edges[:, :2], members).all(axis=1)
    return np.union1d(members, edges[whole, 2])


def _counter_clockwise(
    nodes: NDArray[np.float64],
    cells: tuple[tuple[str, NDArray[np.int64]], ...],
    path: Path,
    key: str,
) -> tuple[tuple[str, NDArray[np.int64]], ...]:
    """Elements numbered counter-clockwise; an element that turns over in itself is an error."""
    done = []
    for kind, data in cells:
        determinants = jacobians(nodes, kind, data)
        clockwise = (determinants < 0).all(axis=1)
        broken = ~clockwise & (determinants <= 0).any(axis=1)
        if broken.any():
            number = int(np.flatnonzero(broken)[0])
            x, y = nodes[data[number]].mean(axis=0)
            raise MeshError(
                file=path,
                key=f"{key}.file",
                expected="elements with a positive Jacobian",
                found=f"{int(broken.sum())} inverted of {len(data)}, the first ({kind}) at "
                f"x = {x:.4f}, y = {y:.4f} mm",
            )
        data = data.copy()
        data[clockwise] = data[clockwise][:, REVERSED[kind]]
        done.append((kind, data))
    return tuple(done)


def _flank_edges(
    nodes: NDArray[np.float64],
    edges: NDArray[np.int64],
    members: NDArray[np.int64],
    path: Path,
    key: str,
    name: str,
) -> NDArray[np.int64]:
    """Boundary edges of the flank in order, the material on their right."""
    chosen = edges[np.isin(edges[:, :2], members).all(axis=1)][:, [1, 0, 2]]
    runs = chain(chosen)
    if len(runs) != 1 or len(chosen) < 2:
        found = f"{len(runs)} separate lines" if len(chosen) >= 2 else f"{len(chosen)} edges"
        raise MeshError(
            file=path,
            key=f"{key}.flank_set",
            expected=f"set {name!r} to be one open line of at least 2 edges of the boundary",
            found=found,
        )
    return runs[0]


def _match_cuts(
    nodes: NDArray[np.float64],
    cuts: list[NDArray[np.int64]],
    spec: MeshBody,
    path: Path,
    key: str,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Left and right cut in matching order: the right one is the left one turned by one pitch."""
    first, second = cuts
    size = float(np.abs(nodes).max())
    if first.size != second.size or not first.size:
        raise MeshError(
            file=path,
            key=f"{key}.cut_sets",
            expected="cut faces with the same number of nodes",
            found=f"{first.size} and {second.size}",
        )
    best = np.inf
    for left, right in ((first, second), (second, first)):
        pitch = 2 * np.pi / spec.teeth
        turn = np.array([[np.cos(pitch), np.sin(pitch)], [-np.sin(pitch), np.cos(pitch)]])
        turned = nodes[left] @ turn
        distance = np.linalg.norm(turned[:, None] - nodes[right][None], axis=2)
        nearest = distance.argmin(axis=1)
        worst = float(distance.min(axis=1).max())
        best = min(best, worst)
        if worst <= CUT_TOLERANCE * size and np.unique(nearest).size == left.size:
            return left, right[nearest]
    raise MeshError(
        file=path,
        key=f"{key}.cut_sets",
        expected=f"cut faces that match when turned by 360/{spec.teeth} deg (to "
        f"{CUT_TOLERANCE * size:.1g} mm)",
        found=f"nodes up to {best:.3g} mm apart",
    )


def _fit_profile(
    spec: MeshBody, key: str, sector: _Sector
) -> tuple[FlankCurve, Involute, NDArray[np.float64], tuple[float, float], str]:
    """The exact profile, turned so that it fits the flank's nodes (least squares)."""
    given = spec.profile
    assert given is not None
    profile = gear_profile(given, f"{key}.profile", teeth=spec.teeth)
    points = sector.nodes[sector.flank_nodes]
    curve = profile.curve
    angles = np.arctan2(points[:, 1], points[:, 0])
    radii = np.hypot(points[:, 0], points[:, 1])
    inside = np.clip(radii, profile.involute.form_radius_mm, profile.involute.tip_radius_mm)
    turn = float(np.median(angles - [profile.involute.polar_angle_at(radius) for radius in inside]))
    for _ in range(8):
        s, distance = curve.rotated(turn).arc_length_of(points)
        # a curve turned by d moves by d (P . t) along its normal: Gauss-Newton
        lever = np.sum(curve.point(s) * curve.tangent(s), axis=1)
        step = float(lever @ distance / (lever @ lever))
        turn += step
        if abs(step) < 1e-16:
            break
    curve = curve.rotated(turn)
    s, distance = curve.arc_length_of(points)
    worst = float(np.abs(distance).max())
    if worst > PROFILE_TOLERANCE * given.module_mm:
        raise SceneError(
            key=f"{key}.profile",
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
    return curve, involute, s, (low, high), note


def _consecutive(edges: NDArray[np.int64]) -> NDArray[np.int64]:
    """Nodes of the longest run of edges in order."""
    run = max(chain(edges), key=len)
    return np.append(run[:, [0, 2]].ravel(), run[-1, 1])
