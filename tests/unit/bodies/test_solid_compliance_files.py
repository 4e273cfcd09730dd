"""Compliance files of bodies in three dimensions: written, read back, refused."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.errors import FlankloadError
from flankload.mechanisms.flank_pair.body_files import compliance_files
from tests.support.solving import solve
from tests.support.three_dimensional import deviation, tree_of
from tests.support.tolerances import SOLVER

#: The helical pair on coarse elements, with pinion and wheel apart along the axis.
COARSE: dict[str, Any] = {
    "accuracy__flank_element_mm": 2.0,
    "accuracy__modes": 3,
    "accuracy__axial_degree": 6,
    "accuracy__load_degree_z": 2,
    "accuracy__slices": 10,
    "accuracy__estimate": False,
    "positions__count": 2,
    "body_1__axial_offset_mm": 2.0,
    "effects__friction_coefficient": 0.1,
}
#: Keys of the discretization of bodies, which files do not need.
OF_BODIES = ("flank_element_mm", "modes", "axial_degree", "load_degree_z")


def written(folder: Path, tree: dict[str, Any]) -> None:
    for file in compliance_files(fl.Scene.from_dict(deepcopy(tree))):
        assert file.arrays is not None
        np.savez(folder / f"{file.name}.npz", **file.arrays)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("solid")
    written(folder, tree_of("helical_gear", COARSE))
    return folder


def from_files(folder: Path, **changes: Any) -> fl.Scene:
    """The pair with both bodies from files, and changed keys."""
    tree = tree_of("helical_gear", COARSE)
    for name in ("body_1", "body_2"):
        table = tree[name]
        lead = {key: value for key, value in table.items() if key.startswith(("lead_", "axial_"))}
        tree[name] = {"kind": "compliance", "file": f"{name}.npz", **lead}
    tree["effects"] = {**tree["effects"], "dimension": 3}
    tree["accuracy"] = {k: v for k, v in tree["accuracy"].items() if k not in OF_BODIES}
    for key, value in changes.items():
        table, _, name = key.partition("__")
        tree[table] = {**tree[table], name: value}
    return fl.Scene.from_dict(tree, file=folder / "scene.toml")


@pytest.mark.parametrize("crowning", [8.0, 0.0])
def test_a_pair_from_files_is_the_original(folder: Path, crowning: float) -> None:
    """Lead modifications are those of the scene."""
    own = solve(
        fl.Scene.from_dict(
            tree_of("helical_gear", {**COARSE, "body_1__lead_crowning_um": crowning})
        )
    )
    found = solve(from_files(folder, body_1__lead_crowning_um=crowning))
    np.testing.assert_allclose(found.rotation_rad, own.rotation_rad, rtol=SOLVER)
    assert deviation(found.slice_line_load_N_per_mm, own.slice_line_load_N_per_mm) < SOLVER
    assert found.cost["fe_factorisations"] == 0
    assert found.friction is not None
    assert own.friction is not None
    np.testing.assert_allclose(
        found.friction.loss_J_per_rad, own.friction.loss_J_per_rad, rtol=SOLVER
    )


def test_one_body_from_a_file_meets_a_gear(folder: Path) -> None:
    wheel = tree_of("helical_gear", COARSE)["body_2"]
    keys = {key: COARSE[f"accuracy__{key}"] for key in OF_BODIES}
    tree = {**from_files(folder).to_dict()}
    tree["body_2"], tree["accuracy"] = wheel, {**tree["accuracy"], **keys}
    found = solve(fl.Scene.from_dict(tree, file=folder / "scene.toml"))
    whole = solve(from_files(folder))
    np.testing.assert_allclose(found.rotation_rad, whole.rotation_rad, rtol=SOLVER)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"pair__face_width_mm": 20.0},
            ("face_width_mm: expected 20, the face width of the body in the scene, found 25"),
        ),
        (
            {"body_1__tooth_helix_slope_um": [1.0]},
            "body_1.tooth_helix_slope_um: expected one entry per tooth: 25, as in body_1.npz",
        ),
    ],
)
def test_files_that_do_not_fit_the_scene_get_one_line(
    folder: Path, changes: dict[str, Any], line: str
) -> None:
    with pytest.raises(FlankloadError) as caught:
        fl.prepare(from_files(folder, **changes))
    assert line in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("times", [1.001, -1.0])
def test_helices_of_other_leads_or_hands_get_one_line(
    folder: Path, tmp_path: Path, times: float
) -> None:
    line = r"body_2\.file: expected a pair of helices that turn body_2 by"
    for name in ("body_1", "body_2"):
        with np.load(folder / f"{name}.npz") as file:
            arrays = dict(file)
        if name == "body_2":
            arrays["twist_rad_per_mm"] = times * arrays["twist_rad_per_mm"]
        np.savez(tmp_path / f"{name}.npz", **arrays)
    with pytest.raises(FlankloadError, match=line):
        fl.prepare(from_files(tmp_path))


def test_plane_files_and_solid_ones_are_not_mixed(folder: Path, tmp_path: Path) -> None:
    tree = tree_of("external_gear", {})
    written(tmp_path, tree)
    for name in ("body_1", "body_2"):
        tree[name] = {"kind": "compliance", "file": f"{name}.npz"}
    solid = {**tree, "effects": {"dimension": 3}}
    for file in (tmp_path, folder):
        scene = fl.Scene.from_dict(solid if file == tmp_path else tree, file=file / "scene.toml")
        expected = (
            "nothing: the compliance of a plane body" if file == tmp_path else "dimension = 3"
        )
        with pytest.raises(FlankloadError, match=expected):
            fl.prepare(scene)


def test_arrays_along_the_axis_are_checked(folder: Path, tmp_path: Path) -> None:
    with np.load(folder / "body_1.npz") as file:
        arrays = dict(file)
    np.savez(tmp_path / "body_2.npz", **arrays)
    np.savez(tmp_path / "body_1.npz", **{**arrays, "axial_degree": np.asarray(3)})
    with pytest.raises(FlankloadError, match="smooth: expected a multiple of 4 modes"):
        fl.prepare(from_files(tmp_path))
    np.savez(tmp_path / "body_1.npz", **{**arrays, "smooth": -arrays["smooth"]})
    with pytest.raises(FlankloadError, match="positive definite"):
        solve(from_files(tmp_path, body_2__file=str(folder / "body_2.npz")))


def test_the_plan_has_no_plane_section_of_a_file(folder: Path) -> None:
    row = fl.plan(from_files(folder)).effect("three_dimensions")
    assert row.size is None
    assert "body_1.kind: expected a body with finite elements" in (row.unknown or "")
