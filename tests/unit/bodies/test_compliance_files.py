"""Bodies whose compliance comes from a file: our own format bit by bit, and the plain one."""

from __future__ import annotations

import shutil
import tomllib
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest import mock
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest

import flankload as fl
from flankload.bodies.body import Material
from flankload.bodies.flank_elements import gauss_places, mass_matrix
from flankload.bodies.imported.compliance import NodalCompliance
from flankload.bodies.plane import sketched_tooth
from flankload.cli import main
from flankload.elasticity.imported_compliance import imported_compliance
from flankload.elasticity.near_field import mode_norms, mode_values, projected_logarithm
from flankload.errors import ComplianceFileError, SceneError
from flankload.mechanisms.flank_pair import assembly
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.states import LARGEST_TURN
from flankload.pairing.body_pair import BodyPair
from tests.support.compliance_scenes import (
    FROM_FILE_1,
    FROM_FILE_2,
    assert_same,
    scene_of,
    solved,
    toml_of,
)
from tests.support.gear_pair import ONE, TWO
from tests.support.nodal_files import csv_of, flank_order, nodal_arrays, to_pressures, write_npz
from tests.support.tolerances import ROUND_OFF, SOLVER

#: Tolerance of a matrix between nodes of half a millimetre's elements; the rest is the curve
#: through the nodes instead of the exact profile.
NODAL = 3e-3
#: The same of the peak pressure, which needs the curvature of that curve.
PRESSURE = 1e-2


def write_compliance(folder: Path, **bodies: Any) -> None:
    """The command, on a pair with changed bodies."""
    tables = {
        "body_1": {**ONE, **bodies.get("one", {})},
        "body_2": {**TWO, **bodies.get("two", {})},
        "pair": {"center_distance_mm": 91.5, "face_width_mm": 14.0},
        "load": {"torque_Nm": 302.0},
    }
    path = folder / "written.toml"
    path.write_text(toml_of(tables), encoding="utf-8")
    assert main(["compliance", str(path), "-o", str(folder)]) == 0


def assert_no_elements(result: fl.Result) -> None:
    assert result.cost["fe_factorisations"] == 0
    assert result.cost["unit_loads_normal"] == 0
    assert result.cost["fe_degrees_of_freedom"] == [0, 0]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("compliance")
    write_compliance(folder)
    return folder


@pytest.fixture(scope="module")
def plain() -> fl.Result:
    return solved()


@pytest.fixture(scope="module")
def fine() -> BodyPair:
    return build_bodies(scene_of(accuracy={"flank_element_mm": 0.5}))


@pytest.fixture(scope="module")
def nodal(fine: BodyPair) -> tuple[dict[str, Any], dict[str, Any]]:
    """Plain files of both bodies."""
    one, two = map(nodal_arrays, fine.bodies, fine.pairing.turns_at_zero_rad)
    return one, two


# --- flankload's own format -----------------------------------------------------------------------
def test_scene_read_back_is_the_original_bit_by_bit(folder: Path, plain: fl.Result) -> None:
    found = solved(folder, body_1=FROM_FILE_1, body_2=FROM_FILE_2)
    assert_same(found, plain)
    assert_no_elements(found)
    # a file has no key that would take a corner away
    one, two = (
        [line.partition(" touches with ")[0] for line in r.warnings] for r in (found, plain)
    )
    assert one == two
    for outline in ("outline_1", "outline_2"):
        np.testing.assert_array_equal(
            getattr(found.drawing, outline), getattr(plain.drawing, outline)
        )


def test_forces_turn_on_the_mate_of_a_sharp_tip(tmp_path: Path) -> None:
    """Regression: the file of a rounded body had no response along the flank."""
    rounded = {"tip_radius_mm": 0.3}
    write_compliance(tmp_path, one=rounded)
    found = solved(tmp_path, body_1=FROM_FILE_1, body_2=FROM_FILE_2)
    assert_same(found, solved(body_1={**ONE, **rounded}))


def test_a_file_without_loads_along_the_flank_is_warned_about(
    folder: Path, plain: fl.Result, tmp_path: Path
) -> None:
    """Files of earlier versions hold `turned` in place of `smooth_nt`."""
    with np.load(folder / "body_1.npz") as file:
        arrays = {name: file[name] for name in file.files if not name.endswith("_nt")}
    arrays["turned"] = np.zeros(arrays["smooth"].shape[:2])
    np.savez(tmp_path / "body_1.npz", **arrays)
    shutil.copy(folder / "body_2.npz", tmp_path)
    found = solved(tmp_path, body_1=FROM_FILE_1, body_2=FROM_FILE_2)
    (note,) = [line for line in found.warnings if "do not turn over sharp tips" in line]
    assert note.startswith("forces on body_1 ")
    assert "smooth_nt" in note
    apart = np.abs(found.rotation_rad / plain.rotation_rad - 1.0)
    corner = plain.corner_contact.any(axis=1)
    assert 0.0 < apart[corner].max() < LARGEST_TURN
    assert apart[~corner].max() < SOLVER


