"""Fields of the loaded bodies: the displacements of the run, equilibrium, stress, files."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest

import flankload as fl
from flankload.base.rotation import turned
from flankload.bodies import SectorMesh, WholeMesh
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.fe_error import recovered_strains
from flankload.elasticity.finite_elements import lame_parameters
from flankload.elasticity.loaded_body import loaded_body
from flankload.elasticity.near_field import logarithm_strength, mode_loads, mode_norms
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.loaded_bodies import BodyOfPair, field_bodies
from tests.support.made_up_result import made_up_result
from tests.support.pair_scenes import EXTERNAL, RING_PAIR
from tests.support.paths import SCENES
from tests.support.solving import solve
from tests.support.tolerances import SOLVER

#: The contact forces of a result act on undeformed flanks; body 1 has turned by up to 50 um on a
#: radius of 30 mm, so the levers of body 2 differ by as much.
LEVERS = 2e-3
#: Forces on flanks of elements whose normals, but not places, are those of a relief of 60 um;
#: measured 3.2e-5 beside a rounding.
RELIEVED = 5e-5
#: Stress of the elements of a tooth against that of the run at its Gauss points, relative: strains
#: recovered at the nodes of a free surface are extrapolated over half an element.
STRESS = 0.05
MODES = 5
COARSE = {"estimate": False, "tangents": False, "flank_element_mm": 2.0}
DEFAULT = {"estimate": False, "tangents": False}


def scene_of(pair: dict = EXTERNAL, torque_Nm: float = 302.0, **more: object) -> fl.Scene:
    return fl.Scene.from_dict(
        {
            **pair,
            "load": {"torque_Nm": torque_Nm},
            "positions": {"count": 4},
            "accuracy": COARSE,
            **more,
        }
    )


def solved(scene: fl.Scene) -> fl.Result:
    found = solve(scene)
    assert isinstance(found, fl.Result)
    return found


def bodies_of(scene: fl.Scene) -> list[BodyOfPair]:
    found = list(field_bodies(scene).values())
    assert all(isinstance(body, BodyOfPair) for body in found)
    return found  # type: ignore[return-value]


def moment_Nm(body: BodyOfPair, result: fl.Result, p: int) -> float:
    """Moment of the nodal forces about the axis of the body."""
    fields = body.at(result, p)
    center = np.array([body.number * result.drawing.center_distance_mm, 0.0, 0.0])
    (x, y, _), (f_x, f_y, _) = (fields.points_mm - center).T, fields.force_N.T
    return float((x * f_y - y * f_x).sum() / 1000.0)


@pytest.mark.parametrize("z", [0, 1])
@pytest.mark.parametrize("pair", [EXTERNAL, RING_PAIR], ids=["external", "internal"])
def test_other_teeth_move_as_in_the_compliance_of_the_run(pair: dict, z: int) -> None:
    """Other teeth have no near field, so their compliance is the displacement of the elements."""
    scene = scene_of(pair)
    assembly = build_bodies(scene)
    body = (assembly.body_1, assembly.body_2)[z].for_elements()
    assert isinstance(body.mesh, SectorMesh)
    loaded = loaded_body(body, "strain")
    wanted = flank_compliance(body, JobOptions(n_modes=MODES, plane="strain")).smooth
    loads = mode_loads(body.mesh, body.mode_range_mm, MODES)
    norms = mode_norms(body.mode_range_mm, MODES)
    tooth, mode = 3, 2
    load = loads[:, mode].reshape(-1, 2) / norms[mode]
    forces = np.zeros((len(loaded.nodes), 2))
    np.add.at(forces, loaded.numbers[tooth], turned(load, tooth * 2 * np.pi / body.teeth))
    moved = loaded.solve(forces[:, None])[:, 0]
    for k in range(1, body.teeth):
        number = (tooth + k) % body.teeth
        own = turned(moved[loaded.numbers[number]], -number * 2 * np.pi / body.teeth)
        found = loads.T @ own.ravel() / norms
        np.testing.assert_allclose(found, wanted[k][:, mode], atol=SOLVER * np.abs(wanted).max())


def test_a_ring_of_sectors_moves_as_its_elements_meshed_as_a_whole() -> None:
    scene = scene_of()
    body = build_bodies(scene).body_1
    loaded = loaded_body(body, "strain")
    mesh = loaded.body.mesh
    assert isinstance(mesh, SectorMesh)
    fixed = np.unique(loaded.numbers[:, mesh.fixed_nodes])
    whole = WholeMesh(loaded.nodes, loaded.cells, fixed, ())
    forces = np.zeros((len(loaded.nodes), 2))
    forces[loaded.numbers[2, mesh.flank_edges[1]]] = [3.0, -5.0]
    forces[loaded.numbers[0, mesh.right_nodes[-1]]] = [1.0, 2.0]
    found = loaded.solve(forces[:, None])
    wanted = loaded_body(replace(loaded.body, mesh=whole), "strain").solve(forces[:, None])
    np.testing.assert_allclose(found, wanted, atol=SOLVER * np.abs(wanted).max())


def test_nodal_forces_with_friction_are_in_equilibrium_with_the_torques() -> None:
    scene = scene_of(effects={"friction_coefficient": 0.1})
    result = solved(scene)
    assert result.friction is not None
    one, two = bodies_of(scene)
    for p in (0, 2):
        assert moment_Nm(one, result, p) == pytest.approx(-302.0, rel=1e-5)
        on_2 = abs(float(result.friction.torque_2_Nm[p]))
        assert abs(moment_Nm(two, result, p)) == pytest.approx(on_2, rel=LEVERS)
        forces = [body.at(result, p).force_N.sum(axis=0) for body in (one, two)]
        np.testing.assert_allclose(forces[0], -forces[1], rtol=1e-12, atol=0)


@pytest.mark.parametrize("tip", [{}, {"tip_radius_mm": 0.4}], ids=["sharp", "rounded"])
def test_forces_on_relieved_flanks_act_at_their_places_on_the_elements(tip: dict) -> None:
    """A relieved flank is longer; stretched over it, levers change by 2.5e-4 to 7e-4."""
    scene = scene_of().replace(
        {
            **{"body_1.tip_relief_um": 60.0, "body_1.tip_relief_start_diameter_mm": 80.0},
            **{f"body_1.{key}": value for key, value in tip.items()},
        }
    )
    result = solved(scene)
    for p in range(4):
        assert moment_Nm(bodies_of(scene)[0], result, p) == pytest.approx(-302.0, rel=RELIEVED)


def test_forces_on_coast_flanks_are_part_of_the_equilibrium() -> None:
    press_fit = fl.read_scene(SCENES / "spline_press_fit.toml")
    changes = {f"accuracy.{key}": value for key, value in DEFAULT.items()}
    scene = press_fit.replace({**changes, "accuracy.flank_element_mm": 0.5})
    result = solved(scene)
    assert result.coast is not None
    assert (result.coast.force_N > 0).any()
    for body in bodies_of(scene):
        assert abs(moment_Nm(body, result, 0)) == pytest.approx(100.0, rel=LEVERS)


def test_the_work_of_the_contact_forces_is_that_of_the_rotation() -> None:
    """With one pair in contact, torque times rotation is the work of the forces on both bodies.

    Two parts are missing in the elements, in units of c0 F²/b (c0 of both bodies): the gap beside
    the middle of a Hertz contact, whose work is F a²/(8 R), a quarter; and the compliance within an
    element, which is stiffer than a half-plane by ln(element/contact width), less than 3/4.
    """
    scene = scene_of(accuracy=DEFAULT)
    result = solved(scene)
    bodies = bodies_of(scene)
    alone = np.flatnonzero((result.loaded_pairs == 1) & ~result.corner_contact.any(axis=1))
    assert alone.size
    for p in alone:
        work = 0.0
        for body in bodies:
            fields = body.at(result, p)
            work += float((fields.force_N * fields.displacement_mm).sum())
        of_torque = 1000.0 * result.torque_Nm * result.turned_by_load_rad[p]
        strength = sum(logarithm_strength(body.body.material, "strain") for body in bodies)
        unit = strength * float((result.site_force_N[p] ** 2).sum()) / result.face_width_mm
        assert 0.25 < (of_torque - work) / unit < 1.0
        assert work > 0.9 * of_torque


def test_stress_in_the_root_is_that_of_the_run() -> None:
    scene = scene_of(effects={"root_stress": True}, accuracy=DEFAULT)
    result = solved(scene)
    body = bodies_of(scene)[0]
    p = int(np.argmin(result.loaded_pairs))
    s = int(np.argmax(result.site_force_N[p]))
    root = result.root_stress[0]
    assert root is not None
    wanted = root.tension.stress_MPa[p, s]
    fields = body.at(result, p)
    radius = np.hypot(*fields.points_mm.T[:2])
    # the first principal stress of nodes near the place of the largest tension
    xx, yy, _, xy, _, _ = fields.stress_MPa.T
    first = 0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy)
    near = np.abs(radius - root.tension.radius_mm[p, s]) < 0.5
    assert first[near].max() == pytest.approx(wanted, rel=STRESS)


def test_stress_is_that_of_the_turned_body() -> None:
    """Hooke's law for the displacements in the world frame, at an angle far from 0."""
    scene = scene_of(positions={"angles_deg": [0.0]})
    result = solved(scene)
    body = bodies_of(scene)[0]
    drawing = replace(result.drawing, angle_1=np.array([0.7]))
    fields = body.at(replace(result, drawing=drawing), 0)
    moved = fields.displacement_mm[:, :2].reshape(-1, 1)
    strain = recovered_strains(fields.points_mm[:, :2], body.loaded.cells, moved)
    first, second = lame_parameters(body.body.material, "strain")
    volume = first * (strain[:, 0] + strain[:, 1])
    wanted = [volume + 2 * second * strain[:, 0], volume + 2 * second * strain[:, 1], volume]
    wanted = np.stack([*wanted, second * strain[:, 2]], axis=1)
    largest = np.abs(wanted).max()
    np.testing.assert_allclose(fields.stress_MPa[:, :4], wanted, atol=SOLVER * largest)


