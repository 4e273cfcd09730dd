"""Mesh files, in and out: the only room that knows meshio.

What comes out of `read_mesh` is plain: nodes, element blocks, and named sets of nodes. Names come
from gmsh's physical groups, from node and element sets, and from integer 0/1 point data (VTU has no
sets).
"""

from __future__ import annotations

import contextlib
import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import MeshError
from flankload.plane_mesh import boundary_edges, raise_to_quadratic

if TYPE_CHECKING:
    from collections.abc import Mapping

    import meshio
    from numpy.typing import NDArray

    from flankload.bodies.body import SectorMesh

#: Plane elements that can be read; linear ones are raised to quadratic by the body.
PLANE_CELLS = ("triangle", "triangle6", "quad", "quad8", "quad9")
#: Cells that carry names only.
LOWER_CELLS = ("vertex", "line", "line3")
#: Nodes may stand this far out of the plane, relative to the size of the mesh.
PLANE_TOLERANCE = 1e-9

#: meshio's name of the format, by suffix.
WRITERS = {".msh": "gmsh22", ".vtu": "vtu"}


@dataclass(frozen=True)
class RawMesh:
    """A plane mesh as its file has it.

    Attributes
    ----------
    nodes : (N, 2) array
        mm. Nodes that no element uses are dropped.
    cells : ((kind, (E, k) array), ...)
        Element blocks in meshio's names and node order.
    sets : dict of str to array
        Nodes of each named set, ascending.
    """

    nodes: NDArray[np.float64]
    cells: tuple[tuple[str, NDArray[np.int64]], ...]
    sets: Mapping[str, NDArray[np.int64]]


def is_mesh_name(path: Path) -> bool:
    """Whether a file is a mesh, as its name says."""
    if path.suffix.lower() in ("", ".toml"):
        return False
    import meshio

    return path.suffix.lower() in meshio.extension_to_filetypes


def read_mesh(path: str | Path, key: str = "") -> RawMesh:
    """Read a plane mesh with its named sets.

    Parameters
    ----------
    path : path
        Any format meshio reads: gmsh .msh, Abaqus .inp, .vtu …
    key : str
        The scene's key that names the file, for error messages.

    Returns
    -------
    RawMesh

    Raises
    ------
    MeshError
        If the file is missing, cannot be read, or is no plane mesh of triangles and quadrilaterals.
    """
    path = Path(path)
    if not path.is_file():
        found = "a folder" if path.is_dir() else "no such file"
        raise MeshError(file=path, key=key, expected="a mesh file", found=found)
    raw = _read_with_meshio(path, key)
    kinds = [block.type for block in raw.cells]
    strange = sorted({kind for kind in kinds if kind not in PLANE_CELLS + LOWER_CELLS})
    if strange or not any(kind in PLANE_CELLS for kind in kinds):
        raise MeshError(
            file=path,
            key=key,
            expected="plane elements (" + ", ".join(PLANE_CELLS) + ")",
            found=", ".join(strange or sorted(set(kinds))) or "no elements",
        )
    points = np.asarray(raw.points, dtype=float)
    size = float(np.ptp(points, axis=0).max())
    if points.shape[1] == 3 and np.ptp(points[:, 2]) > PLANE_TOLERANCE * size:
        raise MeshError(
            file=path,
            key=key,
            expected="all nodes in one plane z = const",
            found=f"z from {points[:, 2].min():g} to {points[:, 2].max():g}",
        )
    cells = [
        (b.type, np.asarray(b.data, dtype=np.int64)) for b in raw.cells if b.type in PLANE_CELLS
    ]
    used = np.unique(np.concatenate([data.ravel() for _, data in cells]))
    new_number = np.full(len(points), -1)
    new_number[used] = np.arange(used.size)
    sets = {}
    for name, members in _named_nodes(raw).items():
        kept = new_number[members]
        sets[name] = np.unique(kept[kept >= 0])
    return RawMesh(
        nodes=points[used, :2].copy(),
        cells=tuple((kind, new_number[data]) for kind, data in cells),
        sets=sets,
    )


def _read_with_meshio(path: Path, key: str) -> meshio.Mesh:
    """Read a file; whatever way meshio reports trouble (SystemExit, prints), one error."""
    import meshio

    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            return meshio.read(path)
    except (Exception, SystemExit) as error:
        reason = "a file that meshio cannot read"
        if detail := " ".join(str(error).split()) if isinstance(error, Exception) else "":
            reason += f" ({detail})"
        raise MeshError(
            file=path, key=key, expected="a readable mesh file", found=reason[:200]
        ) from None


