"""Each defect of a mesh is one line, from `flankload check` of the file and from a scene."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest

from flankload.cli import main
from tests.support.mesh_files import PINION, WHEEL
from tests.support.solving import solve
from tests.support.tolerances import SOLVER

Change = Callable[[meshio.Mesh], None]

SCENE = """
[body_1]
kind = "mesh"
file = "{file}"
teeth = 16
reference_radius_mm = 33.8289
{more}
[body_2]
kind = "mesh"
file = "{wheel}"
teeth = 24
reference_radius_mm = 50.7434
[pair]
center_distance_mm = 91.5
face_width_mm = 14
[load]
torque_Nm = 302
[positions]
count = 1
[accuracy]
estimate = false
"""


def pinion(change: Change, folder: Path) -> Path:
    """The pinion's mesh of the examples after a change."""
    mesh = meshio.read(PINION)
    change(mesh)
    path = folder / "changed.msh"
    meshio.write(path, mesh, file_format="gmsh22", binary=False)
    return path


def scene_with(path: Path, more: str = "") -> Path:
    scene = path.with_name("pair.toml")
    scene.write_text(SCENE.format(file=path.name, wheel=WHEEL, more=more), encoding="utf-8")
    return scene


def run(capsys: pytest.CaptureFixture[str], *argv: str | Path) -> tuple[int, str, str]:
    capsys.readouterr()  # meshio prints where it reads
    code = main([str(argument) for argument in argv])
    out, err = capsys.readouterr()
    assert err.count("\n") == (1 if err else 0)
    assert "Traceback" not in err
    return code, out, err


def quadrilaterals(mesh: meshio.Mesh) -> np.ndarray:
    return mesh.cells[0].data


def drop(mesh: meshio.Mesh, rows: np.ndarray) -> None:
    """Take quadrilaterals out, with their marks."""
    mesh.cells[0].data = np.delete(quadrilaterals(mesh), rows, axis=0)
    for marks in mesh.cell_data.values():
        marks[0] = np.delete(marks[0], rows)


def add(mesh: meshio.Mesh, kind: str, data: np.ndarray, tag: int = 1) -> None:
    mesh.cells.append(meshio.CellBlock(kind, data))
    for marks in mesh.cell_data.values():
        marks.append(np.full(len(data), tag))


def unchanged(mesh: meshio.Mesh) -> None:
    """No defect."""


# --- the defects ----------------------------------------------------------------------------------
def doubled_node(mesh: meshio.Mesh) -> None:
    """A crack: a rim node of one element is a copy of the one it shares."""
    corner = quadrilaterals(mesh)[200, 0]
    mesh.points = np.vstack([mesh.points, mesh.points[corner]])
    quadrilaterals(mesh)[200, 0] = len(mesh.points) - 1


def doubled_element(mesh: meshio.Mesh) -> None:
    copy = np.roll(quadrilaterals(mesh)[[7, 8]], 0, axis=1)
    add(mesh, "quad9", copy, tag=0)


def linear_among_quadratic(mesh: meshio.Mesh) -> None:
    linear = quadrilaterals(mesh)[:5, :4].copy()
    drop(mesh, np.arange(5))
    add(mesh, "quad", linear)


def solids(mesh: meshio.Mesh) -> None:
    add(mesh, "tetra", np.array([[0, 1, 2, 3]]))


def out_of_plane(mesh: meshio.Mesh) -> None:
    mesh.points[40, 2] = 0.25


def folded(mesh: meshio.Mesh) -> None:
    """An element laid over its neighbour: mirrored about their common edge."""
    data = quadrilaterals(mesh)
    a, b, m = data[100][[0, 1, 4]]
    other = [n for n in data[100] if n not in (a, b, m)]
    along = mesh.points[b, :2] - mesh.points[a, :2]
    along /= np.linalg.norm(along)
    away = mesh.points[other, :2] - mesh.points[a, :2]
    mirrored = mesh.points[a, :2] + 2 * np.outer(away @ along, along) - away
    first = len(mesh.points)
    mesh.points = np.vstack([mesh.points, np.column_stack([mirrored, np.zeros(len(other))])])
    new = dict(zip(other, range(first, first + len(other)), strict=True))
    data[100] = [new.get(n, n) for n in data[100]]


def turned_over(mesh: meshio.Mesh) -> None:
    """The centre of an element beyond its edge: no numbering mends it."""
    cell = quadrilaterals(mesh)[5]
    centre = mesh.points[cell[8]].copy()
    mesh.points[cell[8]] = mesh.points[cell[0]] + 3 * (mesh.points[cell[0]] - centre)


def middle_moved(mesh: meshio.Mesh) -> None:
    a, b, m = quadrilaterals(mesh)[30][[0, 1, 4]]
    mesh.points[m] = 0.3 * mesh.points[a] + 0.7 * mesh.points[b]


