"""Compliances that do not repeat with the tooth: warnings, and the error of a single pitch."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from msgspec import structs

import flankload as fl
from flankload.analysis.period_error import teeth_until_alike
from flankload.base.array_archive import archive_of
from flankload.bodies.imported.body_file import write_body
from flankload.cost import Account
from flankload.elasticity.compliance import BodyCompliance, FlankModes, NearField
from flankload.elasticity.modal_arrays import modal_arrays
from flankload.mechanisms import run_once
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.meshes.io import read_mesh, write_mesh
from flankload.scene.mesh import ComplianceBody
from flankload.scene.pair import Positions
from tests.support.mesh_files import Cells, whole_of
from tests.support.solving import solve
from tests.support.tolerances import SOLVER

TEETH = 24
#: Elements of the wheel's disc between these radii (mm) are cut out in some sectors, so that four
#: windows and four spokes are left: the compliance repeats after six teeth.
WINDOW, OPEN = (28.0, 39.0), (0, 1, 2)
GROUP = 6
COUNT = 16

PINION = {
    "kind": "gear", "module_mm": 4.5, "teeth": 16, "profile_shift": 0.182,
    "tip_diameter_mm": 82.46, "bore_diameter_mm": 30,
}  # fmt: skip
GEAR = {**PINION, "teeth": TEETH, "profile_shift": 0.171, "tip_diameter_mm": 118.36}
PROFILE = {key: GEAR[key] for key in ("module_mm", "profile_shift", "tip_diameter_mm")}


def scene_of(body_2: dict, body_1: dict = PINION, **positions: object) -> fl.Scene:
    return fl.Scene.from_dict(
        {
            "body_1": body_1,
            "body_2": body_2,
            "pair": {"center_distance_mm": 91.5, "face_width_mm": 14},
            "load": {"torque_Nm": 302},
            "positions": {"count": COUNT, **positions},
            "accuracy": {"modes": 3},
        }
    )


def whole(path: Path, **keys: object) -> dict[str, object]:
    names = [f"FLANK_{k}" for k in range(TEETH)]
    return {"kind": "mesh", "file": str(path), "flank_sets": names, "profile": PROFILE, **keys}


def windows_in(
    nodes: np.ndarray, cells: Cells, sets: dict[str, np.ndarray]
) -> tuple[np.ndarray, Cells, dict[str, np.ndarray]]:
    """The wheel with its windows cut out, which begin at the flank of tooth 0."""
    ((kind, data),) = cells
    flank = nodes[sets["FLANK_0"].ravel()].mean(axis=0)
    middle = nodes[data].mean(axis=1)
    sector = (np.arctan2(middle[:, 1], middle[:, 0]) - np.arctan2(flank[1], flank[0])) * TEETH
    inside = np.isin(np.floor(sector / (2 * np.pi) + 0.25) % GROUP, OPEN)
    radius = np.hypot(*middle.T)
    data = data[~(inside & (radius > WINDOW[0]) & (radius < WINDOW[1]))]
    used, number = np.unique(data, return_inverse=True)
    new = np.full(len(nodes), -1)
    new[used] = np.arange(used.size)
    return nodes[used], ((kind, number.reshape(data.shape)),), {n: new[e] for n, e in sets.items()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel as a sector, as a whole with windows, and both compliances as those of a whole."""
    out = tmp_path_factory.mktemp("wheels")
    gears = scene_of(GEAR)
    coarse = structs.replace(gears.accuracy, flank_element_mm=3.0)
    gears = dataclasses.replace(gears, accuracy=coarse)
    gear = build_bodies(gears).body_2
    write_body(out / "sector.msh", gear.mesh)
    write_mesh(out / "windows.msh", *windows_in(*whole_of(read_mesh(out / "sector.msh"), TEETH)))
    scene = scene_of(whole(out / "windows.msh"))
    body = build_bodies(scene).body_2
    found = compliance_of(body, scene)
    (out / "windows.npz").write_bytes(archive_of(modal_arrays(body, found, plane="strain")))
    number = np.arange(TEETH)
    blocks = compliance_of(gear, gears).smooth[(number[:, None] - number) % TEETH]
    alike = dataclasses.replace(found, smooth=blocks.reshape(found.smooth.shape))
    (out / "full.npz").write_bytes(archive_of(modal_arrays(body, alike, plane="strain")))
    return out


def from_file(folder: Path, name: str, **positions: object) -> fl.Scene:
    scene = scene_of(GEAR, **positions)
    return dataclasses.replace(scene, body_2=ComplianceBody(file=str(folder / f"{name}.npz")))


