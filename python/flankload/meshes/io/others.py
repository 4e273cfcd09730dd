"""Reading of other formats with meshio; sets are those of meshio, or 0/1 arrays."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.files import LARGEST_TABLE
from flankload.meshes.io.file_mesh import PLANE_CELLS, BadFile, FileMesh

if TYPE_CHECKING:
    import meshio
    from numpy.typing import NDArray

#: Names of cell arrays with material numbers, in lower case.
MATERIAL_ARRAYS = ("material", "materials", "material_id", "material_ids", "materialid",
                   "materialids", "mat", "mat_id", "matid")  # fmt: skip


def known_to_meshio(suffix: str) -> bool:
    """Whether meshio has a reader for a suffix."""
    import meshio

    return suffix in meshio.extension_to_filetypes


def read_with_meshio(path: Path) -> FileMesh:
    """Read a file with meshio.

    Raises
    ------
    BadFile
        For any failure of meshio, including SystemExit.
    """
    import meshio

    if path.stat().st_size > LARGEST_TABLE:
        raise BadFile(f"at most {LARGEST_TABLE / 1e6:g} million bytes", "a larger file")
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            raw = meshio.read(path)
    except (Exception, SystemExit) as error:
        reason = "a file that meshio cannot read"
        if detail := " ".join(str(error).split()) if isinstance(error, Exception) else "":
            reason += f" ({detail})"
        raise BadFile("a readable mesh file", reason[:200]) from None
    mesh = FileMesh(np.asarray(raw.points, dtype=float))
    mesh.blocks = [(block.type, np.asarray(block.data, dtype=np.int64)) for block in raw.cells]
    _add_sets(mesh, raw)
    mesh.materials = _materials(raw)
    return mesh


def _add_sets(mesh: FileMesh, raw: meshio.Mesh) -> None:
    for name, nodes in raw.point_sets.items():
        mesh.add_to_set(name, nodes)
    for name, blocks in raw.cell_sets.items():
        if name.startswith("gmsh:"):
            continue
        for block, members in zip(raw.cells, blocks, strict=True):
            if members is not None and len(members):
                mesh.add_to_set(name, block.data[np.asarray(members, dtype=np.int64)])
    for name, values in raw.point_data.items():
        if _are_marks([values]):
            mesh.add_to_set(name, np.flatnonzero(values))
    for name, parts in raw.cell_data.items():
        if name.startswith("gmsh:") or name.lower() in MATERIAL_ARRAYS or not _are_marks(parts):
            continue
        for block, values in zip(raw.cells, parts, strict=True):
            mesh.add_to_set(name, block.data[np.flatnonzero(values)])


def _are_marks(parts: list[Any]) -> bool:
    """Whether an array contains only 0 and 1, and at least one 1."""
    if any(np.asarray(part).ndim != 1 for part in parts):
        return False
    values = set(np.unique(np.concatenate([np.asarray(part) for part in parts])).tolist())
    return values <= {0, 1} and 1 in values


def _materials(raw: meshio.Mesh) -> dict[str, int]:
    for name, parts in raw.cell_data.items():
        if name.lower() in MATERIAL_ARRAYS:
            values: NDArray[Any] = np.concatenate(
                [
                    np.asarray(part).reshape(len(block.data), -1)[:, 0]
                    for block, part in zip(raw.cells, parts, strict=True)
                    if block.type in PLANE_CELLS
                ]
                or [np.empty(0)]
            )
            kinds, counts = np.unique(values, return_counts=True)
            return {
                f"{name} {kind:g}": int(count) for kind, count in zip(kinds, counts, strict=True)
            }
    return {}