def nodes_in_wrong_order(mesh: meshio.Mesh) -> None:
    """Middle nodes before corners, as some formats have them."""
    data = quadrilaterals(mesh)
    data[:, :8] = data[:, [0, 4, 1, 5, 2, 6, 3, 7]]


def loose_part(mesh: meshio.Mesh) -> None:
    """A second body far away in the same file."""
    count = len(mesh.points)
    own = quadrilaterals(mesh)[:3]
    copy = np.unique(own)
    number = {int(n): count + k for k, n in enumerate(copy)}
    mesh.points = np.vstack([mesh.points, mesh.points[copy] + [100.0, 0, 0]])
    add(mesh, "quad9", np.vectorize(number.get)(own), tag=1)


def two_materials(mesh: meshio.Mesh) -> None:
    mesh.field_data["RIM"] = np.array([9, 2])
    for marks in mesh.cell_data.values():
        marks[0] = np.array(marks[0])
        marks[0][:100] = 9


DEFECTS: list[tuple[Change, str, str]] = [
    (doubled_node, "one node at a place (merge them in the mesher)",
     "1 nodes that coincide with others, the first at x = "),
    (doubled_element, "each element once", "2 repeated elements, the first at x = "),
    (linear_among_quadratic, "elements of one order",
     "5 linear and 299 quadratic elements"),
    (folded, "elements that do not lie on each other", "edges with two elements on the same side"),
    (turned_over, "elements with a positive Jacobian", "1 inverted of 304, the first (quad9) at x"),
    (middle_moved, "middle nodes within 0.15 of an edge's length from its middle",
     "2 of 1216 further off, the first at x = "),
    (nodes_in_wrong_order, "middle nodes within 0.15 of an edge's length from its middle",
     "of 1216 further off, the first at x = "),
    (loose_part, "one connected body in a file", "2 parts that share no edge, of 304, 3 elements"),
    (two_materials, "one material (one_material = true in the scene ",
     "2: BODY (204 elements), RIM (100 elements)"),
]  # fmt: skip

#: Those that the reader itself refuses.
UNREADABLE: list[tuple[Change, str, str]] = [
    (solids, "plane elements (triangle, ", "1 tetra"),
    (out_of_plane, "all nodes in one plane z = const", "z from 0 to 0.25"),
]