def test_the_pressure_on_flank_nodes_carries_the_force() -> None:
    scene = scene_of()
    result = solved(scene)
    body = bodies_of(scene)[0]
    pressure = body.at(result, 0).contact_pressure_MPa
    total = 0.0
    for tooth in range(16):
        nodes, widths = body.loaded.flank_widths(tooth)
        total += float(pressure[nodes] @ widths) * result.face_width_mm
    assert total == pytest.approx(result.site_force_N[0].sum(), rel=1e-12)


def test_files_read_back_and_their_collection_lists_them(tmp_path: Path) -> None:
    scene = scene_of()
    result = solved(scene)
    said = fl.write_vtu(scene, result, tmp_path, positions=[2, 0])
    assert [line.split(":")[0] for line in said] == ["body_1", "body_2"]
    sets = ElementTree.parse(tmp_path / "loaded_pair.pvd").getroot().findall(".//DataSet")
    assert [row.get("file") for row in sets] == [
        f"{name}_{p:04d}.vtu" for p in (2, 0) for name in ("body_1", "body_2", "contacts")
    ]
    assert float(sets[0].get("timestep", "")) == np.degrees(result.position_rad[2])
    body = bodies_of(scene)[1]
    fields = body.at(result, 2)
    mesh = meshio.read(tmp_path / "body_2_0002.vtu")
    np.testing.assert_array_equal(mesh.points, fields.points_mm)
    assert sum(len(block.data) for block in mesh.cells) == sum(
        len(data) for _, data in body.loaded.cells
    )
    single = np.finfo(np.float32).eps
    found = mesh.point_data["displacement_mm"]
    np.testing.assert_allclose(found, fields.displacement_mm, rtol=single)
    xx, yy, zz, _, yz, xz = mesh.point_data["stress_MPa"].T
    np.testing.assert_allclose(mesh.point_data["stress_MPa"], fields.stress_MPa, rtol=single)
    assert not yz.any()
    assert not xz.any()
    np.testing.assert_allclose(zz, 0.3 * (xx + yy), atol=1e-4)
    contacts = meshio.read(tmp_path / "contacts_0002.vtu")
    table = result.pairs(2)
    np.testing.assert_array_equal(contacts.cell_data["pressure_MPa"][0], table.pressure_MPa)
    np.testing.assert_allclose(
        contacts.points[::2, 0] / 2 + contacts.points[1::2, 0] / 2, table.x_mm
    )


