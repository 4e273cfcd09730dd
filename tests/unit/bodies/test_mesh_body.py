"""Bodies from mesh files: the same numbers as from parameters, and one line for every defect."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import meshio
import numpy as np
import pytest

import flankload as fl
from flankload.bodies.imported.body_file import write_body
from flankload.errors import MeshError, SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.meshes.io import read_mesh
from flankload.scene.accuracy import Accuracy
from tests.support.paths import MESHES, SCENES
from tests.support.solving import solve

PINION = MESHES / "fzg_c_pinion.msh"
WHEEL = MESHES / "fzg_c_wheel.msh"


def mesh_scene(pinion: Path = PINION, wheel: Path = WHEEL, **keys: object) -> fl.Scene:
    """The FZG pair with meshes whose profile is not known; keys go to body_1."""
    body_1 = {"kind": "mesh", "file": str(pinion), "teeth": 16, "reference_radius_mm": 33.8289}
    body_2 = {"kind": "mesh", "file": str(wheel), "teeth": 24, "reference_radius_mm": 50.7434}
    return fl.Scene.from_dict(
        {
            "body_1": {**body_1, **keys},
            "body_2": body_2,
            "pair": {"center_distance_mm": 91.5, "face_width_mm": 14},
            "load": {"torque_Nm": 302},
            "positions": {"count": 8},
            "accuracy": {"estimate": False, "tangents": False},
        }
    )


def example(name: str) -> fl.Scene:
    """A scene of the examples without estimates."""
    plain = Accuracy(estimate=False, tangents=False)
    return dataclasses.replace(fl.read_scene(SCENES / f"{name}.toml"), accuracy=plain)


@pytest.fixture(scope="module")
def parametric() -> fl.Result:
    return solve(example("external_gear"))


def test_mesh_with_its_profile_gives_the_result_of_the_parameters(parametric: fl.Result) -> None:
    found = solve(example("external_gear_mesh_profile"))
    np.testing.assert_allclose(found.rotation_rad, parametric.rotation_rad, rtol=1e-9, atol=0)
    total = parametric.site_force_N.sum(axis=1).max()
    np.testing.assert_allclose(
        found.site_force_N, parametric.site_force_N, rtol=0, atol=1e-9 * total
    )
    smooth = ~parametric.corner_contact
    np.testing.assert_allclose(
        found.peak_pressure_MPa[smooth], parametric.peak_pressure_MPa[smooth], rtol=1e-9, atol=1e-6
    )


def test_mesh_of_unmodified_flanks_takes_a_relief_from_its_profile() -> None:
    """The relief is above the distance at which nodes are refused; a scan solves no elements."""
    relief = {"tip_relief_um": 60.0, "tip_relief_start_diameter_mm": 79.0}
    few = {"positions": {"count": 3}}
    gear, mesh = example("external_gear"), example("external_gear_mesh_profile")
    gear = gear.replace(few | {f"body_1.{key}": value for key, value in relief.items()})
    mesh = mesh.replace(few | {f"body_1.profile.{key}": value for key, value in relief.items()})
    prepared = fl.prepare(mesh.replace({"body_1.profile.tip_relief_um": 40.0}))
    found, expected = prepared.solve({"body_1.profile.tip_relief_um": 60.0}), fl.solve(gear)
    np.testing.assert_allclose(found.rotation_rad, expected.rotation_rad, rtol=1e-9, atol=0)
    assert found.cost["fe_factorisations"] == 0
    assert any("um of it without its modifications" in warning for warning in found.warnings)


def test_curve_through_the_nodes_is_near_and_says_how_near(parametric: fl.Result) -> None:
    found = solve(example("external_gear_mesh"))
    np.testing.assert_allclose(found.rotation_rad, parametric.rotation_rad, rtol=3e-3, atol=0)
    deviations = [
        float(match[1]) / 1000
        for warning in found.warnings
        if (match := re.search(r"estimated deviation .* (\S+) um", warning))
    ]
    assert len(deviations) == 2
    # explained by the deviation: both flanks' share of the rotation at the base radius of body 1
    largest = np.abs(found.rotation_rad - parametric.rotation_rad).max() * 33.8289
    assert largest < 3 * sum(deviations)


def test_rigid_mesh_needs_nothing_but_its_flank() -> None:
    """Sets of rim and cuts may be missing; with them the result is the same."""
    missing = {"fixed_set": "NO_RIM", "cut_sets": ["NO_LEFT", "NO_RIGHT"]}
    found = fl.solve(mesh_scene(rigid=True, **missing))
    expected = solve(mesh_scene(rigid=True))
    assert found.cost["fe_factorisations"] == 1
    assert found.cost["fe_degrees_of_freedom"][0] == 0
    np.testing.assert_array_equal(found.rotation_rad, expected.rotation_rad)
    np.testing.assert_array_equal(found.site_force_N, expected.site_force_N)
    with pytest.raises(MeshError, match="NO_RIM"):
        solve(mesh_scene(**missing))


@pytest.mark.parametrize(
    ("suffix", "bore"), [(".msh", "held"), (".vtu", "held"), (".msh", "torque")]
)
def test_round_trip_keeps_nodes_cells_and_sets(tmp_path: Path, suffix: str, bore: str) -> None:
    scene = fl.read_scene(SCENES / "external_gear.toml").replace({"body_1.bore": bore})
    body = build_bodies(scene).body_1
    path = tmp_path / f"sector{suffix}"
    write_body(path, body.mesh)
    back = read_mesh(path)
    np.testing.assert_array_equal(back.nodes, body.mesh.nodes)
    assert [kind for kind, _ in back.cells] == ["quad9"]
    np.testing.assert_array_equal(back.cells[0][1], body.mesh.cells[0][1])
    np.testing.assert_array_equal(back.sets["FLANK"], np.unique(body.mesh.flank_edges))
    np.testing.assert_array_equal(back.sets["BORE"], body.mesh.bore_nodes)
    assert body.mesh.bore_nodes.size > 10
    for name, nodes in (("CUT_LEFT", body.mesh.left_nodes), ("CUT_RIGHT", body.mesh.right_nodes)):
        assert set(nodes) <= set(back.sets[name])
        assert set(back.sets[name]) - set(nodes) <= set(body.mesh.bore_nodes)


def test_mirrored_pair_gives_the_mirrored_result(tmp_path: Path) -> None:
    """A pair drawn for the other sense of rotation is the same pair."""
    straight = solve(mesh_scene())
    raw = {}
    for path in (PINION, WHEEL):
        mesh = meshio.read(path)
        mesh.points[:, 1] *= -1
        order = [0, 3, 2, 1, 7, 6, 5, 4, 8]
        mesh.cells[0].data[:] = mesh.cells[0].data[:, order]
        raw[path] = mesh
    for path, mesh in raw.items():
        meshio.write(tmp_path / path.name, mesh, file_format="gmsh22", binary=False)
    mirrored = solve(mesh_scene(tmp_path / PINION.name, tmp_path / WHEEL.name))
    assert any("mirror image" in warning for warning in mirrored.warnings)
    np.testing.assert_allclose(mirrored.rotation_rad, straight.rotation_rad, rtol=1e-9)


def line_of(error: SceneError) -> str:
    text = str(error)
    assert "\n" not in text
    return text


def changed(tmp_path: Path, change) -> Path:
    """A copy of the pinion's mesh after change(mesh)."""
    mesh = meshio.read(PINION)
    change(mesh)
    path = tmp_path / "changed.msh"
    meshio.write(path, mesh, file_format="gmsh22", binary=False)
    return path