def test_estimate_is_that_of_the_original(folder: Path) -> None:
    keys: dict[str, Any] = {"accuracy": {}, "positions": {"count": 4}}
    found = solved(folder, body_1=FROM_FILE_1, body_2=FROM_FILE_2, **keys)
    here, there = found.estimate["by_source"], solved(**keys).estimate["by_source"]
    assert here["strips"] == there["strips"]
    assert here["modes"] == there["modes"]
    # the error of the elements of a compliance from a file is unknown, and the result says so
    assert "elements" not in here
    assert any("imported compliance of body_1 and body_2" in note for note in found.warnings)


def test_one_body_from_a_file_is_one_job_less(folder: Path, plain: fl.Result) -> None:
    found = solved(folder, body_2=FROM_FILE_2)
    assert_same(found, plain)
    assert found.cost["fe_factorisations"] == 1
    assert found.cost["unit_loads_normal"] == 5
    assert found.cost["fe_degrees_of_freedom"][1] == 0


def test_scene_decides_on_all_but_the_bodies(folder: Path) -> None:
    keys: dict[str, Any] = {
        "pair": {"center_distance_mm": 91.6, "face_width_mm": 20},
        "load": {"torque_Nm": 100},
    }
    found = solved(folder, body_1=FROM_FILE_1, body_2=FROM_FILE_2, **keys)
    assert_same(found, solved(**keys))


def test_fewer_modes_are_a_block_of_all(folder: Path) -> None:
    keys = {"accuracy": {"estimate": False, "modes": 4}}
    found = solved(folder, body_1=FROM_FILE_1, body_2=FROM_FILE_2, **keys)
    np.testing.assert_allclose(found.rotation_rad, solved(**keys).rotation_rad, rtol=SOLVER, atol=0)


def test_mesh_without_profile_comes_back_unchanged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = Path("examples/scenes/external_gear_mesh.toml")
    assert main(["compliance", str(scene), "-o", str(tmp_path)]) == 0
    assert "16 teeth" in capsys.readouterr().out
    original = fl.read_scene(scene)
    tables = {
        "body_1": FROM_FILE_1,
        "body_2": FROM_FILE_2,
        "pair": {
            "center_distance_mm": original.pair.center_distance_mm,
            "face_width_mm": original.pair.face_width_mm,
        },
        "load": {"torque_Nm": original.load.torque_Nm},
        "positions": {"count": original.positions.count},
    }
    pair = build_bodies(scene_of(tmp_path, **tables))
    assert not pair.body_1.flank_angle_known
    assert not pair.body_2.flank_angle_known
    found, expected = solved(tmp_path, **tables), fl.solve(original)
    assert isinstance(expected, fl.Result)
    assert_same(found, expected)
    assert_no_elements(found)


def internal_tables() -> dict[str, Any]:
    """A ring around its pinion, from the examples."""
    text = Path("examples/scenes/internal_gear.toml").read_text(encoding="utf-8")
    return {**tomllib.loads(text), "positions": {"count": 6}, "accuracy": {"estimate": False}}


def test_ring_around_its_pinion_comes_back(tmp_path: Path) -> None:
    tables = internal_tables()
    scene = "examples/scenes/internal_gear.toml"
    assert main(["compliance", scene, "-o", str(tmp_path)]) == 0
    found = solved(tmp_path, **{**tables, "body_1": FROM_FILE_1, "body_2": FROM_FILE_2})
    assert_same(found, solved(**tables))
    assert_no_elements(found)
    assert found.drawing.is_around


def test_ring_from_nodes(tmp_path: Path) -> None:
    """Positions without tip contact: the file has a corner in place of the rounding."""
    tables = internal_tables()
    expected = solved(**tables)
    accuracy = {"estimate": False, "flank_element_mm": 0.1 * tables["body_1"]["module_mm"]}
    scene = scene_of(**{**tables, "accuracy": accuracy})
    pair = build_bodies(scene, modified_elements=True)  # the file has the flank in contact
    near = np.array([0, 1])
    for body, turn, name, side in (
        (pair.body_1, pair.pairing.turns_at_zero_rad[0], "body_1.npz", "outwards"),
        (pair.body_2, pair.pairing.turns_at_zero_rad[1], "body_2.npz", "inwards"),
    ):
        arrays = nodal_arrays(body, turn, teeth_stand=side)
        arrays |= {"offsets": near, "compliance": arrays["compliance"][near]}
        write_npz(tmp_path / name, arrays)
    found = solved(tmp_path, **{**tables, "body_1": FROM_FILE_1, "body_2": FROM_FILE_2})
    assert_no_elements(found)
    assert found.drawing.is_around
    off = ~found.corner_contact.any(axis=1)
    assert off.sum() >= 3
    np.testing.assert_allclose(
        found.rotation_rad[off], expected.rotation_rad[off], rtol=NODAL, atol=0
    )