def test_several_torques_have_a_folder_each(tmp_path: Path) -> None:
    scene = scene_of(load={"torque_Nm": [100.0, 302.0]})
    fl.write_vtu(scene, solve(scene), tmp_path, positions=[0])
    assert {path.name for path in tmp_path.iterdir()} == {"torque_100_Nm", "torque_302_Nm"}


def test_bodies_without_elements_have_a_line_with_the_reason(tmp_path: Path) -> None:
    rigid = scene_of({**EXTERNAL, "body_2": {**EXTERNAL["body_2"], "rigid": True}})
    assert field_bodies(rigid)["body_2"] == "rigid, so it has no fields"
    given = fl.read_scene(SCENES / "external_gear_compliance.toml")
    assert "comes from a file" in str(field_bodies(given)["body_1"])
    belt = fl.read_scene(SCENES / "belt.toml")
    (line,) = fl.write_vtu(belt, made_up_result(), tmp_path / "none")
    assert line.startswith("no fields: the scene has ")
    assert not (tmp_path / "none").exists()


def test_a_position_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        SceneError, match=r"--vtu-positions: expected indices from 0 to 31, found 32"
    ):
        fl.write_vtu(scene_of(), made_up_result(), tmp_path, positions=[32])


def test_torques_that_differ_little_have_folders_of_their_own(tmp_path: Path) -> None:
    near = [made_up_result(torque_Nm=torque) for torque in (302.0, 302.0001)]
    given = fl.read_scene(SCENES / "external_gear_compliance.toml")
    fl.write_vtu(given, near, tmp_path, positions=[0])
    assert len(list(tmp_path.iterdir())) == 2
    with pytest.raises(fl.InputError, match=r"^results: expected a Result or a sequence"):
        fl.write_vtu(scene_of(), 3, tmp_path)  # type: ignore[arg-type]


def test_fields_do_not_replace_what_the_scene_reads(tmp_path: Path) -> None:
    """Regression: the field of the first position replaced the mesh of the scene."""
    mesh = tmp_path / "body_1_0000.vtu"
    body = {"kind": "mesh", "file": mesh.name, "teeth": 16, "reference_radius_mm": 33.8}
    body |= {"flank_set": "FLANK", "fixed_set": "BORE"}
    scene = fl.Scene.from_dict(
        {**EXTERNAL, "body_1": body, "load": {"torque_Nm": 302.0}}, file=tmp_path / "a.toml"
    )
    line = f"folder: expected a folder whose files do not replace {mesh} \\(that of body_1.file\\)"
    with pytest.raises(SceneError, match=line):
        fl.write_vtu(scene, made_up_result(), tmp_path)
    assert not list(tmp_path.iterdir())
