"""Mesh files in their dialects: the same mesh and the same sets, or one line with the fault."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from flankload.errors import MeshError
from flankload.meshes.io import RawMesh, read_mesh
from tests.support.paths import TEST_MESHES

RING = TEST_MESHES

#: Two quadrilaterals side by side, with everything that Abaqus writes in other ways, too.
QUADS = """*HEADING
 two elements
** a comment
*NODE, NSET=ALL
1, 0.0, 0.0
2, 1.0, 0.0
3, 2.0, 0.0
4, 0.0, 1.0
5, 1.0D+00, 1.0
6, 2.0, 1.0
*ELEMENT, TYPE=CPE4, ELSET=BODY
1, 1, 2, 5, 4
2, 2, 3, 6, 5
*NSET, NSET=Top
4, 5, 6,
"""


def ring(name: str) -> RawMesh:
    return read_mesh(RING / name)


def inp(tmp_path: Path, text: str) -> RawMesh:
    path = tmp_path / "mesh.inp"
    path.write_text(text, encoding="utf-8")
    return read_mesh(path)


def refusal(tmp_path: Path, text: str, suffix: str = ".inp") -> MeshError:
    path = tmp_path / f"mesh{suffix}"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MeshError) as caught:
        read_mesh(path)
    assert str(caught.value).startswith(f"{path}: expected ")
    assert "\n" not in str(caught.value)
    return caught.value


# --- files of gmsh --------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "name",
    ["ring_22.msh", "ring_22_binary.msh", "ring_41.msh", "ring_41_binary.msh", "ring_41_all.msh"],
)
def test_versions_of_gmsh_are_one_mesh(name: str) -> None:
    """Text and binary, groups that share a curve, a group without a name, parametric nodes."""
    found, expected = ring(name), ring("ring_41.msh")
    assert [(kind, len(data)) for kind, data in found.cells] == [("triangle6", 32)]
    assert set(found.sets) == {"BODY", "RIM", "BORE", "BOTH ARCS", "line 77"}
    for key in expected.sets:
        places, wanted = found.nodes[found.sets[key]], expected.nodes[expected.sets[key]]
        order, other = np.lexsort(places.round(6).T), np.lexsort(wanted.round(6).T)
        np.testing.assert_allclose(places[order], wanted[other], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(
        np.union1d(found.sets["RIM"], found.sets["BORE"]), found.sets["BOTH ARCS"]
    )
    np.testing.assert_allclose(np.hypot(*found.nodes[found.sets["RIM"]].T), 20.0, rtol=1e-9)
    assert found.materials == {}


def test_inp_of_gmsh_is_its_msh() -> None:
    found, expected = ring("ring.inp"), ring("ring_22.msh")
    assert [(kind, len(data)) for kind, data in found.cells] == [("triangle6", 32)]
    # 14 digits
    np.testing.assert_allclose(found.nodes, expected.nodes, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(found.cells[0][1], expected.cells[0][1])
    for name in ("BODY", "RIM", "BORE"):
        np.testing.assert_array_equal(found.sets[name], expected.sets[name])


def test_cut_off_and_strange_gmsh_files_are_refused(tmp_path: Path) -> None:
    text = (RING / "ring_41.msh").read_text(encoding="ascii")
    assert refusal(tmp_path, text[:3000], ".msh").found == "section $Nodes, which is cut off"
    assert refusal(tmp_path, text.replace("4.1 0 8", "4 0 8"), ".msh").found == "version 4 0 8"
    error = refusal(tmp_path, text.replace("2 1 9 32", "2 1 21 32"), ".msh")
    assert error.expected == "elements of first or second order"
    assert error.found == "gmsh's element type 21"
    assert refusal(tmp_path, "", ".msh").found == "a file that is no gmsh mesh"
    binary = (RING / "ring_41_binary.msh").read_bytes()
    path = tmp_path / "half.msh"
    path.write_bytes(binary[: len(binary) // 2])
    with pytest.raises(MeshError, match="cut off"):
        read_mesh(path)


def test_numbers_of_gmsh_have_plain_digits(tmp_path: Path) -> None:
    text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 5_0 0 0\n$EndNodes\n"
    error = refusal(tmp_path, text, ".msh")
    assert (error.expected, error.found) == ("numbers in section $Nodes", "1 5_0 0 0")


@pytest.mark.parametrize("number", ["1.5", "nan", "1e16"])
def test_node_numbers_of_gmsh_are_integers(tmp_path: Path, number: str) -> None:
    text = f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n{number} 0 0 0\n$EndNodes\n"
    error = refusal(tmp_path, text, ".msh")
    assert (error.expected, error.found) == ("node numbers", "a number that is not an integer")


# --- files of Abaqus and CalculiX -----------------------------------------------------------------
def test_abaqus_sets_of_every_kind(tmp_path: Path) -> None:
    found = inp(
        tmp_path,
        QUADS
        + """*nset, nset=bottom, generate
