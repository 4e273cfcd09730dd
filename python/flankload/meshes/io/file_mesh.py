"""Content of a mesh file, as read and as a plane mesh for other packages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flankload.base.arrays import Floats, Numbers

#: Supported plane elements.
PLANE_CELLS = ("triangle", "triangle6", "quad", "quad8", "quad9")
#: Cells that only define sets.
LOWER_CELLS = ("vertex", "line", "line3")


class BadFile(Exception):  # noqa: N818 - becomes a MeshError where file and key are known
    """An error in a file, with the expected and the found content."""

    def __init__(self, expected: str, found: str) -> None:
        super().__init__(expected, found)
        self.expected = expected
        self.found = found


@dataclass
class FileMesh:
    """A mesh file during reading.

    Attributes
    ----------
    points : (N, 2) or (N, 3) array
    blocks : list of (kind, (E, k) array)
        All elements, with names and node order of meshio.
    sets : dict of str to list of arrays
        Nodes of each named set, in any order and with repetitions.
    materials, elastic, notes
        As in `RawMesh`.
    """

    points: Floats
    blocks: list[tuple[str, Numbers]] = field(default_factory=list)
    sets: dict[str, list[Numbers]] = field(default_factory=dict)
    materials: dict[str, int] = field(default_factory=dict)
    elastic: tuple[float, float] | None = None
    notes: list[str] = field(default_factory=list)

    def add_to_set(self, name: str, nodes: Numbers) -> None:
        """Add nodes to a named set."""
        self.sets.setdefault(name, []).append(np.asarray(nodes, dtype=np.int64).ravel())


@dataclass(frozen=True)
class RawMesh:
    """The plane mesh of a file.

    Attributes
    ----------
    file : Path
    nodes : (N, 2) array
        mm; without nodes that belong to no element.
    cells : ((kind, (E, k) array), ...)
        Blocks of elements, with names and node order of meshio.
    sets : dict of str to array
        Nodes of each named set, ascending.
    materials : dict of str to int
        Number of elements of each material, or of each group that may be a material.
    elastic : (float, float) or None
        Young's modulus and Poisson's ratio, if the file has exactly one material.
    notes : tuple of str
        Remarks for the user on how the file was read.
    """

    file: Path
    nodes: Floats
    cells: tuple[tuple[str, Numbers], ...]
    sets: Mapping[str, Numbers]
    materials: Mapping[str, int] = field(default_factory=dict)
    elastic: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()

    def set_name(self, wanted: str) -> str | None:
        """Name of a set as in the file: an exact match, or the only one that differs by case."""
        if wanted in self.sets:
            return wanted
        alike = [name for name in self.sets if name.casefold() == wanted.casefold()]
        return alike[0] if len(alike) == 1 else None


def disjoint_groups(groups: Mapping[str, Numbers], count: int) -> dict[str, int]:
    """Sizes of element groups that may be materials.

    Empty if groups overlap or one contains all elements, whose number is `count`.
    """
    members = {name: np.unique(elements) for name, elements in groups.items() if elements.size}
    whole = any(elements.size == count for elements in members.values())
    every = np.concatenate(list(members.values())) if members else np.empty(0, dtype=np.int64)
    if whole or np.unique(every).size < every.size:
        return {}
    return {name: int(elements.size) for name, elements in members.items()}