def refused(scene: fl.Scene) -> MeshError:
    with pytest.raises(SceneError) as caught:
        build_bodies(scene)
    return caught.value


def test_missing_file(tmp_path: Path) -> None:
    error = refused(mesh_scene(tmp_path / "nowhere.msh"))
    assert error.key == "body_1.file"
    assert error.found == "no such file"
    assert "nowhere.msh" in line_of(error)


def test_unreadable_file(tmp_path: Path) -> None:
    path = tmp_path / "broken.msh"
    path.write_text("this is not a mesh\n")
    error = refused(mesh_scene(path))
    assert error.key == "body_1.file"
    assert "readable mesh" in error.expected
    assert "broken.msh" in line_of(error)


def test_half_a_file(tmp_path: Path) -> None:
    path = tmp_path / "half.msh"
    path.write_text(PINION.read_text()[:20000])
    error = refused(mesh_scene(path))
    assert error.key == "body_1.file"
    assert "half.msh" in line_of(error)


@pytest.mark.parametrize("key", ["flank_set", "fixed_set"])
def test_missing_set_names_those_that_exist(key: str) -> None:
    error = refused(mesh_scene(**{key: "NOT_THERE"}))
    assert error.key == f"body_1.{key}"
    assert "NOT_THERE" in error.expected
    assert "BORE, CUT_LEFT, CUT_RIGHT, FLANK" in error.found