def _named_nodes(raw: meshio.Mesh) -> dict[str, NDArray[np.int64]]:
    """Nodes of every named set, whatever way the format names them."""
    found: dict[str, list[NDArray[np.int64]]] = {}

    def add(name: str, nodes: NDArray[np.int64]) -> None:
        found.setdefault(name, []).append(np.asarray(nodes, dtype=np.int64).ravel())

    for name, nodes in raw.point_sets.items():
        add(name, nodes)
    for name, blocks in raw.cell_sets.items():
        for block, members in zip(raw.cells, blocks, strict=True):
            if members is not None and len(members):
                add(name, block.data[np.asarray(members, dtype=np.int64)])
    physical = raw.cell_data.get("gmsh:physical")
    if physical is not None:
        names = {(int(tag), int(dim)): name for name, (tag, dim) in raw.field_data.items()}
        for block, tags in zip(raw.cells, physical, strict=True):
            for tag in np.unique(tags):
                name = names.get((int(tag), block.dim))
                if name is not None:
                    add(name, block.data[np.asarray(tags) == tag])
    for name, values in raw.point_data.items():
        values = np.asarray(values)
        if values.ndim == 1 and values.dtype.kind in "iub" and set(np.unique(values)) <= {0, 1}:
            add(name, np.flatnonzero(values))
    return {name: np.unique(np.concatenate(parts)) for name, parts in found.items()}


def write_sector(path: str | Path, mesh: SectorMesh, *, turn_rad: float = 0.0) -> None:
    """Write a sector with the named sets BODY, FLANK, BORE, CUT_LEFT and CUT_RIGHT.

    Parameters
    ----------
    path : path
        Its suffix decides the format: .msh (gmsh 2.2, sets as physical groups) or .vtu (sets as 0/1
        point data).
    mesh : SectorMesh
    turn_rad : float
        The nodes are turned by this angle about the axis first: the file then stands as the body
        stands at position zero.

    Raises
    ------
    MeshError
        If the suffix is not known.
    """
    import meshio

    path = Path(path)
    if path.suffix not in WRITERS:
        raise MeshError(
            file=path, key="", expected=" or ".join(WRITERS), found=path.suffix or "no suffix"
        )
    cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
    turned = mesh.nodes @ np.array([[cosine, sine], [-sine, cosine]])
    points = np.column_stack([turned, np.zeros(len(turned))])
    edges = {
        "FLANK": mesh.flank_edges,
        "BORE": _edges_among(mesh, mesh.fixed_nodes),
        "CUT_LEFT": _edges_among(
            mesh, np.union1d(mesh.left_nodes, mesh.fixed_nodes), mesh.left_nodes
        ),
        "CUT_RIGHT": _edges_among(
            mesh, np.union1d(mesh.right_nodes, mesh.fixed_nodes), mesh.right_nodes
        ),
    }
    if path.suffix == ".vtu":
        out = meshio.Mesh(points, list(mesh.cells))
        for name, members in edges.items():
            marks = np.zeros(len(points), dtype=np.int32)
            marks[members] = 1
            out.point_data[name] = marks
    else:
        blocks = [*mesh.cells, *(("line3", members) for members in edges.values())]
        tags = [1] * len(mesh.cells) + list(range(2, 2 + len(edges)))
        marks_of = [np.full(len(data), tag) for (_, data), tag in zip(blocks, tags, strict=True)]
        out = meshio.Mesh(
            points,
            blocks,
            cell_data={"gmsh:physical": marks_of, "gmsh:geometrical": marks_of},
            field_data={
                "BODY": np.array([1, 2]),
                **{name: np.array([tag, 1]) for tag, name in enumerate(edges, start=2)},
            },
        )
    temporary = path.with_name(f".flankload.{os.getpid()}{path.suffix}")
    try:
        options = {"binary": False} if path.suffix == ".msh" else {}
        meshio.write(temporary, out, file_format=WRITERS[path.suffix], **options)
        os.replace(temporary, path)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
    finally:
        temporary.unlink(missing_ok=True)


def _edges_among(
    mesh: SectorMesh, members: NDArray[np.int64], touching: NDArray[np.int64] | None = None
) -> NDArray[np.int64]:
    """Boundary edges all of whose nodes are members, and whose middle is one of `touching`."""
    _, cells = raise_to_quadratic(mesh.nodes, mesh.cells)
    edges = boundary_edges(cells)
    chosen = np.isin(edges, members).all(axis=1)
    if touching is not None:
        chosen &= np.isin(edges[:, 2], touching)
    return edges[chosen]
