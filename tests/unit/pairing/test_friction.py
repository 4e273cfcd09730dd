"""Friction: keys of the scene, modes along the flank, files, results and cost."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import dblquad

import flankload as fl
from flankload.bodies.body import Material
from flankload.cli import main
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.finite_elements import degrees_of, stiffness
from flankload.elasticity.near_field import jump_strength, mode_loads, mode_norms, projected_sign
from flankload.elasticity.sector_closure import close_ring
from flankload.errors import ComplianceFileError, SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.meshes.io import read_mesh, write_mesh
from tests.support.compliance_scenes import (
    FROM_FILE_1,
    FROM_FILE_2,
    assert_same,
    scene_of,
    solved,
    toml_of,
)
from tests.support.condensed import condense
from tests.support.gear_pair import ONE, TWO
from tests.support.mesh_files import COARSE_PINION, sector, whole, whole_of
from tests.support.paths import MESHES
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.plane_stiffness import factored, plane_stiffness
from tests.support.tolerances import ROUND_OFF

RUBS = {"friction_coefficient": 0.1}


# --- near field and compliance --------------------------------------------------------------------
def test_jump_strength_of_both_plane_states() -> None:
    strain, stress = (jump_strength(STEEL, plane) for plane in ("strain", "stress"))
    assert strain == pytest.approx(0.4 * 1.3 / 412000.0, rel=ROUND_OFF)
    assert stress == pytest.approx(0.7 / 412000.0, rel=ROUND_OFF)
    assert jump_strength(Material(1.0, 0.5), "strain") == 0.0


@pytest.mark.parametrize(("a", "b"), [(0, 1), (1, 0), (2, 3), (2, 2), (1, 3)])
def test_projected_sign_agrees_with_quadrature(a: int, b: int) -> None:
    legendre = [np.polynomial.legendre.Legendre.basis(k, [0, 2.5]) for k in (a, b)]
    ahead, _ = dblquad(lambda t, s: legendre[0](s) * legendre[1](t), 0, 2.5, 0, lambda s: s)
    behind, _ = dblquad(lambda t, s: legendre[0](s) * legendre[1](t), 0, 2.5, lambda s: s, 2.5)
    assert projected_sign(5, 2.5)[a, b] == pytest.approx(ahead - behind, abs=1e-9)


def test_surface_sinks_in_front_of_a_load_along_it() -> None:
    """A unit load along the flank over one fine element: -j before it, j behind it."""
    mesh, _ = ring_sector(6, rows=40, columns=120)
    matrix = plane_stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    held = np.concatenate([mesh.fixed_nodes, mesh.left_nodes, mesh.right_nodes])
    free = np.setdiff1d(np.arange(matrix.shape[0]), degrees_of(held))
    m = len(mesh.flank_edges) // 2

    def even_load(edge: int, along: Any) -> np.ndarray:
        first, last, _ = mesh.flank_edges[edge]
        s = mesh.flank_arc_length
        short = type(mesh)(**{**vars(mesh), "flank_edges": mesh.flank_edges[edge : edge + 1]})
        span = (float(s[first]), float(s[last]))
        return mode_loads(short, span, 1, along=along)[:, 0] / (span[1] - span[0])

    moved = np.zeros(matrix.shape[0])
    moved[free] = factored(matrix[free][:, free].tocsc())(even_load(m, "tangent")[free][:, None])[
        :, 0
    ]
    at = {k: float(even_load(m + k, "normal") @ moved) for k in (-4, -2, 2, 4)}
    near, far = at[-2] - at[2], at[-4] - at[4]
    # twice j, the bending of the whole taken out by its slope
    assert (2 * near - far) / (2 * jump_strength(STEEL, "strain")) == pytest.approx(1.0, abs=0.15)


def test_modes_along_the_flank_obey_betti_and_leave_the_normal_ones_alone() -> None:
    mesh, span = ring_sector(6)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    of_normal, of_tangent = (mode_loads(mesh, span, 3, along=a) for a in ("normal", "tangent"))
    both = close_ring(condense(matrix, np.hstack([of_normal, of_tangent]), mesh)[0], 6)
    normal = close_ring(condense(matrix, of_normal, mesh)[0], 6)
    scale = np.abs(both).max()
    mirrored = both[-np.arange(6) % 6].transpose(0, 2, 1)
    np.testing.assert_allclose(both, mirrored, rtol=0, atol=100 * ROUND_OFF * scale)
    np.testing.assert_allclose(both[:, :3, :3], normal, rtol=0, atol=100 * ROUND_OFF * scale)


def test_smooth_part_along_the_flank_fades_with_the_modes() -> None:
    """The jump is removed from the correct side; on the wrong side it would be doubled."""
    body = build_bodies(scene_of()).body_1
    found = flank_compliance(body, JobOptions(n_modes=5, plane="strain", friction=True))
    assert (
        found.job.counters["unit_loads_tangential"] == found.job.counters["unit_loads_normal"] == 5
    )
    assert found.job.counters["fe_factorisations"] == 1
    assert found.tangential.shape == found.smooth.shape
    low, high = body.mode_range_mm
    norms = mode_norms(body.mode_range_mm, 5)
    jump = found.near.jump * projected_sign(5, high - low) / np.outer(norms, norms)
    smooth = found.tangential[0]
    assert abs(smooth[4, 3]) < 0.5 * abs(jump[4, 3]) < 0.5 * abs(smooth - 2 * jump)[4, 3]
    fewer = found.fewer_modes()
    np.testing.assert_array_equal(fewer.tangential, found.tangential[:, :4, :4])
    plain = flank_compliance(body, JobOptions(n_modes=5, plane="strain"))
    assert plain.tangential is None
    assert plain.near.jump == 0.0
    assert "unit_loads_tangential" not in plain.job.counters
    np.testing.assert_allclose(
        plain.smooth, found.smooth, rtol=0, atol=1e-12 * np.abs(plain.smooth).max()
    )


def test_whole_body_rubs_as_its_sector_does(tmp_path: Path) -> None:
    """One computation of the whole pinion against the ring closed over its sectors."""
    write_mesh(tmp_path / "whole.msh", *whole_of(read_mesh(COARSE_PINION), 16))
    sides = []
    for body in (sector("body_1", COARSE_PINION), whole("body_1", tmp_path / "whole.msh")):
        tables = {"body_1": {"reference_radius_mm": 33.8289343, **body}, "body_2": TWO}
        sides.append(solved(effects={"friction_coefficient": 0.3}, **tables))
    one, other = sides
    np.testing.assert_allclose(one.rotation_rad, other.rotation_rad, rtol=1e-9, atol=0)
    assert other.cost["unit_loads_tangential"] > 16 * 3


# --- scene ----------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("value", "key", "expected", "found"),
    [
        (-0.1, "", "a number from 0 to 2", "-0.1"),
        (3, "", "a number from 0 to 2", "3"),
        ("rough", "", "a number from 0 to 2 or a non-empty list", "'rough'"),
        ([], "", "non-empty list of numbers from 0 to 2 or lists of 2 numbers", "[]"),
        ([0.1, -1], "[1]", "a number from 0 to 2", "-1"),
        ([0.1] * 15, "", "one coefficient per tooth of body_1: 16", "15 entries"),
        ([[0, 0.1], 0.2], "", "numbers, one per tooth, or rows", "both"),
        ([[0, 0.1], [1]], "[1]", "a list of 2 numbers", "[1]"),
        ([[0, 0.1], [1, 3]], "[1][1]", "a number from 0 to 2", "3"),
        ([[0, 0.1], [0, 0.2]], "[1][0]", "more than the roll position of the row before, 0", "0"),
    ],
)
def test_coefficients_that_are_refused(value: Any, key: str, expected: str, found: str) -> None:
    with pytest.raises(SceneError) as caught:
        build_bodies(scene_of(effects={"friction_coefficient": value}))
    assert caught.value.key == f"effects.friction_coefficient{key}"
    assert expected in caught.value.expected
    assert found in caught.value.found


def test_only_involutes_have_a_roll_position() -> None:
    mesh = {
        "kind": "mesh",
        "file": str(MESHES / "fzg_c_pinion.msh"),
        "teeth": 16,
        "reference_radius_mm": 33.8,
    }
    asked = {"friction_coefficient": [[0.0, 0.1], [1.0, 0.2]]}
    with pytest.raises(SceneError, match="only pairs of involutes have a roll position"):
        build_bodies(scene_of(body_1=mesh, effects=asked))


def test_effect_is_asked_for_by_a_coefficient_that_is_not_zero() -> None:
    for value, rubs in ((0.0, False), (0.1, True), ([0.0] * 16, False), ([[0, 0], [1, 0.1]], True)):
        pair = build_bodies(scene_of(effects={"friction_coefficient": value}))
        assert pair.effects.friction is rubs
        assert (pair.friction is not None) is rubs
    assert build_bodies(scene_of()).friction is None


# --- compliance files -----------------------------------------------------------------------------
@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Compliance files written for a scene with friction."""
    out = tmp_path_factory.mktemp("rubbed")
    tables = {
        "body_1": ONE,
        "body_2": TWO,
        "pair": {"center_distance_mm": 91.5, "face_width_mm": 14.0},
        "load": {"torque_Nm": 302.0},
        "effects": RUBS,
    }
    (out / "scene.toml").write_text(toml_of(tables), encoding="utf-8")
    assert main(["compliance", str(out / "scene.toml"), "-o", str(out)]) == 0
    return out


