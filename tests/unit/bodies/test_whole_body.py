"""Bodies meshed as a whole: the numbers of their sector in every format; places of flanks."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from flankload.base.array_archive import archive_of
from flankload.bodies import WholeMesh
from flankload.bodies.imported.body_file import write_body
from flankload.cli import main
from flankload.elasticity.modal_arrays import modal_arrays
from flankload.errors import ComplianceFileError, SceneError
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.loaded_bodies import field_bodies
from flankload.meshes.io import read_mesh, write_mesh
from flankload.meshes.plane_mesh import boundary_edges
from flankload.scene.accuracy import Accuracy
from flankload.scene.mesh import ComplianceBody
from flankload.scene.pair import Positions
from tests.support.mesh_files import (
    COARSE_MM,
    COARSE_PINION,
    COARSE_WHEEL,
    delaunay_sector,
    edges_of,
    sector,
    turned,
    whole,
    whole_of,
    write_gmsh_41,
)
from tests.support.paths import SCENES
from tests.support.solving import solve
from tests.support.tolerances import SOLVER

#: Another mesher's nodes, a curve through them: wanted of the rotation.
OTHER_MESHER = 3e-3

RADIUS = {"body_1": 33.8289343, "body_2": 50.7434014}
PROFILE = {
    "body_1": {"module_mm": 4.5, "profile_shift": 0.182, "tip_diameter_mm": 82.46},
    "body_2": {"module_mm": 4.5, "profile_shift": 0.171, "tip_diameter_mm": 118.36},
}


def scene_of(body_1: dict, body_2: dict, *, profile: bool = False, count: int = 4) -> fl.Scene:
    bodies = {}
    for key, body in (("body_1", body_1), ("body_2", body_2)):
        more = {"profile": PROFILE[key]} if profile else {"reference_radius_mm": RADIUS[key]}
        bodies[key] = {**more, **body}
    return fl.Scene.from_dict(
        {
            **bodies,
            "pair": {"center_distance_mm": 91.5, "face_width_mm": 14},
            "load": {"torque_Nm": 302},
            "positions": {"count": count},
            "accuracy": {"estimate": False, "tangents": False},
        }
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both bodies as sector in every format that is written and in gmsh 4.1, and as a whole."""
    out = tmp_path_factory.mktemp("meshes")
    for name, path, teeth in (("pinion", COARSE_PINION, 16), ("wheel", COARSE_WHEEL, 24)):
        parts = whole_of(read_mesh(path), teeth)
        for suffix in ("msh", "inp"):
            write_mesh(out / f"{name}_whole.{suffix}", *parts)
    pair = build_bodies(scene_of(sector("body_1", COARSE_PINION), sector("body_2", COARSE_WHEEL)))
    for name, body in (("pinion", pair.body_1), ("wheel", pair.body_2)):
        for suffix in ("msh", "vtu", "inp"):
            write_body(out / f"{name}.{suffix}", body.mesh)
        raw = read_mesh(out / f"{name}.msh")
        sets = {set_: edges_of(raw, set_) for set_ in raw.sets if set_ != "BODY"}
        write_gmsh_41(out / f"{name}_41.msh", raw.nodes, raw.cells, sets)
    return out


@pytest.fixture(scope="module")
def by_nodes() -> fl.Result:
    """Both sectors of the examples, the curve through their nodes."""
    return solve(scene_of(sector("body_1", COARSE_PINION), sector("body_2", COARSE_WHEEL)))


def assert_same(found: fl.Result, expected: fl.Result) -> None:
    total = expected.site_force_N.sum(axis=1).max()
    np.testing.assert_allclose(found.rotation_rad, expected.rotation_rad, rtol=SOLVER, atol=0)
    np.testing.assert_allclose(
        found.site_force_N, expected.site_force_N, rtol=0, atol=SOLVER * total
    )


