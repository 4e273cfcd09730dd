"""Reading of mesh files of all formats as plane meshes with named sets, with checks."""

from __future__ import annotations

from os.path import isdir, isfile
from pathlib import Path

import numpy as np

from flankload.errors import MeshError, reason_of
from flankload.meshes.io.abaqus import read_abaqus
from flankload.meshes.io.file_mesh import LOWER_CELLS, PLANE_CELLS, BadFile, FileMesh, RawMesh
from flankload.meshes.io.gmsh import read_gmsh
from flankload.meshes.io.others import known_to_meshio, read_with_meshio

#: Largest distance of nodes from the plane, over the size of the mesh.
PLANE_TOLERANCE = 1e-9

#: Largest credible coordinate, mm; larger ones come from a damaged file.
LARGEST_MM = 1e9

READERS = {".msh": read_gmsh, ".inp": read_abaqus}


def is_mesh_name(path: Path) -> bool:
    """Whether the suffix of a file is that of a mesh file."""
    suffix = path.suffix.lower()
    if suffix in ("", ".toml"):
        return False
    return suffix in READERS or known_to_meshio(suffix)


def read_mesh(path: str | Path, key: str = "") -> RawMesh:
    """Read a plane mesh with its named sets.

    The file is gmsh .msh (2.2 or 4.1), Abaqus or CalculiX .inp, .vtu, or another format of meshio;
    `key` is the scene's key of the file, for messages.

    Raises
    ------
    MeshError
        If the file is missing, unreadable, or not a plane mesh of triangles and quadrilaterals.
    """
    path = Path(path)
    try:
        if not isfile(path):  # unlike Path.is_file, without an exception for long names
            raise BadFile("a mesh file", "a folder" if isdir(path) else "no such file")
        found_mesh = READERS.get(path.suffix.lower(), read_with_meshio)(path)
        _check(found_mesh)
        return _plane_mesh(found_mesh, path)
    except BadFile as error:
        expected, found = error.expected, error.found
    except (ValueError, LookupError, OverflowError) as error:
        # inconsistent numbers of a damaged file
        reason = " ".join(str(error).split())[:80]
        expected, found = "a readable mesh file", f"numbers that do not fit together ({reason})"
    except OSError as error:
        expected, found = "a mesh file to read", reason_of(error)
    raise MeshError(file=path, key=key, expected=expected, found=found)


def _check(mesh: FileMesh) -> None:
    """Check that all elements are plane elements and lie in one plane."""
    unsupported: dict[str, int] = {}
    for kind, data in mesh.blocks:
        if kind not in PLANE_CELLS + LOWER_CELLS and len(data):
            unsupported[kind] = unsupported.get(kind, 0) + len(data)
    kinds = {kind for kind, data in mesh.blocks if len(data)}
    if unsupported or not kinds & set(PLANE_CELLS):
        found = ", ".join(f"{count} {kind}" for kind, count in sorted(unsupported.items()))
        raise BadFile(
            "plane elements (" + ", ".join(PLANE_CELLS) + ")",
            found or ", ".join(sorted(kinds)) or "no elements",
        )
    invalid = ~(np.abs(mesh.points) <= LARGEST_MM)
    if invalid.any():
        raise BadFile(f"coordinates up to {LARGEST_MM:g} mm", f"{mesh.points[invalid][0]:g}")
    used = np.unique(np.concatenate([d.ravel() for kind, d in mesh.blocks if kind in PLANE_CELLS]))
    points = mesh.points[used]
    size = float(np.ptp(points, axis=0).max())
    if points.shape[1] == 3 and np.ptp(points[:, 2]) > PLANE_TOLERANCE * size:
        raise BadFile(
            "all nodes in one plane z = const",
            f"z from {points[:, 2].min():g} to {points[:, 2].max():g}",
        )


def _plane_mesh(mesh: FileMesh, path: Path) -> RawMesh:
    """Plane elements with their nodes and sets, renumbered."""
    cells = [(kind, data) for kind, data in mesh.blocks if kind in PLANE_CELLS and len(data)]
    used = np.unique(np.concatenate([data.ravel() for _, data in cells]))
    new_number = np.full(len(mesh.points), -1)
    new_number[used] = np.arange(used.size)
    sets = {}
    for name, parts in mesh.sets.items():
        kept = new_number[np.concatenate(parts)]
        if (kept >= 0).any():
            sets[name] = np.unique(kept[kept >= 0])
    kinds = list(dict.fromkeys(kind for kind, _ in cells))
    return RawMesh(
        file=path,
        nodes=mesh.points[used, :2].copy(),
        cells=tuple(
            (kind, new_number[np.vstack([data for k, data in cells if k == kind])])
            for kind in kinds
        ),
        sets=sets,
        materials=mesh.materials,
        elastic=mesh.elastic,
        notes=tuple(mesh.notes),
    )
