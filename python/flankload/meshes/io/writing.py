"""Writing of plane meshes."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.files import write_atomically
from flankload.errors import MeshError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import meshio
    from numpy.typing import NDArray

    from flankload.base.arrays import Floats, Numbers


#: Suffixes that can be written.
WRITERS = (".msh", ".vtu", ".inp")
#: Names of plane-strain elements in Abaqus, and number of nodes without the centre node.
ABAQUS_TYPES = {"triangle6": ("CPE6", 6), "quad8": ("CPE8", 8), "quad9": ("CPE8", 8)}


def write_mesh(
    path: str | Path,
    nodes: Floats,
    cells: tuple[tuple[str, Numbers], ...],
    edge_sets: Mapping[str, Numbers],
    regions: Sequence[str] = (),
) -> None:
    """Write a plane mesh of quadratic elements with named sets of edges and of elements.

    Parameters
    ----------
    path : path
        Its suffix selects the format: .msh (gmsh 2.2, sets as physical groups), .vtu (sets as 0/1
        point data) or .inp (Abaqus, node sets; without centre nodes, which are restored on
        reading).
    nodes : (N, 2) array
        mm.
    cells : ((kind, (E, k) array), ...)
    edge_sets : mapping of str to (m, 3) array
        First, last and middle node of each edge.
    regions : sequence of str, optional
        Name of the element set of each entry of `cells`, "" for BODY: physical group in .msh, 0/1
        cell data in .vtu, element set in .inp.

    Raises
    ------
    MeshError
        If the suffix is unknown.
    """
    path = Path(path)
    if path.suffix not in WRITERS:
        raise MeshError(
            file=path, key="", expected=" or ".join(WRITERS), found=path.suffix or "no suffix"
        )
    points = np.column_stack([nodes, np.zeros(len(nodes))])
    if path.suffix == ".inp":
        content = _abaqus_text(points, cells, edge_sets, regions).encode("ascii")
    else:
        content = _by_meshio(path.suffix, points, cells, edge_sets, regions)
    write_atomically(path, content)


def _by_meshio(
    suffix: str,
    points: Floats,
    cells: tuple[tuple[str, Numbers], ...],
    edges: Mapping[str, Numbers],
    regions: Sequence[str],
) -> bytes:
    """Content of a .vtu or .msh file."""
    import meshio

    if suffix == ".vtu":
        out = meshio.Mesh(points, list(cells))
        for name, members in edges.items():
            marks = np.zeros(len(points), dtype=np.int32)
            marks[members] = 1
            out.point_data[name] = marks
        for name in dict.fromkeys(filter(None, regions)):
            out.cell_data[name] = [
                np.full(len(data), own == name, dtype=np.int32)
                for (_, data), own in zip(cells, regions, strict=True)
            ]
        options: dict[str, Any] = {"file_format": "vtu"}
    else:
        out = _gmsh_mesh(points, cells, edges, regions)
        options = {"file_format": "gmsh22", "binary": False}
    return _content(out, suffix, options)


def _content(mesh: meshio.Mesh, suffix: str, options: Mapping[str, Any]) -> bytes:
    """Content of a file by way of a temporary file, since meshio has no other output."""
    import meshio

    with TemporaryDirectory(prefix="flankload_") as folder:
        file = Path(folder) / f"mesh{suffix}"
        meshio.write(file, mesh, **options)
        return file.read_bytes()


def vtu_of(
    points: Floats,
    cells: Sequence[tuple[str, Numbers]],
    point_data: Mapping[str, NDArray[Any]],
    cell_data: Mapping[str, Sequence[NDArray[Any]]] | None = None,
) -> bytes:
    """Content of a binary, compressed .vtu file with fields.

    Points (N, 3), cells with names and node order of meshio, fields (N, …) by name, and fields
    (E, …) by name for each entry of `cells`.
    """
    import meshio

    mesh = meshio.Mesh(points, list(cells), point_data=point_data, cell_data=cell_data)
    return _content(mesh, ".vtu", {"file_format": "vtu", "binary": True, "compression": "zlib"})


def _gmsh_mesh(
    points: Floats,
    cells: tuple[tuple[str, Numbers], ...],
    edges: Mapping[str, Numbers],
    regions: Sequence[str],
) -> meshio.Mesh:
    import meshio

    blocks = [*cells, *(("line3", members) for members in edges.values())]
    tags = {"": 1} | {name: 2 + k for k, name in enumerate([*edges, *filter(None, regions)])}
    own = [tags[name] for name in (*(regions or [""] * len(cells)), *edges)]
    marks = [np.full(len(data), tag) for (_, data), tag in zip(blocks, own, strict=True)]
    names = {"BODY": np.array([1, 2])}
    names |= {name: np.array([tags[name], 1]) for name in edges}
    names |= {name: np.array([tags[name], 2]) for name in filter(None, regions)}
    return meshio.Mesh(
        points,
        blocks,
        cell_data={"gmsh:physical": marks, "gmsh:geometrical": marks},
        field_data=names,
    )


def _abaqus_text(
    points: Floats,
    cells: tuple[tuple[str, Numbers], ...],
    edges: Mapping[str, Numbers],
    regions: Sequence[str],
) -> str:
    """Content of an .inp file; elements without a region are in the set BODY."""
    kept = [(*ABAQUS_TYPES[kind], data) for kind, data in cells]
    used = np.unique(np.concatenate([data[:, :size].ravel() for _, size, data in kept]))
    lines = ["** coordinates in mm", "*NODE"]
    lines += [f"{k + 1}, {float(points[k, 0])!r}, {float(points[k, 1])!r}" for k in used.tolist()]
    number = 0
    for (name, size, data), region in zip(kept, regions or [""] * len(cells), strict=True):
        lines.append(f"*ELEMENT, TYPE={name}, ELSET={region or 'BODY'}")
        for row in (data[:, :size] + 1).tolist():
            number += 1
            lines.append(", ".join(map(str, [number, *row])))
    for name, members in edges.items():
        nodes = (np.unique(members) + 1).tolist()
        lines.append(f"*NSET, NSET={name}")
        lines += [", ".join(map(str, nodes[k : k + 12])) for k in range(0, len(nodes), 12)]
    return "\n".join(lines) + "\n"