@pytest.mark.parametrize("name", ["{}.msh", "{}.vtu", "{}.inp", "{}_41.msh"])
def test_sector_gives_the_same_in_every_format(
    name: str, folder: Path, by_nodes: fl.Result
) -> None:
    files = (folder / name.format("pinion"), folder / name.format("wheel"))
    found = solve(scene_of(sector("body_1", files[0]), sector("body_2", files[1])))
    assert_same(found, by_nodes)


def test_whole_pinion_has_the_results_of_its_sector(folder: Path, by_nodes: fl.Result) -> None:
    """One computation of the whole body against the ring closed over the sectors.

    Whole bodies in the other formats are written and read by the command below.
    """
    found = fl.solve(
        scene_of(whole("body_1", folder / "pinion_whole.inp"), sector("body_2", COARSE_WHEEL))
    )
    assert_same(found, by_nodes)
    assert found.cost["fe_factorisations"] == 2
    assert found.cost["unit_loads_normal"] == (16 + 1) * 3


def test_whole_pinion_over_its_width_is_its_sector(folder: Path) -> None:
    """At the degree that displacements on the cuts of a sector have."""
    found, sectors = (
        solve(over_width(body))
        for body in (
            whole("body_1", folder / "pinion_whole.inp"),
            sector("body_1", COARSE_PINION),
        )
    )
    assert_same(found, sectors)
    loads, wanted = (each.slice_line_load_N_per_mm for each in (found, sectors))
    np.testing.assert_allclose(loads, wanted, atol=SOLVER * wanted.max())
    fields = [
        field_bodies(over_width(body).replace({"body_2.rigid": True}))["body_1"].at(result, 0)  # type: ignore[union-attr]
        for body, result in (
            (whole("body_1", folder / "pinion_whole.inp"), found),
            (sector("body_1", COARSE_PINION), sectors),
        )
    ]
    work, wanted = ((each.force_N * each.displacement_mm).sum() for each in fields)
    assert work == pytest.approx(wanted, rel=SOLVER)
    stress, wanted = (each.von_mises_MPa.max() for each in fields)
    assert stress == pytest.approx(wanted, rel=SOLVER)


def over_width(body_1: dict) -> fl.Scene:
    """A crowned pinion on a wheel that is a sector, in three dimensions."""
    tree = scene_of({**body_1, "lead_crowning_um": 10.0}, sector("body_2", COARSE_WHEEL)).to_dict()
    more = {"axial_degree": 4, "load_degree_z": 0, "slices": 6}
    return fl.Scene.from_dict(
        tree | {"accuracy": tree["accuracy"] | more, "positions": {"count": 1}}
    )


def test_both_whole_bodies_with_profiles_agree_with_parametric_ones(folder: Path) -> None:
    found = solve(
        scene_of(
            whole("body_1", folder / "pinion_whole.inp"),
            whole("body_2", folder / "wheel_whole.msh"),
            profile=True,
        )
    )
    parameters = dataclasses.replace(
        fl.read_scene(SCENES / "external_gear.toml"),
        positions=Positions(count=4),
        accuracy=Accuracy(flank_element_mm=COARSE_MM, estimate=False, tangents=False),
    )
    assert_same(found, solve(parameters))


def test_order_of_flanks_behind_the_first_does_not_matter(
    folder: Path, by_nodes: fl.Result
) -> None:
    names = ["FLANK_0", *(f"FLANK_{k}" for k in range(15, 0, -1))]
    body = whole("body_1", folder / "pinion_whole.msh", flank_sets=names)
    assert_same(solve(scene_of(body, sector("body_2", COARSE_WHEEL))), by_nodes)


def test_few_flanks_of_a_whole_body_suffice_where_they_carry(
    folder: Path, by_nodes: fl.Result
) -> None:
    names = ["FLANK_0", "FLANK_1", "FLANK_2", "FLANK_15", "FLANK_14"]
    body = whole("body_1", folder / "pinion_whole.msh", flank_sets=names, teeth=16)
    found = solve(scene_of(body, sector("body_2", COARSE_WHEEL)))
    assert_same(found, by_nodes)
    assert any("5 of 16 teeth have a flank" in warning for warning in found.warnings)
    assert not any("name their flanks" in warning for warning in found.warnings)


