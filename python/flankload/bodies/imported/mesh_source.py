"""The mesh file of a body: sets, flanks, and errors with file and key."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from flankload.base.files import path_of
from flankload.errors import MeshError
from flankload.meshes.defects import PlaneBody, sound_body
from flankload.meshes.io import RawMesh, read_mesh
from flankload.meshes.plane_mesh import REVERSED, chain, circle_through

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.base.arrays import Floats, Numbers
    from flankload.scene import MeshBody


#: Wrong units of meshes, in mm.
UNITS = {"metres": 1000.0, "inches": 25.4, "centimetres": 10.0, "micrometres": 0.001}
#: Largest ratio, in both directions, of the size of a body and its reference radius; with an exact
#: profile, of the two tip radii.
LARGEST_RATIO, LARGEST_TIP_RATIO = 20.0, 3.0
#: Largest distance of the bore's centre from the axis, over the bore's radius.
AXIS_TOLERANCE = 1e-3

#: Largest angle between neighbouring edges of a flank, degrees; a larger one is a corner.
LARGEST_BEND_DEG = 40.0
#: Largest distance of middle nodes from their chords, over that expected from the corner nodes, for
#: straight-sided edges.
STRAIGHT_SIDE_RATIO = 0.05
#: Largest distance of a straight flank from its chords, over their length.
FLATNESS = 1e-5


@dataclass(frozen=True)
class MeshSource:
    """The mesh of a body in standard form, and its source.

    Attributes
    ----------
    spec : MeshBody
    key : str
        "body_1" or "body_2".
    raw : RawMesh
        As in the file.
    body : PlaneBody
        In standard form; after `mirrored`, the mirror image.
    """

    spec: MeshBody
    key: str
    raw: RawMesh
    body: PlaneBody

    def refuse(self, name: str, expected: str, found: str) -> NoReturn:
        """Raise an error for one of the body's keys."""
        raise MeshError(
            file=self.raw.file, key=f"{self.key}.{name}", expected=expected, found=found
        )

    def nodes_of(self, name: str, wanted: str) -> Numbers:
        """Nodes of a named set, and the middle nodes of the boundary edges between them."""
        spelt = self.raw.set_name(wanted)
        if spelt is None or not self.raw.sets[spelt].size:
            self.refuse(
                name,
                f"a set named {wanted!r} in the mesh",
                "the sets " + (", ".join(sorted(self.raw.sets)) or "none at all"),
            )
        members = self.raw.sets[spelt]
        edges = self.body.edges
        whole = np.isin(edges[:, :2], members).all(axis=1)
        return np.union1d(members, edges[whole, 2])

    def mirrored(self) -> MeshSource:
        """The mirror image about the x axis; nodes keep their numbers."""
        cells = tuple((kind, data[:, REVERSED[kind]]) for kind, data in self.body.cells)
        body = replace(
            self.body,
            nodes=self.body.nodes * np.array([1.0, -1.0]),
            cells=cells,
            edges=self.body.edges[:, [1, 0, 2]],
        )
        return replace(self, body=body)


def read_source(spec: MeshBody, key: str, *, folder: Path) -> MeshSource:
    """Read the mesh of a body and convert it to standard form.

    Raises
    ------
    MeshError
        If the file is missing, unreadable, has a defect, or is not in millimetres.
    """
    raw = read_mesh(folder / path_of(spec.file), f"{key}.file")
    one_material = spec.one_material or spec.region_sets is not None
    body = sound_body(raw, f"{key}.file", one_material=one_material)
    source = MeshSource(spec, key, raw, body)
    _check_size(source)
    return source


def _unit_of(ratio: float) -> str | None:
    """Unit with a length in mm close to expected over actual size; None if there is none."""
    name, factor = min(UNITS.items(), key=lambda unit: abs(np.log(unit[1] / ratio)))
    return name if 0.2 < factor / ratio < 5.0 else None


def _check_size(source: MeshSource) -> None:
    """Refuse a mesh of implausible size, for example one in metres."""
    spec = source.spec
    largest = float(np.hypot(*source.raw.nodes.T).max())
    if spec.profile is not None:
        wanted, bound, name = 0.5 * spec.profile.tip_diameter_mm, LARGEST_TIP_RATIO, "tip radius"
    else:
        wanted, bound, name = spec.reference_radius_mm or largest, LARGEST_RATIO, "reference radius"
    ratio = wanted / largest if largest > 0 else np.inf
    if 1 / bound < ratio < bound:
        return
    unit = _unit_of(ratio) if np.isfinite(ratio) else None
    hint = f"; in {unit}? (1 = {UNITS[unit]:g} mm)" if unit else ""
    expected = f"a mesh in millimetres about the origin, to the {name} of {wanted:g} mm"
    source.refuse("file", expected, f"nodes up to radius {largest:.4g}{hint}")


def check_axis(source: MeshSource, fixed: Numbers) -> None:
    """Refuse a body whose fixed nodes are on a circle that is not about the origin."""
    circle = circle_through(source.raw.nodes[fixed[fixed < len(source.raw.nodes)]])
    if circle is None:
        return
    (x, y), radius = circle
    if np.hypot(x, y) > AXIS_TOLERANCE * radius:
        expected = "a body whose axis is the origin"
        source.refuse("file", expected, f"a bore about x = {x:.4f}, y = {y:.4f} mm")


def flank_edges(source: MeshSource, key: str, name: str) -> Numbers:
    """Boundary edges (m, 3) of a flank, in order, from the set `name` of a key.

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
            f"set {name!r} to be a smooth flank (its own edges or nodes alone)",
            f"a corner of {bends.max():.0f} deg at x = {x:.4f}, y = {y:.4f} mm",
        )
    return run


def in_order(edges: Numbers) -> Numbers:
    """Nodes of consecutive edges in order, including middle nodes: (2 m + 1,)."""
    return np.append(edges[:, [0, 2]].ravel(), edges[-1, 1])


def faces_clockwise(nodes: Floats, edges: Numbers, *, inwards: bool) -> bool:
    """Whether a flank with the material on its right runs from tip to root: a mirrored body."""
    middle = nodes[edges[len(edges) // 2]]
    return (float(middle.mean(axis=0) @ (middle[1] - middle[0])) < 0.0) != inwards


def middles_are_straight(nodes: Floats, edges: Numbers) -> bool:
    """Whether the middle nodes of a curved flank lie on the chords of its edges."""
    first, last, middle = (nodes[edges[:, k]] for k in range(3))
    chord = last - first
    length = np.linalg.norm(chord, axis=1)
    away = middle - 0.5 * (first + last)
    out = np.abs(chord[:, 0] * away[:, 1] - chord[:, 1] * away[:, 0]) / length
    angles = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    # the distance of an arc of length h and angle t from its chord is h t/8
    turn = np.abs(np.gradient(angles)) if len(angles) > 1 else np.zeros(1)
    wanted = length * turn / 8
    return bool(
        wanted.sum() > FLATNESS * length.sum() and out.sum() < STRAIGHT_SIDE_RATIO * wanted.sum()
    )