1, 3, 1
*NSET, NSET=Both
Top, BOTTOM
*ELSET, ELSET=RIGHT
2
*NSET, NSET=RIGHT_NODES, ELSET=RIGHT
*Surface, type=ELEMENT, name=SIDE
RIGHT, S2
*Surface, type=NODE, name=POINTS
Top,
1
*NSET,
NSET=CONTINUED
1,
2
*STEP
*STATIC
*END STEP
""",
    )
    sets = {name: members.tolist() for name, members in found.sets.items()}
    assert sets == {
        "ALL": [0, 1, 2, 3, 4, 5],
        "Top": [3, 4, 5],
        "bottom": [0, 1, 2],
        "Both": [0, 1, 2, 3, 4, 5],
        "RIGHT_NODES": [1, 2, 4, 5],
        "CONTINUED": [0, 1],
        "BODY": [0, 1, 2, 3, 4, 5],
        "RIGHT": [1, 2, 4, 5],
        "SIDE": [2, 5],
        "POINTS": [0, 3, 4, 5],
    }
    assert found.set_name("TOP") == "Top"
    assert found.set_name("top") == "Top"
    assert found.set_name("sides") is None


@pytest.mark.parametrize("prefix", ["CPE", "CPS"])
@pytest.mark.parametrize(
    ("size", "kind"), [(3, "triangle"), (4, "quad"), (6, "triangle6"), (8, "quad8")]
)
@pytest.mark.parametrize("suffix", ["", "R"])
def test_every_plane_element_of_abaqus(
    prefix: str, size: int, kind: str, suffix: str, tmp_path: Path
) -> None:
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)] if size in (4, 8) else [(0, 0), (1, 0), (0, 1)]
    nodes = [np.array(corner, dtype=float) for corner in corners]
    if size > 4:
        nodes += [0.5 * (a + b) for a, b in zip(nodes, nodes[1:] + nodes[:1], strict=True)]
    lines = ["*node", *(f"{k + 10}, {x}, {y}" for k, (x, y) in enumerate(nodes))]
    # the element's nodes over two lines
    numbers = [k + 10 for k in range(size)]
    written = f"{prefix}{size}{suffix}"
    lines += [f"*element, type={written.lower()}", f"7, {numbers[0]},"]
    lines.append(", ".join(map(str, numbers[1:])))
    found = inp(tmp_path, "\n".join(lines))
    assert [(k, data.tolist()) for k, data in found.cells] == [(kind, [list(range(size))])]
    np.testing.assert_array_equal(found.nodes, nodes)
    notes = (f"elements {written} are fully integrated, without their special rules",)
    assert found.notes == (notes if suffix else ())


def test_second_material_and_constants_are_seen(tmp_path: Path) -> None:
    sections = """*ELSET, ELSET=LEFT