def test_flank_that_carries_alone_because_others_are_not_named_is_said(folder: Path) -> None:
    body = whole("body_1", folder / "pinion_whole.msh", flank_sets=["FLANK_0"], teeth=16)
    found = solve(scene_of(body, sector("body_2", COARSE_WHEEL)))
    (warning,) = [w for w in found.warnings if "name their flanks" in w]
    assert warning.startswith(
        "teeth of body_1 next to the loaded pairs 0 may carry load, but have no flank"
    )


def test_mirrored_whole_body_gives_the_mirrored_result(tmp_path: Path, by_nodes: fl.Result) -> None:
    """Mirrored coordinates alone: all elements come clockwise, all flanks face the other way."""
    mirror = np.array([1.0, -1.0])
    nodes, cells, sets = whole_of(read_mesh(COARSE_PINION), 16)
    write_mesh(tmp_path / "whole.inp", nodes * mirror, cells, sets)
    raw = read_mesh(COARSE_WHEEL)
    own = {name: edges_of(raw, name) for name in raw.sets if name != "BODY"}
    write_mesh(tmp_path / "sector.inp", raw.nodes * mirror, raw.cells, own)
    found = solve(
        scene_of(whole("body_1", tmp_path / "whole.inp"), sector("body_2", tmp_path / "sector.inp"))
    )
    assert sum("mirror image" in warning for warning in found.warnings) == 2
    assert_same(found, by_nodes)


def test_flank_beside_its_share_is_a_pitch_deviation(tmp_path: Path) -> None:
    """A flank moved in the mesh, against the same error named in the scene of the sector."""
    raw = read_mesh(COARSE_PINION)
    nodes, cells, sets = whole_of(raw, 16)
    moved = nodes.copy()
    error_um = 8.0
    flank = np.unique(sets["FLANK_0"])
    moved[flank] = turned(nodes[flank], error_um / 1000 / RADIUS["body_1"])
    write_mesh(tmp_path / "moved.msh", moved, cells, sets)
    body = whole("body_1", tmp_path / "moved.msh")
    found = solve(scene_of(body, sector("body_2", COARSE_WHEEL), count=8))
    assert any("used as pitch deviations" in warning for warning in found.warnings)
    # pair 0 is the first of the list; metal further on at tooth 0 touches early
    errors = [error_um] + [0.0] * 15
    named = solve(
        scene_of(
            sector("body_1", COARSE_PINION, pitch_errors_um=errors),
            sector("body_2", COARSE_WHEEL),
            count=8,
        )
    )
    smooth = ~(found.corner_contact.any(axis=1) | named.corner_contact.any(axis=1))
    # 8 um of steel more or less on a tooth of 7 mm: elements change by a thousandth
    np.testing.assert_allclose(
        found.rotation_rad[smooth], named.rotation_rad[smooth], rtol=2e-3, atol=0
    )


def test_compliance_of_a_whole_body_is_symmetric_and_not_turned(
    folder: Path,
) -> None:
    from flankload.elasticity.compliance import JobOptions, flank_compliance

    pair = build_bodies(
        scene_of(whole("body_1", folder / "pinion_whole.msh"), sector("body_2", COARSE_WHEEL))
    )
    assert isinstance(pair.body_1.mesh, WholeMesh)
    assert pair.body_1.flank_turns_rad == ()
    found = flank_compliance(pair.body_1, JobOptions(n_modes=4, plane="strain"))
    assert found.job.asymmetry < SOLVER
    assert found.smooth.shape == (256, 4, 4)