def test_flank_that_is_held_is_refused() -> None:
    error = refused(mesh_scene(fixed_set="FLANK"))
    assert error.key == "body_1.fixed_set"
    assert error.found == "19 nodes of 'FLANK' on it"


def test_folder_instead_of_a_file(tmp_path: Path) -> None:
    assert refused(mesh_scene(tmp_path)).found == "a folder"


def test_missing_cut_set() -> None:
    error = refused(mesh_scene(cut_sets=["CUT_LEFT", "NOT_THERE"]))
    assert error.key == "body_1.cut_sets"
    assert "NOT_THERE" in error.expected


def test_cut_faces_that_do_not_match(tmp_path: Path) -> None:
    def shift(mesh: meshio.Mesh) -> None:
        nodes = np.unique(mesh.cells[-1].data)
        radius = np.hypot(*mesh.points[nodes, :2].T)
        moved = nodes[np.argsort(radius)[len(nodes) // 2]]
        mesh.points[moved, :2] *= 1.002

    error = refused(mesh_scene(changed(tmp_path, shift)))
    assert error.key == "body_1.cut_sets"
    assert "360/16" in error.expected
    apart = float(re.search(r"up to (\S+) mm", error.found)[1])
    assert 0.02 < apart < 0.2


def test_wrong_number_of_teeth_is_a_cut_that_does_not_match() -> None:
    error = refused(mesh_scene(teeth=17))
    assert error.key == "body_1.cut_sets"
    assert "360/17" in error.expected


def test_inverted_element_is_counted_and_placed(tmp_path: Path) -> None:
    def fold(mesh: meshio.Mesh) -> None:
        cell = mesh.cells[0].data[5]
        centre = mesh.points[cell[8]].copy()
        mesh.points[cell[8]] = mesh.points[cell[0]] + 3 * (mesh.points[cell[0]] - centre)

    error = refused(mesh_scene(changed(tmp_path, fold)))
    assert error.key == "body_1.file"
    assert "positive Jacobian" in error.expected
    assert "1 inverted of" in error.found
    assert "mm" in error.found


def test_flank_in_two_pieces(tmp_path: Path) -> None:
    def cut(mesh: meshio.Mesh) -> None:
        # take one edge in the middle of the flank out of its group (and its shared nodes with it)
        k = next(k for k, tags in enumerate(mesh.cell_data["gmsh:physical"]) if tags[0] == 2)
        mesh.cell_data["gmsh:physical"][k][3:5] = 99
        mesh.cell_data["gmsh:geometrical"][k][3:5] = 99

    error = refused(mesh_scene(changed(tmp_path, cut)))
    assert error.key == "body_1.flank_set"
    assert "2 separate lines" in error.found


def test_solid_elements_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "solid.vtu"
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    meshio.write(path, meshio.Mesh(points, [("tetra", np.array([[0, 1, 2, 3]]))]))
    error = refused(mesh_scene(path))
    assert error.key == "body_1.file"
    assert "plane elements" in error.expected
    assert error.found == "1 tetra"


def test_profile_that_does_not_fit_says_by_how_much() -> None:
    profile = {"module_mm": 4.5, "profile_shift": 0.5, "tip_diameter_mm": 82.46}
    error = refused(mesh_scene(profile=profile))
    assert error.key == "body_1.profile"
    assert "mm beside it" in error.found


@pytest.mark.parametrize("distance", [50.0, 91.0])
def test_misplaced_bodies_are_refused_or_named(distance: float) -> None:
    """Regression: a wrong centre distance gave numbers without a word."""
    scene = mesh_scene()
    pair = dataclasses.replace(
        scene, pair=type(scene.pair)(center_distance_mm=distance, face_width_mm=14)
    )
    if distance == 91.0:
        (note,) = [w for w in solve(pair).warnings if "at the angles of the files" in w]
        overlap = float(re.search(r"overlap by ([\d.]+) um", note)[1])
        # half a millimetre nearer: about 0.5 mm times the sine of the working pressure angle
        assert overlap == pytest.approx(500 * np.sin(np.radians(22.0)), rel=0.15)
        return
    with pytest.raises(fl.errors.FlankloadError) as caught:
        solve(pair)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("whole", [False, True])
def test_the_wrong_flank_is_blamed_not_the_centre_distance(tmp_path: Path, whole: bool) -> None:
    """Regression: the coast flank, taken in its mirror image, was half a pitch away."""

    def name_the_coast_flank(mesh: meshio.Mesh) -> None:
        tags = mesh.cell_data["gmsh:physical"]
        (lines,) = (k for k, block in enumerate(mesh.cells) if block.type == "line3")
        flank = mesh.cells[lines].data[tags[lines] == 2]
        angles = np.arctan2(mesh.points[:, 1], mesh.points[:, 0])
        cuts = [angles[mesh.cells[lines].data[tags[lines] == tag]].mean() for tag in (4, 5)]
        turn = np.exp(1j * sum(cuts))  # twice the centre line of the tooth
        places = mesh.points[:, 0] + 1j * mesh.points[:, 1]
        mate = np.abs(turn * places.conj()[:, None] - places).argmin(axis=1)
        mesh.cells.append(meshio.CellBlock("line3", mate[flank][:, [1, 0, 2]]))
        mesh.field_data["COAST"] = np.array([6, 1])
        for name in ("gmsh:physical", "gmsh:geometrical"):
            mesh.cell_data[name].append(np.full(len(flank), 6))

    path = changed(tmp_path, name_the_coast_flank)
    # the sector by itself is a whole body with one flank
    name, named = ("flank_sets", ["COAST"]) if whole else ("flank_set", "COAST")
    with pytest.raises(SceneError) as caught:
        solve(mesh_scene(path, **{name: named}))
    assert caught.value.key == f"body_1.{name}"
    assert "faces counter-clockwise" in caught.value.expected
    assert caught.value.found.startswith("'COAST', which faces clockwise: in their mirror image")
    solve(mesh_scene(path))


def test_linear_elements_are_raised_and_noted(tmp_path: Path) -> None:
    """The same nodes as four times as many linear elements: coarser, but the same body."""

    def linear(mesh: meshio.Mesh) -> None:
        data = mesh.cells[0].data
        quarters = [[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]]
        blocks = [("quad", np.vstack([data[:, q] for q in quarters]))]
        tags = [np.ones(4 * len(data), dtype=int)]
        for block, marks in zip(mesh.cells[1:], mesh.cell_data["gmsh:physical"][1:], strict=True):
            halves = np.vstack([block.data[:, [0, 2]], block.data[:, [2, 1]]])
            blocks.append(("line", halves))
            tags.append(np.concatenate([marks, marks]))
        mesh.cells = [meshio.CellBlock(kind, data) for kind, data in blocks]
        mesh.cell_data = {"gmsh:physical": tags, "gmsh:geometrical": tags}

    path = changed(tmp_path, linear)
    found = solve(mesh_scene(path))
    assert any("become quadratic" in warning for warning in found.warnings)
    exact = solve(mesh_scene())
    # straight edges of 0.5 mm leave the flank by up to 15 um at its foot
    interior = ~exact.corner_contact.any(axis=1) & ~found.corner_contact.any(axis=1)
    np.testing.assert_allclose(
        found.rotation_rad[interior], exact.rotation_rad[interior], rtol=0.05
    )