@pytest.fixture(scope="module")
def one_pitch(folder: Path) -> fl.Result:
    return solve(from_file(folder, "windows"))


@pytest.fixture(scope="module")
def whole_period(folder: Path) -> fl.Result:
    return solve(from_file(folder, "windows", pitches="hunting"))


def said(result: fl.Result) -> list[str]:
    return [text for text in result.warnings if "does not repeat from tooth to tooth" in text]


def test_one_pitch_of_a_wheel_with_windows_is_not_sold_as_its_period(one_pitch: fl.Result) -> None:
    (text,) = said(one_pitch)
    assert "body_2 after 6 of 24 teeth" in text
    assert "repeat after 6 pitches, these positions cover one" in text
    assert "positions.pitches = 'hunting'" in text
    assert "by period alone" in one_pitch.table()


@pytest.mark.parametrize("quantity", ["mean", "peak_to_peak"])
def test_estimate_contains_the_differences_of_the_other_pitches(
    quantity: str, one_pitch: fl.Result, whole_period: fl.Result
) -> None:
    name = f"transmission_error_{quantity}"
    one, true = (result.summary[f"{name}_um"] for result in (one_pitch, whole_period))
    error = abs(one - true) / one
    assert error > 0.02
    estimated = one_pitch.estimate["by_source"]["period"][name]
    assert error < estimated < 2 * error
    assert one_pitch.estimate[name] > error
    assert one_pitch.estimate["dominant_source"][name] == "period"


@pytest.mark.parametrize("kind", ["secant", "tangent"])
def test_mean_stiffness_of_one_pitch_is_in_doubt_by_the_others(
    kind: str, one_pitch: fl.Result, whole_period: fl.Result
) -> None:
    name = f"stiffness_{kind}_mean_N_per_um"
    error = abs(whole_period.summary[name] / one_pitch.summary[name] - 1)
    estimated = one_pitch.estimate["by_source"]["period"][f"stiffness_{kind}"]
    assert error < estimated < 2.5 * error


def test_harmonics_of_one_pitch_are_in_doubt_by_the_others(
    one_pitch: fl.Result, whole_period: fl.Result
) -> None:
    key = "transmission_error_mesh_harmonics_um"
    one, true = (np.array(result.summary[key][:3]) for result in (one_pitch, whole_period))
    error = np.abs(one - true) / np.maximum(one, 0.1 * one.max())
    estimated = one_pitch.estimate["by_source"]["period"]["transmission_error_harmonics"]
    assert error.max() < estimated < 4 * error.max()