def test_outline_of_a_whole_body_is_one_pitch_of_its_contour(folder: Path) -> None:
    pair = build_bodies(
        scene_of(whole("body_1", folder / "pinion_whole.msh"), sector("body_2", COARSE_WHEEL))
    )
    outline = pair.body_1.outline
    np.testing.assert_allclose(
        outline[-1], turned(outline[:1], 2 * np.pi / 16)[0], rtol=0, atol=1e-9
    )
    assert np.hypot(*outline.T).max() == pytest.approx(41.23, rel=1e-6)


def test_another_mesher_agrees_within_its_deviation(tmp_path: Path) -> None:
    gears = build_bodies(fl.read_scene(SCENES / "external_gear.toml"))
    for name, body, turn in (
        ("pinion", gears.body_1, gears.pairing.turns_at_zero_rad[0]),
        ("wheel", gears.body_2, gears.pairing.turns_at_zero_rad[1]),
    ):
        write_mesh(tmp_path / f"{name}.inp", *delaunay_sector(body, 0.8, turn))
    files = [
        sector(key, tmp_path / f"{name}.inp")
        for key, name in (("body_1", "pinion"), ("body_2", "wheel"))
    ]
    exact = solve(scene_of(*files, profile=True))
    found = solve(scene_of(*files))
    parameters = dataclasses.replace(
        fl.read_scene(SCENES / "external_gear.toml"),
        positions=Positions(count=4),
        accuracy=Accuracy(estimate=False, tangents=False),
    )
    np.testing.assert_allclose(
        found.rotation_rad, solve(parameters).rotation_rad, rtol=OTHER_MESHER, atol=0
    )
    deviations = [
        float(match[1]) / 1000
        for warning in found.warnings
        if (match := re.search(r"estimated deviation .* (\S+) um", warning))
    ]
    assert len(deviations) == 2
    # the same elements with the exact profile: the rest comes from the curve
    smooth = ~(found.corner_contact.any(axis=1) | exact.corner_contact.any(axis=1))
    apart = np.abs(found.rotation_rad - exact.rotation_rad)[smooth].max() * RADIUS["body_1"]
    assert apart < 2 * sum(deviations)