def test_modified_flanks_in_a_file_are_an_effect(folder: Path, tmp_path: Path) -> None:
    write_compliance(tmp_path, one={"profile_crowning_um": 5.0})
    tables = {"body_1": FROM_FILE_1, "body_2": TWO}
    assert not build_bodies(scene_of(folder, **tables)).effects.flank_modifications
    assert build_bodies(scene_of(tmp_path, **tables)).effects.flank_modifications


def test_pitch_errors_travel_and_may_be_replaced(tmp_path: Path) -> None:
    errors = {"pitch_errors_um": [0.0, 10.0, *[0.0] * 14]}
    write_compliance(tmp_path, one=errors)
    original = solved(body_1={**ONE, **errors})
    found = solved(tmp_path, body_1=FROM_FILE_1, body_2=FROM_FILE_2)
    assert_same(found, original)
    assert not found.closed
    other = {"pitch_errors_um": [0.0] * 15 + [-10.0]}
    found = solved(tmp_path, body_1={**FROM_FILE_1, **other}, body_2=FROM_FILE_2)
    assert_same(found, solved(body_1={**ONE, **other}))


def test_file_written_twice_has_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    write_compliance(tmp_path)
    for name in ("body_1.npz", "body_2.npz"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


def test_file_made_from_a_file_is_the_same_but_for_its_kind(folder: Path, tmp_path: Path) -> None:
    scene = {
        "body_1": {**FROM_FILE_1, "file": str(folder / "body_1.npz")},
        "body_2": {**FROM_FILE_2, "file": str(folder / "body_2.npz")},
        "pair": {"center_distance_mm": 91.5, "face_width_mm": 14.0},
        "load": {"torque_Nm": 302.0},
    }
    (tmp_path / "again.toml").write_text(toml_of(scene), encoding="utf-8")
    assert main(["compliance", str(tmp_path / "again.toml"), "-o", str(tmp_path)]) == 0
    for name in ("body_1.npz", "body_2.npz"):
        with np.load(folder / name) as before, np.load(tmp_path / name) as after:
            assert before.files == after.files
            for key in before.files:
                if key != "kind":
                    np.testing.assert_array_equal(before[key], after[key])


# --- rigid bodies ---------------------------------------------------------------------------------
def test_rigid_body_from_a_file_is_a_curve(folder: Path) -> None:
    rigid = {**FROM_FILE_1, "rigid": True}
    assert build_bodies(scene_of(folder, body_1=rigid)).body_1.imported is None
    found = solved(folder, body_1=rigid, body_2=FROM_FILE_2)
    assert_no_elements(found)
    assert_same(found, solved(body_1={**ONE, "rigid": True}))


def test_rigid_body_is_not_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_compliance(tmp_path, two={"rigid": True})
    assert "body_2: rigid, so it has no compliance" in capsys.readouterr().out
    assert not (tmp_path / "body_2.npz").exists()


def test_rigid_bodies_turn_without_torque() -> None:
    """Rigid bodies have a solution without torque."""
    rigid = {"body_1": {**ONE, "rigid": True}, "body_2": {**TWO, "rigid": True}}
    found = solved(**rigid, load={"torque_Nm": 0})
    assert_no_elements(found)
    np.testing.assert_allclose(found.transmission_error_um, 0.0, rtol=0, atol=1e-6)
    with pytest.raises(SceneError, match="load sharing of two rigid bodies is undetermined"):
        scene_of(**rigid)
    with pytest.raises(SceneError, match=r"body_2\.rigid"):
        scene_of(**rigid, load={"torque_Nm": [0, 1]})


# --- the plain format -----------------------------------------------------------------------------
def with_nodal(folder: Path, one: dict[str, Any], two: dict[str, Any]) -> fl.Result:
    write_npz(folder / "body_1.npz", one)
    write_npz(folder / "body_2.npz", two)
    return solved(folder, body_1=FROM_FILE_1, body_2=FROM_FILE_2)


@pytest.fixture(scope="module")
def unturned() -> fl.Result:
    """The pair without forces that turn over corners: a matrix of normal displacements has none."""
    with mock.patch.object(assembly, "forces_turn", return_value=False):
        return solved()


@pytest.mark.parametrize("form", [dict, to_pressures], ids=["nodal forces", "nodal pressures"])
def test_matrix_between_nodes_gives_the_rotation_of_the_direct_way(
    form: Callable[[dict], dict], nodal: tuple[dict, dict], unturned: fl.Result, tmp_path: Path
) -> None:
    found = with_nodal(tmp_path, *(form(arrays) for arrays in nodal))
    assert_no_elements(found)
    np.testing.assert_allclose(found.rotation_rad, unturned.rotation_rad, rtol=NODAL, atol=0)
    smooth = ~unturned.corner_contact
    np.testing.assert_allclose(
        found.peak_pressure_MPa[smooth],
        unturned.peak_pressure_MPa[smooth],
        rtol=0,
        atol=PRESSURE * unturned.peak_pressure_MPa[smooth].max(),
    )


def test_forces_and_pressures_of_the_same_elements_agree(
    nodal: tuple[dict, dict], tmp_path: Path
) -> None:
    """The rest is the length of the elements: along the curve, or along chords."""
    forces = with_nodal(tmp_path, *nodal)
    pressures = with_nodal(tmp_path, *(to_pressures(arrays) for arrays in nodal))
    np.testing.assert_allclose(pressures.rotation_rad, forces.rotation_rad, rtol=1e-3, atol=0)
    assert (pressures.rotation_rad != forces.rotation_rad).any()


def test_table_is_the_same_as_the_arrays(nodal: tuple[dict, dict], tmp_path: Path) -> None:
    near = np.array([0, 1])
    one, two = ({**a, "offsets": near, "compliance": a["compliance"][near]} for a in nodal)
    expected = with_nodal(tmp_path, one, two)
    for name, arrays in (("one.csv", one), ("two.csv", two)):
        (tmp_path / name).write_text(csv_of(arrays), encoding="utf-8")
    found = solved(
        tmp_path,
        body_1={"kind": "compliance", "file": "one.csv"},
        body_2={"kind": "compliance", "file": "two.csv"},
    )
    assert_same(found, expected)


def test_coupling_the_other_way_follows_from_betti(
    nodal: tuple[dict, dict], tmp_path: Path
) -> None:
    """Teeth -1 and 1 have the same influence: one of them in the file is sufficient."""
    near = [{**a, "offsets": np.array([0, 1]), "compliance": a["compliance"][:2]} for a in nodal]
    found, expected = with_nodal(tmp_path, *near), with_nodal(tmp_path, *nodal)
    np.testing.assert_allclose(found.rotation_rad, expected.rotation_rad, rtol=SOLVER, atol=0)


def test_without_couplings_single_contact_stays_and_a_note_says_so(
    nodal: tuple[dict, dict], tmp_path: Path
) -> None:
    alone = [{**a, "offsets": None, "compliance": a["compliance"][0]} for a in nodal]
    alone = [{name: value for name, value in a.items() if value is not None} for a in alone]
    found, expected = with_nodal(tmp_path, *alone), with_nodal(tmp_path, *nodal)
    assert sum("other teeth do not move with the loaded one" in w for w in found.warnings) == 2
    single = (expected.site_force_N > 0).sum(axis=1) == 1
    assert single.any()
    assert not single.all()
    np.testing.assert_allclose(
        found.rotation_rad[single], expected.rotation_rad[single], rtol=SOLVER, atol=0
    )
    assert (found.rotation_rad[~single] < 0.98 * expected.rotation_rad[~single]).all()


def test_one_body_from_nodes_meets_a_gear(
    nodal: tuple[dict, dict], unturned: fl.Result, tmp_path: Path
) -> None:
    """The gear turns to the pitch point, where the body of the file is; forces turn over the tip of
    the gear alone."""
    write_npz(tmp_path / "body_1.npz", nodal[0])
    found = solved(tmp_path, body_1=FROM_FILE_1)
    assert found.cost["fe_factorisations"] == 1
    turned, straight = (
        np.abs(found.rotation_rad / each.rotation_rad - 1.0) for each in (solved(), unturned)
    )
    assert (np.minimum(turned, straight) < NODAL).all()
    assert turned.max() > NODAL
    assert straight.max() > NODAL


def test_asymmetry_is_reported_and_averaged(nodal: tuple[dict, dict], tmp_path: Path) -> None:
    one, two = nodal
    skew = one["compliance"].copy()
    skew[0][2, 3] += 1e-3 * np.linalg.norm(skew) / np.sqrt(2)
    found = with_nodal(tmp_path, {**one, "compliance": skew}, two)
    assert any("body_1" in w and "asymmetry 0.001" in w for w in found.warnings)


@pytest.mark.parametrize("quadratic", [False, True])
def test_mass_matrix_holds_length_and_linear_pressure(quadratic: bool) -> None:
    generator = np.random.default_rng(7)
    s = np.cumsum(generator.uniform(0.2, 1.0, 9))
    if quadratic:
        s[1::2] = 0.5 * (s[:-1:2] + s[2::2])
    mass = mass_matrix(s, quadratic=quadratic)
    length = s[-1] - s[0]
    np.testing.assert_allclose(mass.sum(), length, rtol=ROUND_OFF, atol=0)
    cubes = s @ mass @ s
    np.testing.assert_allclose(cubes, (s[-1] ** 3 - s[0] ** 3) / 3, rtol=ROUND_OFF, atol=0)
    places, weights, shapes = gauss_places(s, quadratic=quadratic)
    np.testing.assert_allclose(shapes @ s, places, rtol=ROUND_OFF, atol=0)
    np.testing.assert_allclose(weights.sum(), length, rtol=ROUND_OFF, atol=0)


@pytest.mark.parametrize("quadratic", [False, True], ids=["linear", "quadratic"])
@pytest.mark.parametrize("of_pressures", [False, True], ids=["forces", "pressures"])
def test_projection_is_exact_where_the_elements_are(quadratic: bool, of_pressures: bool) -> None:
    """A compliance that is a polynomial of the elements' degree along and across.

    Its nodal matrix is the polynomial at the nodes; that of the modes is an integral.
    """
    degree = 2 if quadratic else 1
    s = np.array([0.0, 0.3, 0.6, 1.1, 1.6, 1.8, 2.0])
    span = (0.0, 2.0)
    factor = np.random.default_rng(3).normal(size=(degree + 1, degree + 1))
    table = factor @ factor.T

    def powers(x: np.ndarray) -> np.ndarray:
        return x[:, None] ** np.arange(degree + 1)

    matrix = powers(s) @ table @ powers(s).T
    if of_pressures:
        mass = mass_matrix(s, quadratic=quadratic)
        matrix = mass @ matrix @ mass
    given = NodalCompliance(
        file=Path("made_up.npz"),
        plane="stress",
        arc_length_mm=s,
        quadratic=quadratic,
        of_pressures=of_pressures,
        offsets=np.array([0, 1]),
        matrix=np.stack([matrix, 0.5 * matrix]),
        asymmetry=0.0,
    )
    body = SimpleNamespace(
        imported=given, teeth=5, mode_range_mm=span, material=Material(206000.0, 0.3)
    )
    found = imported_compliance(body, modes=degree + 1, default_modes=9, plane="stress")  # type: ignore[arg-type]
    norms = mode_norms(span, degree + 1)
    response = found.smooth * norms[:, None] * norms
    response[0] -= found.near.kernel * projected_logarithm(degree + 1, 2.0)
    x, w = np.polynomial.legendre.leggauss(6)
    modes = mode_values(1 + x, span, degree + 1)
    seen = powers(1 + x).T @ (w[:, None] * modes)
    expected = seen.T @ table @ seen
    size = 10 * ROUND_OFF * np.abs(expected).max()
    for tooth, share in enumerate([1.0, 0.5, 0.0, 0.0, 0.5]):
        np.testing.assert_allclose(response[tooth], share * expected, rtol=0, atol=size)


# --- refusals -------------------------------------------------------------------------------------
def refusal_of(folder: Path, file: str) -> str:
    """The line for a file of body 1, without its folder."""
    scene = scene_of(folder, body_1={"kind": "compliance", "file": file})
    with pytest.raises(ComplianceFileError) as caught:
        fl.solve(scene)
    line = str(caught.value)
    assert "\n" not in line
    return line.removeprefix(f"{folder}/")


def drop(name: str) -> Callable[[dict], dict]:
    return lambda arrays: {key: value for key, value in arrays.items() if key != name}


def change(**values: Any) -> Callable[[dict], dict]:
    """Arrays replaced; a function makes the new one from the old one."""
    return lambda arrays: {
        **arrays,
        **{key: new(arrays[key]) if callable(new) else new for key, new in values.items()},
    }


def put(*place: int, value: float) -> Callable[[np.ndarray], np.ndarray]:
    def changed(array: np.ndarray) -> np.ndarray:
        copy = array.copy()
        copy[place] = value
        return copy

    return changed


OWN_REFUSALS = [
    (drop("smooth"), "smooth: expected numbers, found nothing: the file has format, version"),
    (drop("format"), "format: expected text, found nothing"),
    (change(format="another"), "format: expected 'flankload flank compliance' or 'flankload nodal"),
    (
        change(version=5),
        "version: expected at most 4, the latest version that this flankload reads, found 5",
    ),
    (
        change(version=0),
        "version: expected at most 4, the latest version that this flankload reads, found 0",
    ),
    (change(tip_corner_deg=-3.0), "tip_corner_deg: expected a number >= 30, found -3"),
    (change(version=1.5), "version: expected whole numbers, found 1.5"),
    (change(teeth=17), "smooth: expected an array of shape (17, any, any), found shape (16, 5, 5)"),
    (change(smooth=lambda a: a[:, :4]), "smooth: expected an array of shape (16, p, p), p >= 1"),
    (change(smooth=put(0, 1, 2, value=np.nan)), "smooth[0, 1, 2]: expected finite numbers"),
    (change(smooth=put(1, 0, 1, value=1.0)), "smooth: expected smooth[-t] to be smooth[t] transp"),
    (change(smooth=lambda a: -a), "smooth: expected a compliance that is positive definite"),
    (change(smooth=lambda a: a.astype(complex)), "smooth: expected real numbers, found values of"),
    (change(kernel=0.0), "kernel: expected a number > 0, found 0"),
    (change(plane="stress"), "plane: expected 'strain', as in accuracy.plane, found 'stress'"),
    (change(plane="skew"), "plane: expected 'strain' or 'stress', found 'skew'"),
    (change(mode_range_mm=[3.0, 99.0]), "mode_range_mm: expected two ascending arc lengths from 0"),
    (change(curve_breaks=lambda a: a[::-1]), "curve_breaks: expected arc lengths that ascend"),
    (change(curve_corners=lambda a: a[1:]), "curve_corners: expected"),
    (change(curve_labels=lambda a: a[1:]), "curve_labels: expected"),
    (change(curve_coefficients=put(1, 0, 0, value=0.0)), "curve_coefficients: expected intervals"),
    (
        change(curve_coefficients=lambda a: 1.01 * a),
        "curve_coefficients: expected a curve by its o",
    ),
    (change(outline=np.zeros((0, 2))), "outline: expected at least 3 places, found 0"),
    (change(teeth=1e9), "teeth: expected an integer from 3 to 10000, found 1000000000"),
    (change(flank_angle_known=2), "flank_angle_known: expected an integer from 0 to 1, found 2"),
    (change(pitch_errors_um=[1.0]), "pitch_errors_um: expected no entries or 16, found 1"),
    (change(pitch_errors_um=[1e6] * 16), "pitch_errors_um: expected at most 0.1 of the base pitch"),
    (
        change(flank_turns_rad=[7.0] * 16),
        "flank_turns_rad: expected angles from -pi to pi, found",
    ),
    (change(poisson_ratio=0.5), "poisson_ratio: expected a number < 0.5, found 0.5"),
    (change(kernel=np.nan), "kernel: expected finite numbers, found nan"),
    (change(young_modulus_MPa=1e12), "young_modulus_MPa: expected a number <= 1e+09, found 1e+12"),
    (
        change(involute_form_radius_mm=1e300),
        "involute_form_radius_mm: expected numbers of at most 1e+30, found 1e+300",
    ),
    (
        change(involute_form_radius_mm=1e29),
        "involute_form_radius_mm: expected a number <= 100000, found 1e+29",
    ),
    (
        change(involute_form_radius_mm=90.0),
        "involute_form_radius_mm: expected radii that ascend from the root over the form to the t",
    ),
    (
        change(involute_outward=0),
        "involute_outward: expected 1 (teeth outwards) or -1 (in",
    ),
    (change(involute_turn_rad=1e9), "involute_turn_rad: expected a number <= 6.28319, found 1e+09"),
    (drop("involute_tip_radius_mm"), "involute_tip_radius_mm: expected numbers, found nothing"),
    (change(smoth=1.0), "smoth: expected an array of this format"),
    (
        change(notes=np.array([{"a": 1}], dtype=object)),
        "notes: expected a .npz file of plain array",
    ),
]


@pytest.mark.parametrize(
    ("spoil", "line"), OWN_REFUSALS, ids=[line[:30] for _, line in OWN_REFUSALS]
)
def test_own_file_that_is_wrong_gets_one_line(
    spoil: Callable[[dict], dict], line: str, folder: Path, tmp_path: Path
) -> None:
    with np.load(folder / "body_1.npz") as archive:
        arrays = {name: archive[name] for name in archive.files}
    write_npz(tmp_path / "bad.npz", spoil(arrays))
    assert refusal_of(tmp_path, "bad.npz").startswith(f"bad.npz: {line}")


NODAL_REFUSALS = [
    (drop("points"), "points: expected numbers, found nothing"),
    (drop("columns"), "columns: expected text, found nothing"),
    (change(columns="forces"), "columns: expected 'nodal_forces' or 'nodal_pressures', found 'fo"),
    (change(elements="cubic"), "elements: expected 'linear' or 'quadratic', found 'cubic'"),
    (change(points=lambda a: a[:-1]), "points: expected an odd number: quadratic elements have"),
    (change(points=lambda a: a[:5]), "points: expected at least 6, found 5"),
    (change(points=lambda a: a[::-1]), "points: expected places from root to tip, the axis at"),
    (change(teeth_stand="inwards"), "points: expected places from root to tip, the axis at"),
    (change(teeth_stand="up"), "teeth_stand: expected 'outwards' or 'inwards', found 'up'"),
    (change(points=lambda a: a[[0, 2, 1, *range(3, len(a))]]), "points[1]: expected places in ord"),
    (change(points=lambda a: a[[0, 0, *range(2, len(a))]]), "points[1]: expected another place"),
    (change(points=put(3, 0, value=np.inf)), "points[3, 0]: expected finite numbers, found inf"),
    (change(compliance=lambda a: a[:, 1:]), "compliance: expected an array of shape (16, "),
    (change(compliance=lambda a: -a), "compliance: expected a positive definite matrix"),
    (change(compliance=put(0, 2, 3, value=0.0)), "compliance: expected a symmetric matrix"),
    (change(compliance=put(1, 2, 3, value=np.nan)), "compliance[1, 2, 3]: expected finite"),
    (change(offsets=lambda a: a + 1), "compliance: expected a symmetric matrix"),
    (change(offsets=lambda a: 2 * a), "offsets: expected teeth counted from the loaded one, 0 am"),
    (change(teeth=2), "teeth: expected an integer from 3 to 10000, found 2"),
    (change(poisson_ratio=0.5), "poisson_ratio: expected a number < 0.5, found 0.5"),
    (change(young_modulus_MPa=0.0), "young_modulus_MPa: expected a number > 0, found 0"),
    (change(reference_radius_mm=-1.0), "reference_radius_mm: expected a number > 0, found -1"),
    (change(plane="stress"), "plane: expected 'strain', as in accuracy.plane, found 'stress'"),
    (change(compliance_nt=0.0), "compliance_nt: expected an array of this format"),
]


@pytest.mark.parametrize(
    ("spoil", "line"), NODAL_REFUSALS, ids=[line[:30] for _, line in NODAL_REFUSALS]
)
def test_nodal_file_that_is_wrong_gets_one_line(
    spoil: Callable[[dict], dict], line: str, nodal: tuple[dict, dict], tmp_path: Path
) -> None:
    write_npz(tmp_path / "bad.npz", spoil(nodal[0]))
    assert refusal_of(tmp_path, "bad.npz").startswith(f"bad.npz: {line}")


TABLE_REFUSALS = [
    (lambda rows: [*rows[:-1], rows[-1] + ", 1"], "line {last}: expected {width} columns as in li"),
    (lambda rows: rows[:-1], "line {before}: expected {points} rows for each offset"),
    (lambda rows: [*rows[:-1], rows[-1].replace("0, ", "0, x", 1)], "line {last}: expected a numb"),
    (lambda rows: [*rows[:-1], "1" + rows[-1][1:]], "line {last}: expected offset 0"),
    (lambda rows: [row for row in rows if row[0] == "#"], "line 1: expected rows of offset, x_mm"),
    (lambda rows: [row for row in rows if "teeth" not in row], "teeth: expected numbers, found"),
    (lambda rows: ["# teeth = many", *rows[1:]], "format: expected text, found nothing"),
]


@pytest.mark.parametrize(
    ("spoil", "line"), TABLE_REFUSALS, ids=[line[:30] for _, line in TABLE_REFUSALS]
)
def test_table_that_is_wrong_gets_one_line(
    spoil: Callable[[list[str]], list[str]], line: str, nodal: tuple[dict, dict], tmp_path: Path
) -> None:
    arrays = {**nodal[0], "offsets": np.array([0]), "compliance": nodal[0]["compliance"][:1]}
    rows = csv_of(arrays).replace("\n0.0,", "\n0,").splitlines()
    (tmp_path / "bad.csv").write_text("\n".join(spoil(rows)), encoding="utf-8")
    n = len(arrays["points"])
    line = line.format(last=len(rows), before=len(rows) - 1, width=n + 3, points=n)
    assert refusal_of(tmp_path, "bad.csv").startswith(f"bad.csv: {line}")


@pytest.mark.parametrize(
    ("name", "content", "line"),
    [
        ("missing.npz", None, "expected a .npz or .csv file, found no such file"),
        ("body.txt", b"1", "expected a .npz or .csv file, found .txt"),
        (
            "text.npz",
            b"no archive",
            "expected a .npz file of plain arrays, found file is no",
        ),
        ("empty.npz", b"", "expected a .npz file of plain arrays, found"),
        ("bytes.csv", b"\xff\xfe\x00", "expected a table as text in UTF-8, found other bytes"),
        ("cut.npz", b"PK\x03\x04 cut", "expected a .npz file of plain arrays, found"),
    ],
)
def test_file_that_is_no_file_of_arrays(
    name: str, content: bytes | None, line: str, tmp_path: Path
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    assert refusal_of(tmp_path, name).startswith(f"{name}: body_1.file: {line}")


def test_pickle_is_never_loaded(tmp_path: Path) -> None:
    """A pickle with a side effect when loaded has none."""
    trace = tmp_path / "trace"

    class Touch:
        def __reduce__(self) -> tuple[Any, ...]:
            return Path.touch, (trace,)

    np.savez(tmp_path / "bad.npz", format=np.array([Touch()], dtype=object))
    assert "pickled objects, which are never loaded" in refusal_of(tmp_path, "bad.npz")
    assert not trace.exists()


def archive_with(path: Path, name: str, head: dict[str, Any], zeros: int, mode: str = "w") -> None:
    """An archive with an array of any stated size that unpacks to so many zeros."""
    head = {"descr": "<f8", "fortran_order": False, "shape": (), **head}
    with ZipFile(path, mode, ZIP_DEFLATED) as archive, archive.open(f"{name}.npy", "w") as out:
        np.lib.format.write_array_header_1_0(out, head)
        for _ in range(zeros // 2**24):
            out.write(bytes(2**24))
        out.write(bytes(zeros % 2**24))


@pytest.mark.parametrize(
    ("name", "head", "zeros", "line"),
    [
        (
            "bomb",
            {"shape": (2**28,)},
            2**26,
            "bomb: expected a .npz file of plain arrays, found",
        ),
        ("format", {"shape": (2**23,)}, 2**26, "format: expected 'flankload flank compliance' or"),
        ("format", {"descr": "<U16777216"}, 2**26, "format: expected 'flankload flank compliance'"),
        ("format", {"shape": (-1, -8)}, 64, "format: expected a .npz file of plain arrays, found"),
    ],
)
def test_archive_is_not_unpacked_before_its_heads_are_read(
    name: str, head: dict[str, Any], zeros: int, line: str, tmp_path: Path
) -> None:
    archive_with(tmp_path / "bad.npz", name, head, zeros)
    tracemalloc.start()
    said = refusal_of(tmp_path, "bad.npz")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert said.startswith(f"bad.npz: {line}")
    assert most < 2**22


def test_array_of_an_unknown_name_is_not_unpacked(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "body_1.npz", tmp_path / "bad.npz")
    archive_with(tmp_path / "bad.npz", "smoth", {"shape": (2**23,)}, 2**26, mode="a")
    tracemalloc.start()
    said = refusal_of(tmp_path, "bad.npz")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert said.startswith("bad.npz: smoth: expected an array of this format")
    assert most < 2**22


def test_archive_that_would_fill_the_memory_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("flankload.base.array_archive.MOST_BYTES", 2**20)
    archive_with(tmp_path / "bad.npz", "points", {"shape": (2**18,)}, 2**21)
    line = "bad.npz: body_1.file: expected a .npz file of plain arrays, found arrays of 0.00195 GiB"
    assert refusal_of(tmp_path, "bad.npz").startswith(line)


def test_pitch_errors_of_the_scene_must_fit_the_file(folder: Path) -> None:
    for errors, line in (
        ([1.0], "one entry per tooth: 16"),
        ([1e6] * 16, "at most 0.1 of the base pitch"),
    ):
        with pytest.raises(SceneError, match=rf"body_1\.pitch_errors_um: expected {line}"):
            solved(folder, body_1={**FROM_FILE_1, "pitch_errors_um": errors})


def test_check_says_what_is_in_a_file_and_what_is_wrong(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tables = {
        "body_1": {**FROM_FILE_1, "file": str(folder / "body_1.npz")},
        "body_2": TWO,
        "pair": {"center_distance_mm": 91.5, "face_width_mm": 14.0},
        "load": {"torque_Nm": 302.0},
    }
    path = tmp_path / "pair.toml"
    path.write_text(toml_of(tables), encoding="utf-8")
    assert main(["check", str(path)]) == 0
    assert "5 pressure modes from body_1.npz, plane strain" in capsys.readouterr().out
    path.write_text(toml_of({**tables, "accuracy": {"plane": "stress"}}), encoding="utf-8")
    assert main(["check", str(path)]) == 2
    assert "plane: expected 'stress', as in accuracy.plane" in capsys.readouterr().err


def test_no_mesh_of_a_body_from_a_file(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tables = {
        "body_1": {**FROM_FILE_1, "file": str(folder / "body_1.npz")},
        "body_2": {**TWO, "rigid": True},
        "pair": {"center_distance_mm": 91.5, "face_width_mm": 14.0},
        "load": {"torque_Nm": 302.0},
    }
    path = tmp_path / "pair.toml"
    path.write_text(toml_of(tables), encoding="utf-8")
    assert main(["mesh", str(path), "-o", str(tmp_path / "m")]) == 0
    assert "body_1: its compliance comes from a file, so it has no mesh" in capsys.readouterr().out


def test_nodes_of_the_helper_are_those_of_the_flank(fine: BodyPair) -> None:
    """The helper itself: its nodes lie on the exact profile, in order."""
    mesh = fine.body_1.mesh
    assert mesh is not None
    s, away = fine.body_1.curve.arc_length_of(mesh.nodes[flank_order(fine.body_1)])
    assert (np.diff(s) > 0).all()
    np.testing.assert_allclose(away, 0.0, rtol=0, atol=1e-8)


@pytest.mark.parametrize("outward", [1, -1])
def test_sketched_tooth_is_as_wide_as_its_space(outward: int) -> None:
    teeth, radius = 10, np.linspace(40.0, 44.0, 5)[::outward]
    flank = np.stack([radius * np.cos(0.3), radius * np.sin(0.3)], axis=1)
    angle = np.arctan2(*sketched_tooth(flank, teeth).T[::-1])
    assert np.ptp(angle) == pytest.approx(np.pi / teeth, rel=1e-12)
    assert (np.diff(angle) > -1e-12).all()
    # the flank of a tooth that points inwards faces clockwise
    assert (angle.max() if outward > 0 else angle.min()) == pytest.approx(0.3, rel=1e-12)
