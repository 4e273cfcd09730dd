"""Reading of .msh files (gmsh), versions 2.2 and 4.1, text or binary.

The nodes of a physical group become a named set; a group without a name is named by its dimension
and number ("line 2").
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from flankload.base.arrays import Numbers
from flankload.base.files import LARGEST_TABLE, read_file
from flankload.meshes.io.file_mesh import BadFile, FileMesh, disjoint_groups

Number = TypeVar("Number", int, float)
#: Types of numbers in a file.
INT, SIZE, REAL = "i4", "u8", "f8"
#: Element type number in gmsh → name in meshio and number of nodes.
ELEMENTS = {
    1: ("line", 2), 2: ("triangle", 3), 3: ("quad", 4), 4: ("tetra", 4),
    5: ("hexahedron", 8), 6: ("wedge", 6), 7: ("pyramid", 5), 8: ("line3", 3),
    9: ("triangle6", 6), 10: ("quad9", 9), 11: ("tetra10", 10), 12: ("hexahedron27", 27),
    13: ("wedge18", 18), 14: ("pyramid14", 14), 15: ("vertex", 1), 16: ("quad8", 8),
    17: ("hexahedron20", 20), 18: ("wedge15", 15), 19: ("pyramid13", 13),
}  # fmt: skip
DIMENSION_NAMES = ("point", "line", "surface", "volume")

#: A line of $PhysicalNames.
NAME = re.compile(r'([0-3])\s+(\d{1,9})\s+"(.*)"')


def read_gmsh(path: Path) -> FileMesh:
    """Read a .msh file.

    Raises
    ------
    BadFile
        If it is not a gmsh file, or is truncated.
    """
    return _Reader(Stream(read_file(path, LARGEST_TABLE))).read()


class _Reader:
    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._names: dict[tuple[int, int], str] = {}
        self._groups_of: dict[tuple[int, int], list[int]] = {}
        #: node numbers, ascending, and their positions in the file
        self._tags = self._order = np.empty(0, dtype=np.int64)
        self._points = np.empty((0, 3))
        #: elements: (kind, nodes (E, k), groups as (dimension, number)), with numbers of the file
        self._found: list[tuple[str, Numbers, list[tuple[int, int]]]] = []

    def read(self) -> FileMesh:
        stream = self._stream
        version = 0.0
        while section := stream.next_section():
            if section == "MeshFormat":
                version = self._read_format()
            elif not version:
                break
            elif section == "PhysicalNames":
                self._read_names(stream.lines())
            elif section == "Entities" and version > 4:
                self._numbers(self._read_entities)
            elif section == "Nodes":
                self._numbers(self._read_nodes if version > 4 else self._read_nodes_2)
            elif section == "Elements":
                self._numbers(self._read_elements if version > 4 else self._read_elements_2)
            else:
                stream.close_numbers()
        if not version:
            raise BadFile("a readable mesh file", "a file that is no gmsh mesh")
        if not len(self._points) or not self._found:
            missing = "$Nodes" if not len(self._points) else "$Elements"
            raise BadFile("a readable mesh file", f"no section {missing}")
        return self._file_mesh()

    def _numbers(self, read: Any) -> None:
        self._stream.open_numbers()
        read()
        self._stream.close_numbers()

    def _read_format(self) -> float:
        line = self._stream.lines()
        words = line[0].split() if line else []
        if len(words) < 3 or words[0] not in ("2", "2.1", "2.2", "4.1") or words[2] != "8":
            raise BadFile(
                "a gmsh mesh of version 2.2 or 4.1", f"version {' '.join(words) or 'none'}"
            )
        self._stream.text = words[1] == "0"
        return float(words[0])

    def _read_names(self, lines: list[str]) -> None:
        for line in lines[1:]:
            parts = NAME.fullmatch(line.strip())
            if parts is None:
                raise BadFile('dimension, number and "name" in $PhysicalNames', f"{line[:40]!r}")
            self._names[int(parts[1]), int(parts[2])] = parts[3]

    def _group_name(self, group: tuple[int, int]) -> str:
        dimension, number = group
        return self._names.get(group, f"{DIMENSION_NAMES[dimension]} {number}")

    # --- version 4.1 ------------------------------------------------------------------------------
    def _read_entities(self) -> None:
        stream = self._stream
        for dimension, count in enumerate(stream.read(SIZE, 4)):
            for _ in range(int(count)):
                entity = stream.one(INT)
                stream.read(REAL, 3 if dimension == 0 else 6)
                groups = stream.read(INT, stream.one(SIZE))
                self._groups_of[dimension, entity] = [int(group) for group in groups]
                if dimension:
                    stream.read(INT, stream.one(SIZE))

    def _read_nodes(self) -> None:
        stream = self._stream
        blocks = int(stream.read(SIZE, 4)[0])
        tags, points = [], []
        for _ in range(blocks):
            dimension, _, parametric = (int(word) for word in stream.read(INT, 3))
            count = stream.one(SIZE)
            tags.append(stream.read(SIZE, count).astype(np.int64))
            width = 3 + (dimension if parametric else 0)
            points.append(stream.read(REAL, width * count).reshape(count, width)[:, :3])
        if tags:
            self._keep_nodes(np.concatenate(tags), np.vstack(points))

    def _read_elements(self) -> None:
        stream = self._stream
        for _ in range(int(stream.read(SIZE, 4)[0])):
            dimension, entity, number = (int(word) for word in stream.read(INT, 3))
            kind, size = _element(number)
            count = stream.one(SIZE)
            data = stream.read(SIZE, count * (1 + size)).reshape(count, 1 + size)
            groups = self._groups_of.get((dimension, entity), [])
            # negative numbers of groups mean the reverse direction
            named = [(dimension, abs(group)) for group in groups]
            self._found.append((kind, data[:, 1:].astype(np.int64), named))

    # --- version 2.2 ------------------------------------------------------------------------------
    def _read_nodes_2(self) -> None:
        stream = self._stream
        if stream.text:
            count = stream.one(INT)
            table = stream.read(REAL, 4 * count).reshape(count, 4)
            numbers = table[:, 0]
            if not ((np.abs(numbers) < 2**53) & (numbers == np.round(numbers))).all():
                raise BadFile("node numbers", "a number that is not an integer")
            self._keep_nodes(table[:, 0].astype(np.int64), table[:, 1:])
            return
        count = stream.count_line()
        records = stream.read("u1", 28 * count).reshape(count, 28)
        points = np.ascontiguousarray(records[:, 4:]).view(REAL)
        self._keep_nodes(np.ascontiguousarray(records[:, :4]).view(INT)[:, 0], points)

    def _read_elements_2(self) -> None:
        stream = self._stream
        count = stream.one(INT) if stream.text else stream.count_line()
        by_group: dict[tuple[str, int, int], list[Any]] = {}
        while count > 0:
            # a header per element in text, per sequence of elements of one type in binary files
            if stream.text:
                _, number, n_tags = stream.whole(3)
                kind, size = _element(number)
                rows: Any = [stream.whole(n_tags + size)]
            else:
                number, together, n_tags = (int(word) for word in stream.read(INT, 3))
                kind, size = _element(number)
                width = n_tags + size + 1
                rows = stream.read(INT, width * together).reshape(together, width)[:, 1:]
            count -= len(rows)
            for row in rows:
                group = abs(int(row[0])) if n_tags else 0
                by_group.setdefault((kind, _dimension(kind), group), []).append(row[n_tags:])
        for (kind, dimension, group), members in by_group.items():
            nodes = np.array(members, dtype=np.int64)
            self._found.append((kind, nodes, [(dimension, group)] if group else []))

    # --- common to both versions ------------------------------------------------------------------
    def _keep_nodes(self, tags: Numbers, points: Any) -> None:
        order = np.argsort(tags, kind="stable")
        self._tags, self._order = np.asarray(tags, dtype=np.int64)[order], order
        self._points = np.array(points, dtype=float)

    def _places(self, tags: Numbers) -> Numbers:
        at = np.searchsorted(self._tags, tags)
        at[at == self._tags.size] = 0
        if (unknown := self._tags[at] != tags).any():
            raise BadFile("elements on nodes that the file has", f"node {tags[unknown][0]}")
        return np.asarray(self._order[at], dtype=np.int64)

    def _file_mesh(self) -> FileMesh:
        mesh = FileMesh(self._points)
        surfaces: dict[str, list[Numbers]] = {}
        count = 0
        known: dict[tuple[int, ...], int] = {}
        for kind, tags, groups in self._found:
            nodes = self._places(tags)
            for group in groups:
                mesh.add_to_set(self._group_name(group), nodes)
            if _dimension(kind) != 2:
                mesh.blocks.append((kind, nodes))
                continue
            # in version 2.2, an element is repeated for each of its groups
            numbers, new = [], []
            for row, key in enumerate(map(tuple, np.sort(nodes, axis=1).tolist())):
                repeated = key in known and bool(groups)
                if not repeated:
                    known[key] = count
                    count += 1
                    new.append(row)
                numbers.append(known[key])
            mesh.blocks.append((kind, nodes[new]))
            for group in groups:
                surfaces.setdefault(self._group_name(group), []).append(np.array(numbers))
        members = {name: np.concatenate(parts) for name, parts in surfaces.items()}
        mesh.materials = disjoint_groups(members, count)
        return mesh


def _element(number: int) -> tuple[str, int]:
    if number not in ELEMENTS:
        raise BadFile("elements of first or second order", f"gmsh's element type {number}")
    return ELEMENTS[number]


def _dimension(kind: str) -> int:
    if kind.startswith(("line", "vertex")):
        return int(kind != "vertex")
    return 2 if kind.startswith(("triangle", "quad")) else 3


class Stream:
    """Sequential reader of a file of sections, text or binary."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self._at = 0
        self.text = True
        self.section = ""
        self._words: list[bytes] = []
        self._next = 0

    def next_section(self) -> str:
        """Go to the next section and return its name; "" at the end of the file."""
        start = self._content.find(b"$", self._at)
        if start < 0:
            return ""
        self.section = self._line_from(start + 1).decode("ascii", "replace").strip()
        return self.section

    def _line_from(self, start: int) -> bytes:
        end = self._content.find(b"\n", start)
        end = len(self._content) if end < 0 else end
        self._at = min(end + 1, len(self._content))
        return self._content[start:end]

    def lines(self) -> list[str]:
        """Read a section that is always text."""
        body = self._content[self._at : self._end()]
        self._skip()
        return body.decode("utf-8", "replace").strip().splitlines()

    def open_numbers(self) -> None:
        """Begin to read the numbers of the section."""
        if self.text:
            self._words = self._content[self._at : self._end()].split()
            self._next = 0

    def read(self, kind: str, count: int) -> Any:
        """Read the next numbers of the section, (count,)."""
        if self.text:
            if kind == REAL:
                return np.array(self._parsed(float, count), dtype=REAL)
            return np.array(self.whole(count), dtype=np.int64)
        size = np.dtype(kind).itemsize * count
        part = self._content[self._at : self._at + size]
        if len(part) < size:
            raise self._cut_off()
        self._at += size
        return np.frombuffer(part, dtype=kind)

    def whole(self, count: int) -> list[int]:
        """Read the next integers of a text section."""
        return self._parsed(int, count)

    def _parsed(self, number: type[Number], count: int) -> list[Number]:
        """Read the next words of a text section as numbers."""
        words = self._words[self._next : self._next + count]
        self._next += count
        if len(words) < count:
            raise self._cut_off()
        try:
            if any(b"_" in word for word in words):  # Python reads 5_0 as 50
                raise ValueError
            return [number(word) for word in words]
        except ValueError:
            raise BadFile(
                f"numbers in section ${self.section}",
                " ".join(word.decode("ascii", "replace") for word in words[:8]),
            ) from None

    def count_line(self) -> int:
        """Read a number on a separate line of a binary section."""
        line = self._line_from(self._at)
        if not line.strip().isdigit():
            raise self._cut_off()
        return int(line)

    def one(self, kind: str) -> int:
        """Read the next number of the section."""
        return int(self.read(kind, 1)[0])

    def close_numbers(self) -> None:
        """Skip the rest of the section."""
        self._skip()

    def _skip(self) -> None:
        self._at = self._end()
        self._line_from(self._at)

    def _end(self) -> int:
        end = self._content.find(b"$End" + self.section.encode(), self._at)
        if end < 0:
            raise self._cut_off()
        return end

    def _cut_off(self) -> BadFile:
        return BadFile("a readable mesh file", f"section ${self.section}, which is cut off")