@pytest.mark.parametrize("suffix", ["msh", "vtu", "inp"])
def test_command_mesh_writes_a_whole_body_that_reads_as_itself(
    suffix: str, folder: Path, tmp_path: Path, by_nodes: fl.Result,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    scene = tmp_path / "pair.toml"
    names = ", ".join(f'"FLANK_{k}"' for k in range(16))
    scene.write_text(
        f"""[body_1]
kind = "mesh"
file = "{folder / "pinion_whole.msh"}"
flank_sets = [{names}]
reference_radius_mm = {RADIUS["body_1"]}
[body_2]
kind = "mesh"
file = "{COARSE_WHEEL}"
teeth = 24
reference_radius_mm = {RADIUS["body_2"]}
[pair]
center_distance_mm = 91.5
face_width_mm = 14
[load]
torque_Nm = 302
""",
        encoding="utf-8",
    )
    assert main(["mesh", str(scene), "-o", str(tmp_path / "out"), "--format", suffix]) == 0
    assert "nodes, the whole body with 16 flanks\n" in capsys.readouterr().out
    found = solve(
        scene_of(
            whole("body_1", tmp_path / "out" / f"body_1.{suffix}"),
            sector("body_2", tmp_path / "out" / f"body_2.{suffix}"),
        )
    )
    assert_same(found, by_nodes)


# --- refused meshes -------------------------------------------------------------------------------
def refusal(body_1: dict) -> SceneError:
    with pytest.raises(SceneError) as caught:
        build_bodies(scene_of(body_1, sector("body_2", COARSE_WHEEL)))
    assert "\n" not in str(caught.value)
    return caught.value


def test_missing_flank_is_named_with_those_that_exist(folder: Path) -> None:
    names = [*(f"FLANK_{k}" for k in range(15)), "FLANK_99"]
    error = refusal(whole("body_1", folder / "pinion_whole.msh", flank_sets=names))
    assert error.key == "body_1.flank_sets[15]"
    assert error.expected == "a set named 'FLANK_99' in the mesh"
    assert "FLANK_15" in error.found


def test_wrong_number_of_teeth_is_flanks_off_their_pitch(folder: Path) -> None:
    error = refusal(whole("body_1", folder / "pinion_whole.msh", teeth=17))
    assert error.key == "body_1.flank_sets[2]"
    assert error.expected == "flanks that are whole pitches (360/17 deg) from 'FLANK_0'"
    assert error.found == "'FLANK_2' at 2.125 pitches"


def test_flanks_of_two_shapes_are_refused(tmp_path: Path) -> None:
    nodes, cells, sets = whole_of(read_mesh(COARSE_PINION), 16)
    flank = np.unique(sets["FLANK_3"])
    away = nodes[flank] - nodes[flank].mean(axis=0)
    nodes[flank] += 0.004 * away[:, ::-1] * np.array([-1.0, 1.0])
    write_mesh(tmp_path / "bent.msh", nodes, cells, sets)
    error = refusal(whole("body_1", tmp_path / "bent.msh"))
    assert error.key == "body_1.flank_sets[3]"
    assert error.expected.startswith("flanks of one shape (to ")
    assert error.found.startswith("'FLANK_3', up to 0.0")


def test_coast_flank_among_the_flanks_is_refused(tmp_path: Path) -> None:
    raw = read_mesh(COARSE_PINION)
    nodes, cells, sets = whole_of(raw, 16)
    # the other side of tooth 3: its mirror image about the middle of the tooth
    flank = nodes[np.unique(sets["FLANK_3"])]
    tooth = 2 * np.pi * 3 / 16
    middle = np.arctan2(*raw.nodes.mean(axis=0)[::-1]) + tooth
    mirrored = turned(turned(flank, -middle) * np.array([1.0, -1.0]), middle)
    distance = np.linalg.norm(nodes[:, None] - mirrored[None], axis=2)
    coast = np.flatnonzero(distance.min(axis=1) < 1e-3)
    edges = boundary_edges(cells)
    sets["FLANK_3"] = edges[np.isin(edges, coast).all(axis=1)]
    assert len(sets["FLANK_3"]) == len(sets["FLANK_2"]) == 4
    write_mesh(tmp_path / "coast.msh", nodes, cells, sets)
    error = refusal(whole("body_1", tmp_path / "coast.msh"))
    assert error.key == "body_1.flank_sets[3]"
    assert error.found == "'FLANK_3' facing the other way"


@pytest.mark.parametrize("named", [16, 5], ids=["all flanks", "five flanks"])
def test_whole_body_comes_back_from_its_compliance_file(
    named: int, folder: Path, tmp_path: Path
) -> None:
    """Bit by bit, flank by flank; without elements."""
    names = [f"FLANK_{k}" for k in (0, 1, 2, 14, 15)] if named == 5 else None
    keys = {} if names is None else {"flank_sets": names, "teeth": 16}
    pinion = {**whole("body_1", folder / "pinion_whole.msh"), **keys}
    scene = scene_of(pinion, sector("body_2", COARSE_WHEEL))
    body = build_bodies(scene).body_1
    found = compliance_of(body, scene)
    path = tmp_path / "body_1.npz"
    path.write_bytes(archive_of(modal_arrays(body, found, plane="strain")))
    from_file = dataclasses.replace(scene, body_1=ComplianceBody(file=str(path)))
    again, expected = fl.solve(from_file), solve(scene)
    assert again.cost["fe_factorisations"] == 1
    np.testing.assert_array_equal(again.rotation_rad, expected.rotation_rad)
    np.testing.assert_array_equal(again.site_force_N, expected.site_force_N)
    spoilt = {"smooth": found.smooth[:-1], "flanks": np.array([0, 3, 2])}
    for name, value in spoilt.items():
        arrays = {**modal_arrays(body, found, plane="strain"), name: value}
        path.write_bytes(archive_of(arrays))
        with pytest.raises(ComplianceFileError, match=f"{name}: expected"):
            fl.solve(from_file)
