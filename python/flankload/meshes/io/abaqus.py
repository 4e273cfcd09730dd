"""Reading of .inp files (Abaqus, CalculiX): nodes, plane elements, sets, surfaces, materials.

Keywords and names are case-insensitive. Keywords that create nodes or elements in other ways
(included files, generation, several parts) are refused; all others are skipped.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.files import LARGEST_TABLE, read_file
from flankload.base.number_text import number_of
from flankload.meshes.io.file_mesh import PLANE_CELLS, BadFile, FileMesh

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from flankload.base.arrays import Floats

#: Largest credible number of a node or element; larger ones come from a damaged file.
LARGEST_NUMBER = 10**9
#: Number of nodes → name in meshio, for plane elements.
PLANE_OF = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}
#: Line elements, which only define sets, with their number of nodes.
LINE_ELEMENTS = {"T2D2": 2, "T2D3": 3, "T3D2": 2, "T3D3": 3, "B21": 2, "B22": 3, "B31": 2, "B32": 3}
#: Number of corners, hence of edges S1, S2, …; the middle node of edge k is node corners + k.
EDGE_CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4}
#: Largest credible generated set; larger ones come from a damaged file.
LONGEST_RANGE = 10**7
#: Keywords that create nodes or elements in unsupported ways, with the supported one.
REFUSED = {
    "INCLUDE": "a whole mesh in one file",
    "NGEN": "every node written out",
    "NFILL": "every node written out",
    "NCOPY": "every node written out",
    "NMAP": "every node written out",
    "ELGEN": "every element written out",
    "ELCOPY": "every element written out",
    "SYSTEM": "nodes in one coordinate system",
}


def read_abaqus(path: Path) -> FileMesh:
    """Read an .inp file.

    Raises
    ------
    BadFile
        If it has no mesh, or an unsupported one; names the line.
    """
    reader = _Reader()
    text = read_file(path, LARGEST_TABLE).decode("utf-8", "replace")
    for keyword in keywords(text.splitlines()):
        reader.read_keyword(keyword)
    return reader.file_mesh()


@dataclass
class _Reader:
    """Content read so far, with the numbers of the file; names in upper case."""

    nodes: dict[int, tuple[float, float, float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, tuple[int, ...]]] = field(default_factory=dict)
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[str, str]]] = field(default_factory=dict)
    sections: list[tuple[str, str]] = field(default_factory=list)
    elastic: list[tuple[float, float]] = field(default_factory=list)
    spelling: dict[str, str] = field(default_factory=dict)
    reduced: set[str] = field(default_factory=set)
    parts: int = 0

    def read_keyword(self, keyword: Keyword) -> None:
        """Process a keyword with its data lines."""
        name = keyword.name
        if name in REFUSED:
            raise keyword.refused(REFUSED[name])
        if name in ("NODE", "ELEMENT", "NSET", "ELSET") and "INPUT" in keyword.options:
            raise keyword.refused("a whole mesh in one file")
        match name:
            case "NODE":
                self._read_nodes(keyword)
            case "ELEMENT":
                self._read_elements(keyword)
            case "NSET":
                self._read_node_set(keyword)
            case "ELSET":
                self._read_set(keyword, "ELSET", self.element_sets)
            case "SURFACE":
                self._read_surface(keyword)
            case "SOLID SECTION" | "SOLIDSECTION":
                if material := keyword.options.get("MATERIAL", "").upper():
                    self.sections.append((keyword.options.get("ELSET", "").upper(), material))
            case "ELASTIC" if keyword.data:
                values = keyword.numbers(keyword.data[0])[:2]
                if len(values) == 2:
                    self.elastic.append((values[0], values[1]))
            case "PART":
                self.parts += 1
                if self.parts > 1:
                    raise keyword.refused("one part")
            case "INSTANCE" if keyword.data:
                raise keyword.refused("an instance that is not moved")

    def _name(self, keyword: Keyword, option: str) -> str | None:
        """Name in an option, in upper case; its spelling is stored."""
        given = keyword.options.get(option)
        if not given:
            return None
        self.spelling.setdefault(given.upper(), given)
        return given.upper()

    def _read_nodes(self, keyword: Keyword) -> None:
        numbers = []
        for row, number, place in _nodes_of(keyword):
            if self.nodes.setdefault(number, place) != place:
                raise row.refused(f"node {number} once", "twice, at different places")
            numbers.append(number)
        if name := self._name(keyword, "NSET"):
            self.node_sets.setdefault(name, []).extend(numbers)

    def _read_elements(self, keyword: Keyword) -> None:
        written = keyword.required("TYPE").upper()
        kind, size = self._kind(written)
        numbers = []
        for row, (number, *nodes) in keyword.whole_rows(1 + size):
            if len(nodes) != size:
                raise row.refused(f"{size} nodes of an element {written}", f"{len(nodes)}")
            element = (kind, tuple(nodes))
            if self.elements.setdefault(number, element) != element:
                raise row.refused(f"element {number} once", "twice, with different nodes")
            numbers.append(number)
        if name := self._name(keyword, "ELSET"):
            self.element_sets.setdefault(name, []).extend(numbers)

    def _kind(self, written: str) -> tuple[str, int]:
        """Name in meshio and number of nodes of an element type."""
        if written in LINE_ELEMENTS:
            size = LINE_ELEMENTS[written]
            return ("line" if size == 2 else "line3"), size
        # H (hybrid), I (incompatible modes), M (modified), R (reduced) affect the formulation only
        plain = written.rstrip("HIMRT")
        if plain[:3] in ("CPE", "CPS") and plain[3:].isdigit() and int(plain[3:]) in PLANE_OF:
            if plain != written:
                self.reduced.add(written)
            return PLANE_OF[int(plain[3:])], int(plain[3:])
        raise BadFile("plane elements (CPE3/4/6/8, CPS3/4/6/8)", f"elements {written}")

    def _read_node_set(self, keyword: Keyword) -> None:
        source = self._name(keyword, "ELSET")
        if source is None:
            self._read_set(keyword, "NSET", self.node_sets)
            return
        target = self._name(keyword, "NSET") or ""
        nodes = [n for e in self.element_sets.get(source, []) for n in self.elements[e][1]]
        self.node_sets.setdefault(target, []).extend(nodes)

    def _read_set(self, keyword: Keyword, option: str, sets: dict[str, list[int]]) -> None:
        keyword.required(option)
        members = sets.setdefault(self._name(keyword, option) or "", [])
        for row in keyword.data:
            if "GENERATE" in keyword.options:
                values = keyword.integers(row)
                if len(values) not in (2, 3) or (len(values) == 3 and values[2] <= 0):
                    raise row.refused("first, last and step", row.text)
                if values[1] - values[0] > LONGEST_RANGE:
                    raise row.refused("numbers that the file has", row.text)
                members.extend(range(values[0], values[1] + 1, values[2] if values[2:] else 1))
                continue
            for word in filter(None, row.words):
                if word.isascii() and word.isdigit():
                    members.append(int(word))
                elif word.upper() in sets:
                    members.extend(sets[word.upper()])
                else:
                    raise row.refused(f"numbers or sets of {option}", f"{word!r}")

    def _read_surface(self, keyword: Keyword) -> None:
        kind = keyword.options.get("TYPE", "ELEMENT").upper()
        if kind not in ("ELEMENT", "NODE"):
            return
        name = self._name(keyword, "NAME")
        if name is None:
            raise keyword.refused("a surface with a name")
        rows = self.surfaces.setdefault(name, [])
        for row in keyword.data:
            words = [word.upper() for word in row.words]
            face = words[1] if len(words) > 1 else ""
            rows.append((words[0], "NODE" if kind == "NODE" else face))

    # --- from numbers of the file to node indices -----------------------------------------------
    def file_mesh(self) -> FileMesh:
        """The mesh of the file."""
        if not self.nodes:
            raise BadFile("a readable mesh file", "no *NODE in it")
        place_of = {number: place for place, number in enumerate(self.nodes)}
        mesh = FileMesh(np.array(list(self.nodes.values())))
        by_kind: dict[str, list[tuple[int, ...]]] = {}
        for number, (kind, nodes) in self.elements.items():
            if missing := [node for node in nodes if node not in place_of]:
                raise BadFile(
                    "elements on nodes that the file has", f"node {missing[0]} in element {number}"
                )
            by_kind.setdefault(kind, []).append(tuple(place_of[node] for node in nodes))
        mesh.blocks = [(kind, np.array(rows, dtype=np.int64)) for kind, rows in by_kind.items()]
        for name, listed in self._all_sets():
            members = [place_of[node] for node in listed if node in place_of]
            mesh.add_to_set(self.spelling.get(name, name), np.array(members, dtype=np.int64))
        for section, material in self.sections:
            count = sum(self._is_plane(element) for element in self.element_sets.get(section, []))
            if count:
                mesh.materials[material] = mesh.materials.get(material, 0) + count
        if len(set(self.elastic)) == 1:
            mesh.elastic = self.elastic[0]
        if self.reduced:
            mesh.notes.append(
                f"elements {', '.join(sorted(self.reduced))} are fully integrated, "
                "without their special rules"
            )
        return mesh

    def _is_plane(self, element: int) -> bool:
        return element in self.elements and self.elements[element][0] in PLANE_CELLS

    def _all_sets(self) -> Iterable[tuple[str, list[int]]]:
        yield from self.node_sets.items()
        for name, members in self.element_sets.items():
            known = (self.elements[e][1] for e in members if e in self.elements)
            yield name, [node for nodes in known for node in nodes]
        for name, rows in self.surfaces.items():
            yield name, [node for row in rows for node in self._surface_nodes(*row)]

    def _surface_nodes(self, target: str, face: str) -> Iterable[int]:
        """Nodes of one line of a surface: a node, a node set, or edges of elements."""
        if face == "NODE":
            yield from self.node_sets.get(target, [int(target)] if target.isdigit() else [])
            return
        elements = self.element_sets.get(target, [int(target)] if target.isdigit() else [])
        for element in elements:
            kind, nodes = self.elements.get(element, ("", ()))
            if kind not in EDGE_CORNERS:
                continue
            corners = EDGE_CORNERS[kind]
            if not face.startswith("S") or not face[1:].isdigit():
                continue
            k = int(face[1:]) - 1
            if k < corners:
                yield from (nodes[k], nodes[(k + 1) % corners], *nodes[corners + k :][:1])


def _nodes_of(keyword: Keyword) -> Iterator[tuple[Row, int, tuple[float, float, float]]]:
    """Row, number and position of each node of *NODE."""
    table = keyword.table()
    if table is not None and _are_whole(table[:, 0]):
        places = np.zeros((len(table), 3))
        places[:, : table.shape[1] - 1] = table[:, 1:4]
        numbers = table[:, 0].astype(np.int64).tolist()
        yield from zip(keyword.data, numbers, map(tuple, places.tolist()), strict=True)
        return
    for row in keyword.data:
        (number,) = keyword.integers(Row(row.line, row.words[0]))
        x, y, z = (*keyword.numbers(row)[1:4], 0.0, 0.0, 0.0)[:3]
        yield row, number, (x, y, z)


def _are_whole(values: Floats) -> bool:
    """Whether all numbers are integers of at most `LARGEST_NUMBER`."""
    return bool(((values == np.round(values)) & (np.abs(values) <= LARGEST_NUMBER)).all())


@dataclass
class Row:
    """One data line, with its continuation lines.

    Attributes
    ----------
    line : int
        Line number in the file, from 1.
    content : str
        The comma-separated values.
    """

    line: int
    content: str

    @property
    def words(self) -> list[str]:
        """The values, without blanks around them."""
        return [word.strip() for word in self.content.split(",")]

    @property
    def text(self) -> str:
        """The row for a message."""
        return repr(", ".join(self.words)[:40])

    def refused(self, expected: str, found: str) -> BadFile:
        """Make the error of this row."""
        return BadFile(expected, f"{found} in line {self.line}")


@dataclass
class Keyword:
    """A keyword line with its data lines.

    Attributes
    ----------
    line : int
    name : str
        In upper case, without the asterisk.
    options : dict of str to str
        Names in upper case; an option without a value has "".
    data : list of Row
    """

    line: int
    name: str
    options: dict[str, str]
    data: list[Row] = field(default_factory=list)

    def refused(self, expected: str) -> BadFile:
        """Make the error of this keyword."""
        return BadFile(expected, f"*{self.name} in line {self.line}")

    def required(self, option: str) -> str:
        """Value of a required option."""
        value = self.options.get(option, "")
        if not value:
            raise self.refused(f"{option}= on the keyword line")
        return value

    def table(self) -> Floats | None:
        """All rows as numbers (n, k); None if lengths differ or a value is not a plain number."""
        rows = [row.content for row in self.data]
        if len({row.count(",") for row in rows}) != 1:
            return None
        try:
            words = ",".join(rows).split(",")
            return np.array([number_of(word) for word in words]).reshape(len(rows), -1)
        except ValueError:
            return None

    def numbers(self, row: Row) -> list[float]:
        """Values of a row as numbers, empty ones as 0; exponents may be those of Fortran (D)."""
        try:
            return [number_of(word.upper().replace("D", "E") or "0") for word in row.words]
        except ValueError:
            raise row.refused(f"numbers after *{self.name}", row.text) from None

    def integers(self, row: Row) -> list[int]:
        """Values of a row as whole numbers."""
        values = self.numbers(row)
        if any(not value.is_integer() or abs(value) > LARGEST_NUMBER for value in values):
            raise row.refused(f"whole numbers after *{self.name}", row.text)
        return [int(value) for value in values]

    def whole_rows(self, size: int) -> Iterator[tuple[Row, list[int]]]:
        """Rows of `size` whole numbers; shorter rows are joined with the following ones."""
        table = self.table()
        if table is not None and table.shape[1] == size and _are_whole(table):
            yield from zip(self.data, table.astype(np.int64).tolist(), strict=True)
            return
        waiting: Row | None = None
        for row in self.data:
            words = [word for word in row.words if word]
            if waiting is not None:
                words = [*waiting.words, *words]
            waiting = Row(row.line if waiting is None else waiting.line, ",".join(words))
            if len(words) >= size:
                yield waiting, self.integers(waiting)
                waiting = None
        if waiting is not None:
            yield waiting, self.integers(waiting)


def keywords(lines: Sequence[str]) -> Iterable[Keyword]:
    """Keywords of a file in order, each with its data.

    Raises
    ------
    BadFile
        If there are data before the first keyword.
    """
    current: Keyword | None = None
    number = 0
    while number < len(lines):
        line = lines[number].strip()
        number += 1
        if not line or line.startswith("**"):
            continue
        if not line.startswith("*"):
            if current is None:
                raise BadFile("a readable mesh file", f"{line[:40]!r} before any *KEYWORD")
            current.data.append(Row(number, line.rstrip(", \t")))
            continue
        first = number
        while line.endswith(",") and number < len(lines):
            line += lines[number].strip()
            number += 1
        if current is not None:
            yield current
        current = _keyword(line, first)
    if current is not None:
        yield current


def _keyword(line: str, number: int) -> Keyword:
    name, *rest = line[1:].split(",")
    options = {}
    for part in rest:
        option, _, value = part.partition("=")
        if option.strip():
            options[option.strip().upper()] = value.strip().strip('"')
    return Keyword(number, " ".join(name.split()).upper(), options)