def test_hunting_runs_until_the_compliance_repeats(whole_period: fl.Result, folder: Path) -> None:
    assert whole_period.period_pitches == GROUP
    assert whole_period.closed
    assert not said(whole_period)
    assert "by period alone" not in whole_period.table()
    turn = solve(from_file(folder, "windows", pitches=TEETH, count=2))
    np.testing.assert_allclose(
        turn.rotation_rad[: 2 * GROUP], turn.rotation_rad[-2 * GROUP :], rtol=SOLVER, atol=0
    )
    np.testing.assert_allclose(
        whole_period.rotation_rad[:: COUNT // 2],
        turn.rotation_rad[: 2 * GROUP],
        rtol=SOLVER,
        atol=0,
    )


def test_some_pitches_of_a_longer_period_are_a_part_of_it(folder: Path) -> None:
    some = solve(from_file(folder, "windows", pitches=2))
    assert said(some)
    assert not some.closed
    assert some.period_pitches == GROUP
    assert some.summary["transmission_error_harmonics_um"] is None
    assert some.estimate["by_source"]["period"]["transmission_error_mean"] > 1e-3


def test_work_of_a_hunting_period_is_counted_before_the_sweep(whole_period: fl.Result) -> None:
    sweep = whole_period.cost["stages"]["sweep"]
    assert sweep["predicted"]["counters"]["states"] == sweep["counters"]["states"] == GROUP * COUNT


def test_plan_that_cannot_know_the_period_is_no_plan_of_another_scene(folder: Path) -> None:
    scene = from_file(folder, "windows", pitches="hunting", count=2)
    found = fl.solve(scene, plan=fl.plan(scene))
    assert found.position_rad.size == 2 * GROUP


def test_whole_wheel_without_windows_repeats_with_the_tooth(folder: Path) -> None:
    found = solve(from_file(folder, "full", pitches="hunting"))
    assert found.period_pitches == 1
    assert not said(found)
    assert max(found.estimate["by_source"]["period"].values()) < SOLVER
    assert "by period alone" not in found.table()


def test_mesh_that_is_not_the_same_at_all_teeth_is_no_longer_period(
    folder: Path, tmp_path: Path
) -> None:
    """Inner nodes are displaced randomly by up to a tenth of the shortest edge."""
    from flankload.meshes.plane_mesh import boundary_edges

    nodes, cells, sets = whole_of(read_mesh(folder / "sector.msh"), TEETH)
    ((_, data),) = cells
    inner = np.setdiff1d(data, boundary_edges(cells))
    shortest = np.full(len(nodes), np.inf)
    for first, last in ((0, 4), (4, 1), (1, 5), (5, 2), (2, 6), (6, 3), (3, 7), (7, 0)):
        length = np.linalg.norm(nodes[data[:, first]] - nodes[data[:, last]], axis=1)
        np.minimum.at(shortest, data.ravel(), np.repeat(length, data.shape[1]))
    away = np.random.default_rng(12).uniform(-0.1, 0.1, (inner.size, 2))
    nodes[inner] += shortest[inner, None] * away
    write_mesh(tmp_path / "shaken.msh", nodes, cells, sets)
    scene = scene_of(whole(tmp_path / "shaken.msh"))
    found = compliance_of(build_bodies(scene).body_2, scene)
    assert teeth_until_alike(found, TEETH, 1e-9) == TEETH
    assert teeth_until_alike(found, TEETH, 0.25 * scene.accuracy.tolerance) == 1


def test_teeth_without_a_flank_are_named_as_the_first_cure(folder: Path) -> None:
    named = [0, 1, 2, 3, 22, 23]
    names = [f"FLANK_{k}" for k in named]
    scene = scene_of(
        whole(folder / "windows.msh", flank_sets=names, teeth=TEETH), pitches="hunting"
    )
    every = from_file(folder, "windows")
    every = compliance_of(build_bodies(every).body_2, every)
    blocks = every.smooth.reshape(TEETH, TEETH, 3, 3)[np.ix_(named, named)]
    assert every.tangential is not None
    along = every.tangential.reshape(TEETH, TEETH, 3, 3)[np.ix_(named, named)]
    some = dataclasses.replace(
        every,
        smooth=blocks.reshape(-1, 3, 3),
        tangential=along.reshape(-1, 3, 3),
        flanks=tuple(named),
    )
    (found,) = run_once(scene, {1: (some, Account())})
    assert found.period_pitches == 1
    (text,) = said(found)
    assert "(name the flanks of all teeth of body_2, then positions.pitches" in text
    assert found.estimate["by_source"]["period"]["transmission_error_mean"] > 1e-3


def test_period_of_a_compliance_includes_that_of_cross_compliances() -> None:
    """Alike by themselves; of three teeth the first two are coupled more than the others."""
    own, coupled = np.eye(1), 0.3 * np.eye(1)
    blocks = np.array([[own if i == j else coupled for j in range(3)] for i in range(3)])
    alike = BodyCompliance(
        blocks.reshape(9, 1, 1), NearField(0.0), FlankModes((0.0, 1.0)), flanks=(0, 1, 2)
    )
    assert teeth_until_alike(alike, 3, 1e-3) == 1
    blocks[0, 1] = blocks[1, 0] = 0.31
    unlike = dataclasses.replace(alike, smooth=blocks.reshape(9, 1, 1))
    assert teeth_until_alike(unlike, 3, 1e-3) == 3
    assert teeth_until_alike(unlike, 3, 0.02) == 1
    # a third of a body of nine teeth, of which nothing else is known
    assert teeth_until_alike(unlike, 9, 1e-3) == 3


def test_estimate_is_no_condition_of_the_period(folder: Path) -> None:
    scene = from_file(folder, "windows", pitches="hunting", count=2)
    plain = structs.replace(scene.accuracy, estimate=False, tangents=False)
    assert solve(dataclasses.replace(scene, accuracy=plain)).period_pitches == GROUP


def test_angles_of_one_pitch_represent_all_and_more_are_a_part(folder: Path) -> None:
    pitch = 360 / 16
    for turns, period in ((1.0, 1), (2.0, GROUP)):
        angles = list(np.arange(0, turns * pitch, pitch / 4))
        scene = from_file(folder, "windows")
        found = solve(dataclasses.replace(scene, positions=Positions(angles_deg=tuple(angles))))
        assert found.period_pitches == period