1
*ELSET, ELSET=RIGHT
2
*MATERIAL, NAME=Steel
*ELASTIC
206000., 0.3
*SOLID SECTION, ELSET=LEFT, MATERIAL=STEEL
1.
*SOLID SECTION, ELSET=RIGHT, MATERIAL=Bronze
1.
"""
    found = inp(tmp_path, QUADS + sections)
    assert found.materials == {"STEEL": 1, "BRONZE": 1}
    assert found.elastic == (206000.0, 0.3)


@pytest.mark.parametrize(
    ("old", "new", "expected", "found"),
    [
        ("*HEADING", "*INCLUDE, INPUT=b.inp\n*HEADING",
         "a whole mesh in one file", "*INCLUDE in line 1"),
        ("*NODE, NSET=ALL", "*NODE, INPUT=b.inp", "a whole mesh in one file", "*NODE in line 4"),
        ("*NSET, NSET=Top", "*NGEN\n1, 3\n*NSET, NSET=Top",
         "every node written out", "*NGEN in line 14"),
        ("TYPE=CPE4", "TYPE=C3D4", "plane elements (CPE3/4/6/8, CPS3/4/6/8)", "elements C3D4"),
        ("TYPE=CPE4", "TYPE=CAX4", "plane elements (CPE3/4/6/8, CPS3/4/6/8)", "elements CAX4"),
        ("TYPE=CPE4, ", "", "TYPE= on the keyword line", "*ELEMENT in line 11"),
        ("2, 2, 3, 6, 5", "2, 2, 3, 6", "4 nodes of an element CPE4", "3 in line 13"),
        ("2, 2, 3, 6, 5", "2, 2, 3, 6, 9",
         "elements on nodes that the file has", "node 9 in element 2"),
        ("2, 2, 3, 6, 5", "1, 2, 3, 6, 5",
         "element 1 once", "twice, with different nodes in line 13"),
        ("6, 2.0, 1.0", "5, 2.0, 1.0", "node 5 once", "twice, at different places in line 10"),
        ("2, 1.0, 0.0", "2, one, 0.0", "numbers after *NODE", "'2, one, 0.0' in line 6"),
        ("4, 5, 6,", "4, MIDDLE", "numbers or sets of NSET", "'MIDDLE' in line 15"),
        ("*HEADING", "*PART, NAME=A\n*END PART\n*PART, NAME=B\n*HEADING",
         "one part", "*PART in line 3"),
        ("*HEADING", "*INSTANCE, NAME=A, PART=B\n1., 0., 0.\n*HEADING",
         "an instance that is not moved", "*INSTANCE in line 1"),
        ("*HEADING", "1, 2, 3\n*HEADING",
         "a readable mesh file", "'1, 2, 3' before any *KEYWORD"),
        ("6, 2.0, 1.0", "6, 2.0, 1.0, 0.5", "all nodes in one plane z = const", "z from 0 to 0.5"),
        ("2, 1.0, 0.0", "2, 1_0, 0.0", "numbers after *NODE", "'2, 1_0, 0.0' in line 6"),
        ("6, 2.0, 1.0", "6, 2.0, nan", "coordinates up to 1e+09 mm", "nan"),
    ],
)  # fmt: skip
def test_content_that_would_be_misread_is_refused_with_its_line(
    old: str, new: str, expected: str, found: str, tmp_path: Path
) -> None:
    assert old in QUADS
    error = refusal(tmp_path, QUADS.replace(old, new))
    assert (error.expected, error.found) == (expected, found)


def test_empty_inp_is_refused(tmp_path: Path) -> None:
    assert refusal(tmp_path, "").found == "no *NODE in it"
    assert refusal(tmp_path, "*NODE\n1, 0., 0.\n").found == "no elements"


# --- files by meshio ------------------------------------------------------------------------------
def test_vtu_names_sets_by_arrays_over_points_and_cells(tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]], float)
    quads = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    mesh = meshio.Mesh(
        points,
        [("quad", quads), ("line", np.array([[0, 1], [1, 2]]))],
        point_data={
            "TOP": np.array([0, 0, 0, 1, 1, 1]),
            "AS_FLOAT": np.array([1.0, 1.0, 0, 0, 0, 0]),
            "temperature": np.linspace(0.0, 1.0, 6),
            "EMPTY": np.zeros(6, dtype=int),
        },
        cell_data={
            "RIGHT": [np.array([0, 1]), np.array([0, 0])],
            "BOTTOM": [np.array([0, 0]), np.array([1, 1])],
            "material": [np.array([3, 4]), np.array([0, 0])],
        },
    )
    path = tmp_path / "mesh.vtu"
    meshio.write(path, mesh)
    found = read_mesh(path)
    assert {name: members.tolist() for name, members in found.sets.items()} == {
        "TOP": [3, 4, 5],
        "AS_FLOAT": [0, 1],
        "RIGHT": [1, 2, 4, 5],
        "BOTTOM": [0, 1, 2],
    }
    assert found.materials == {"material 3": 1, "material 4": 1}


@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".med", ".e", ".xdmf", ".bdf"])
def test_garbage_of_any_suffix_gets_one_line(suffix: str, tmp_path: Path) -> None:
    error = refusal(tmp_path, "garbage\n", suffix)
    assert error.expected == "a readable mesh file"