def test_files_of_a_scene_with_friction_serve_scenes_with_and_without(folder: Path) -> None:
    files = {"body_1": FROM_FILE_1, "body_2": FROM_FILE_2}
    rubbed = solved(folder, effects=RUBS, **files)
    assert_same(rubbed, solved(effects=RUBS))
    assert rubbed.cost["unit_loads_tangential"] == 0
    plain = solved(folder, **files)
    # fronts with other columns are summed in another order
    np.testing.assert_allclose(
        plain.rotation_rad, solved().rotation_rad, rtol=300 * ROUND_OFF, atol=0
    )
    assert plain.friction is None


def test_file_without_friction_names_both_keys(folder: Path, tmp_path: Path) -> None:
    with np.load(folder / "body_1.npz") as archive:
        arrays = dict(archive)
    assert int(arrays["version"]) == 3
    del arrays["smooth_nt"], arrays["kernel_nt"]
    np.savez(tmp_path / "body_1.npz", **{**arrays, "version": 1})
    with pytest.raises(ComplianceFileError) as caught:
        solved(tmp_path, body_1=FROM_FILE_1, effects=RUBS)
    assert caught.value.key == "smooth_nt"
    assert "effects.friction_coefficient" in caught.value.expected
    assert caught.value.found == "nothing"
    solved(tmp_path, body_1=FROM_FILE_1)  # without friction nothing is missing