@pytest.mark.parametrize(("change", "expected", "found"), DEFECTS)
def test_check_of_the_file_prints_it_with_all_else(
    change: Change, expected: str, found: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = pinion(change, tmp_path)
    code, out, err = run(capsys, "check", path)
    assert code == 2
    assert err.startswith(f"flankload: {path}: expected {expected}")
    assert found in err
    assert out.startswith(f"{path}: a plane mesh with defects\n")
    assert "\nwrong\n" in out
    assert "FLANK" in out
    # the line is there once more, among all that is wrong
    assert err.removeprefix(f"flankload: {path}: ").strip() in out


@pytest.mark.parametrize(("change", "expected", "found"), DEFECTS + UNREADABLE)
@pytest.mark.parametrize("command", ["check", "run"])
def test_scene_with_the_file_gets_the_line_and_its_key(
    command: str, change: Change, expected: str, found: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    path = pinion(change, tmp_path)
    code, out, err = run(capsys, command, scene_with(path))
    assert (code, out) == (2, "")
    assert err.startswith(f"flankload: {path}: body_1.file: expected {expected}")
    assert found in err


@pytest.mark.parametrize(("change", "expected", "found"), UNREADABLE)
def test_check_of_a_file_without_a_plane_mesh_is_one_line(
    change: Change, expected: str, found: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = pinion(change, tmp_path)
    code, out, err = run(capsys, "check", path)
    assert (code, out) == (2, "")
    assert err.startswith(f"flankload: {path}: expected {expected}")
    assert found in err


def test_several_defects_are_all_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def change(mesh: meshio.Mesh) -> None:
        middle_moved(mesh)
        two_materials(mesh)
        doubled_node(mesh)

    _, out, _ = run(capsys, "check", pinion(change, tmp_path))
    wrong = out.split("\nwrong\n")[1].splitlines()
    assert len(wrong) == 3
    assert all(line.startswith("  expected ") for line in wrong)


# --- repaired or intended -------------------------------------------------------------------------
def test_groups_may_be_one_material_all_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = pinion(two_materials, tmp_path)
    code, _, err = run(capsys, "check", scene_with(path, "one_material = true"))
    assert (code, err) == (0, "")


@pytest.mark.parametrize("part", [slice(None), slice(40, 60)], ids=["all", "some"])
def test_elements_numbered_clockwise_are_turned_round(
    part: slice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import flankload as fl

    def clockwise(mesh: meshio.Mesh) -> None:
        data = quadrilaterals(mesh)
        data[part] = data[part][:, [0, 3, 2, 1, 7, 6, 5, 4, 8]]

    expected = solve(fl.read_scene(scene_with(pinion(unchanged, tmp_path))))
    path = pinion(clockwise, tmp_path)
    found = solve(fl.read_scene(scene_with(path)))
    assert (found.rotation_rad == expected.rotation_rad).all()
    assert any("numbered clockwise: their numbering is reversed" in note for note in found.warnings)
    assert run(capsys, "check", path)[0] == 0


def test_flank_edges_in_any_order_and_direction_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import flankload as fl

    def shuffled(mesh: meshio.Mesh) -> None:
        lines = mesh.cells[1].data
        flank = np.flatnonzero(mesh.cell_data["gmsh:physical"][1] == mesh.field_data["FLANK"][0])
        lines[flank] = lines[np.random.default_rng(1).permutation(flank)]
        lines[::2] = lines[::2][:, [1, 0, 2]]

    expected = solve(fl.read_scene(scene_with(pinion(unchanged, tmp_path))))
    found = solve(fl.read_scene(scene_with(pinion(shuffled, tmp_path))))
    assert (found.rotation_rad == expected.rotation_rad).all()


# --- size, axis and supports ----------------------------------------------------------------------
@pytest.mark.parametrize(
    ("factor", "unit"), [(1e-3, "metres"), (1 / 25.4, "inches"), (1e3, "micrometres")]
)
@pytest.mark.parametrize(
    "more",
    ["", "[body_1.profile]\nmodule_mm = 4.5\nprofile_shift = 0.182\ntip_diameter_mm = 82.46"],
)
def test_other_units_are_named(
    factor: float, unit: str, more: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def scale(mesh: meshio.Mesh) -> None:
        mesh.points *= factor

    path = pinion(scale, tmp_path)
    code, out, err = run(capsys, "check", scene_with(path, more))
    assert (code, out) == (2, "")
    assert err.startswith(f"flankload: {path}: body_1.file: expected a mesh in millimetres about")
    assert f"in {unit}? (1 = " in err


@pytest.mark.parametrize(("factor", "unit"), [(1e-3, "metres"), (1e3, "micrometres")])
def test_check_of_the_file_alone_guesses_units(
    factor: float, unit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def scale(mesh: meshio.Mesh) -> None:
        mesh.points *= factor

    code, out, _ = run(capsys, "check", pinion(scale, tmp_path))
    assert code == 0
    assert f"is the file in {unit}? Coordinates must be in millimetres" in out


def test_axis_beside_the_origin_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def shift(mesh: meshio.Mesh) -> None:
        mesh.points += [5.0, -2.0, 0.0]

    path = pinion(shift, tmp_path)
    _, out, _ = run(capsys, "check", path)
    assert "set 'BORE' is a circle of radius 15 about x = 5, y = -2 mm" in out
    code, _, err = run(capsys, "check", scene_with(path))
    assert code == 2
    assert err == (
        f"flankload: {path}: body_1.file: expected a body whose axis is the origin, found a bore "
        "about x = 5.0000, y = -2.0000 mm\n"
    )


def test_body_held_in_one_node_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def pin(mesh: meshio.Mesh) -> None:
        mesh.field_data["PIN"] = np.array([9, 0])
        corner = int(np.argmin(np.hypot(*mesh.points[:, :2].T)))
        add(mesh, "vertex", np.array([[corner]]), tag=9)

    path = pinion(pin, tmp_path)
    code, _, err = run(capsys, "check", scene_with(path, 'fixed_set = "PIN"'))
    assert code == 2
    assert err.endswith(
        "body_1.fixed_set: expected at least 2 nodes, to hold the body, found 1 in 'PIN'\n"
    )


# --- flanks ---------------------------------------------------------------------------------------
def test_flank_round_the_tip_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def round_the_tip(mesh: meshio.Mesh) -> None:
        radius = np.hypot(*mesh.points[:, :2].T)
        tip = np.flatnonzero(radius > radius.max() - 1e-6)
        data = quadrilaterals(mesh)
        ends = np.vstack([data[:, edge] for edge in ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7))])
        land = ends[np.isin(ends, tip).all(axis=1)]
        assert len(land) > 2
        add(mesh, "line3", land, tag=int(mesh.field_data["FLANK"][0]))

    path = pinion(round_the_tip, tmp_path)
    code, _, err = run(capsys, "check", scene_with(path))
    assert code == 2
    assert "body_1.flank_set: expected set 'FLANK' to be a smooth flank (its own edges or " in err
    assert "alone), found a corner of " in err


def test_open_flank_inside_the_body_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def inside(mesh: meshio.Mesh) -> None:
        # the diagonal through the body: its nodes lie on no common edge of the boundary
        mesh.field_data["INSIDE"] = np.array([9, 1])
        data = quadrilaterals(mesh)
        add(mesh, "line3", data[100:104][:, [0, 2, 8]], tag=9)

    path = pinion(inside, tmp_path)
    code, _, err = run(capsys, "check", scene_with(path, 'flank_set = "INSIDE"'))
    assert code == 2
    assert "to be one open line of at least 2 edges of the boundary, found 0 edges" in err


def test_straight_sided_quadratic_elements_take_their_corners(tmp_path: Path) -> None:
    """Middle nodes on the chords would bend the curve at every node."""
    import flankload as fl

    def straighten(mesh: meshio.Mesh) -> None:
        for block in mesh.cells:
            if block.type == "line3":
                first, last, middle = block.data.T
                mesh.points[middle] = 0.5 * (mesh.points[first] + mesh.points[last])

    exact = solve(fl.read_scene(scene_with(pinion(unchanged, tmp_path))))
    found = solve(fl.read_scene(scene_with(pinion(straighten, tmp_path))))
    assert any("its corner nodes alone" in note for note in found.warnings)
    # the curve through 10 corner nodes deviates by about 1 um of 39
    np.testing.assert_allclose(found.rotation_rad, exact.rotation_rad, rtol=0.03, atol=0)
    peak, wanted = (np.nanmax(result.peak_pressure_MPa) for result in (found, exact))
    assert peak == pytest.approx(wanted, rel=0.03)


def test_case_of_a_set_does_not_matter_where_one_fits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = pinion(unchanged, tmp_path)
    assert run(capsys, "check", scene_with(path, 'flank_set = "Flank"'))[0] == 0


def test_cuts_of_unlike_meshes_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def move(mesh: meshio.Mesh) -> None:
        """The inner nodes of one cut slide along it: as two meshers would leave them."""
        cut = mesh.cell_data["gmsh:physical"][1] == mesh.field_data["CUT_LEFT"][0]
        nodes = np.unique(mesh.cells[1].data[cut])
        radius = np.hypot(*mesh.points[nodes, :2].T)
        mesh.points[nodes[(radius > 20) & (radius < 30)], :2] *= 1.001

    path = pinion(move, tmp_path)
    code, _, err = run(capsys, "check", scene_with(path))
    assert code == 2
    assert "body_1.cut_sets: expected cut faces that match when turned by 360/16 deg" in err


def test_material_in_the_file_that_differs_is_noted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from flankload.bodies.imported.body_file import write_body
    from flankload.meshes.io import read_mesh

    assert read_mesh(PINION).elastic is None
    import flankload as fl
    from flankload.mechanisms.flank_pair.assembly import build_bodies

    body = build_bodies(fl.read_scene(scene_with(pinion(unchanged, tmp_path)))).body_1
    path = tmp_path / "soft.inp"
    write_body(path, body.mesh)
    text = path.read_text(encoding="ascii")
    path.write_text(text + "*MATERIAL, NAME=ALU\n*ELASTIC\n70000., 0.33\n", encoding="ascii")
    code, out, _ = run(capsys, "check", scene_with(path))
    assert code == 0
    assert "the file's own material (E = 70000, nu = 0.33) is not used" in out
    assert "E = 70000, nu = 0.33; not used" in run(capsys, "check", path)[1]


def test_flank_set_that_takes_in_the_fillet_is_cut_to_the_profile(tmp_path: Path) -> None:
    """With a given profile, modes extend from fillet to tip, even if the set contains more."""
    import flankload as fl
    from flankload.mechanisms.flank_pair.assembly import build_bodies
    from flankload.meshes.io import read_mesh
    from flankload.meshes.plane_mesh import boundary_edges

    profile = "[body_1.profile]\nmodule_mm = 4.5\nprofile_shift = 0.182\ntip_diameter_mm = 82.46\n"

    plain = pinion(unchanged, tmp_path)

    def with_fillet(mesh: meshio.Mesh) -> None:
        raw = read_mesh(PINION)
        edges = boundary_edges(raw.cells)
        curve = build_bodies(fl.read_scene(scene_with(plain, profile))).body_1.curve
        _, away = curve.arc_length_of(raw.nodes[edges.ravel()])
        on_profile = edges[(away.reshape(edges.shape) < 1e-6).all(axis=1)]
        assert len(on_profile) > 11
        # the example's file has no nodes that no element uses: its numbers are the mesh's
        assert len(raw.nodes) == len(mesh.points)
        add(mesh, "line3", on_profile, tag=int(mesh.field_data["FLANK"][0]))

    expected = solve(fl.read_scene(scene_with(plain, profile)))
    found = solve(fl.read_scene(scene_with(pinion(with_fillet, tmp_path), profile)))
    np.testing.assert_allclose(found.rotation_rad, expected.rotation_rad, rtol=SOLVER, atol=0)
