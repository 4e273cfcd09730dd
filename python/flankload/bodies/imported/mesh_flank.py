"""The flank of a body from a mesh: its ordered edges on the boundary.

A flank runs from root to tip with the material on its right.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.meshes.plane_mesh import chain

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.imported.mesh_source import MeshSource

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Largest angle between neighbouring edges of a flank, degrees; a larger one is a corner.
LARGEST_BEND_DEG = 40.0
#: Middle nodes count as lying on their chords if their distance is less than this part of the
#: distance expected from the corner nodes.
STRAIGHT = 0.05
#: A flank is straight if its curve leaves the chords by less than this part of their length.
FLAT = 1e-5


def flank_edges(source: MeshSource, key: str, name: str) -> Numbers:
    """Boundary edges of a flank in order, with the material on their right.

    Parameters
    ----------
    source : MeshSource
    key : str
        Key that names the set, without the body's.
    name : str
        Name of the set.

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
            f"set {name!r} to be a smooth flank (its own edges or nodes alone)",
            f"a corner of {bends.max():.0f} deg at x = {x:.4f}, y = {y:.4f} mm",
        )
    return run


def in_order(edges: Numbers) -> Numbers:
    """Nodes of consecutive edges in order, including middle nodes: (2 m + 1,)."""
    return np.append(edges[:, [0, 2]].ravel(), edges[-1, 1])


def faces_clockwise(nodes: Floats, edges: Numbers, *, inwards: bool) -> bool:
    """Whether a flank is that of the mirrored body.

    Such a flank runs from tip to root with the material on its right. The radius decreases towards
    the tip of internal teeth.
    """
    middle = nodes[edges[len(edges) // 2]]
    return (float(middle.mean(axis=0) @ (middle[1] - middle[0])) < 0.0) != inwards


def middles_are_straight(nodes: Floats, edges: Numbers) -> bool:
    """Whether a flank is curved although its middle nodes lie on the chords of its edges."""
    first, last, middle = (nodes[edges[:, k]] for k in range(3))
    chord = last - first
    length = np.linalg.norm(chord, axis=1)
    away = middle - 0.5 * (first + last)
    out = np.abs(chord[:, 0] * away[:, 1] - chord[:, 1] * away[:, 0]) / length
    angles = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    # the distance of an arc of length h and angle t from its chord is h t/8
    turn = np.abs(np.gradient(angles)) if len(angles) > 1 else np.zeros(1)
    wanted = length * turn / 8
    return bool(wanted.sum() > FLAT * length.sum() and out.sum() < STRAIGHT * wanted.sum())