def test_tangential_part_of_a_file_must_fit(folder: Path, tmp_path: Path) -> None:
    with np.load(folder / "body_1.npz") as archive:
        arrays = dict(archive)
    np.savez(tmp_path / "body_1.npz", **{**arrays, "smooth_nt": arrays["smooth_nt"][:, :-1]})
    with pytest.raises(ComplianceFileError, match="smooth_nt: expected an array of shape"):
        solved(tmp_path, body_1=FROM_FILE_1, effects=RUBS)


# --- result ---------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def result() -> fl.Result:
    return solved(effects=RUBS)


def test_friction_is_in_the_files_of_the_result(result: fl.Result, tmp_path: Path) -> None:
    tree = json.loads(result.to_json())
    friction = tree["friction"]
    assert friction["driver"] == "body_1"
    assert len(friction["torque_2_Nm"]) == len(friction["loss_J_per_rad"]) == 16
    assert np.shape(friction["site_friction_N"]) == result.site_force_N.shape
    assert friction["efficiency"] == pytest.approx(
        1 - friction["loss_work_J"] / friction["work_1_J"], rel=ROUND_OFF
    )
    assert {"sliding_mm_per_rad", "friction_force_N"} <= set(tree["pairs"][0])
    head = result.to_csv().splitlines()[0].split(",")
    assert "friction_torque_2_Nm" in head
    assert "friction_loss_J_per_rad" in head
    dataset = result.to_xarray()
    assert dataset["friction_torque_2_Nm"].attrs["units"] == "N m"
    line = next(row for row in result.table().splitlines() if row.startswith("friction"))
    assert "body_1 drives" in line
    assert f"efficiency {100 * result.friction.efficiency:.3f} %" in line


def test_without_friction_nothing_of_it_is_there() -> None:
    plain = solved()
    tree = json.loads(plain.to_json())
    assert tree["friction"] is None
    assert "friction_force_N" not in tree["pairs"][0]
    assert "friction" not in plain.to_csv()
    assert "friction" not in plain.table()
    assert "friction_torque_2_Nm" not in plain.to_xarray()


def test_friction_of_sites_is_the_sum_over_their_pairs(result: fl.Result) -> None:
    for p in range(0, 16, 5):
        pairs = result.pairs(p)
        for s, site in enumerate(result.sites):
            total = pairs.friction_force_N[pairs.site == site].sum()
            assert result.friction.site_friction_N[p, s] == pytest.approx(total, abs=1e-9)


def test_estimate_counts_the_modes_along_the_flank() -> None:
    rubbed = solved(effects=RUBS, accuracy={"estimate": True}, positions={"count": 8})
    plain = solved(accuracy={"estimate": True}, positions={"count": 8})
    ratio = rubbed.estimate["transmission_error"] / plain.estimate["transmission_error"]
    assert 0.5 < ratio < 2.0


def test_unloaded_pair_has_no_friction() -> None:
    found = solved(effects=RUBS, load={"torque_Nm": 0.0})
    assert not found.friction.loss_J_per_rad.any()
    assert found.friction.efficiency is None
