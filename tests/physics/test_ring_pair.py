"""A gear inside a ring against plain finite elements, and identities without a reference."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from flankload.bodies.imported.body_file import write_body
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.paths import SCENES
from tests.support.plain_elements import FILE, solve_plainly
from tests.support.solving import solve

REFERENCE = json.loads(FILE.read_text(encoding="utf-8"))
EXAMPLE = SCENES / "internal_gear.toml"
#: Rotation (relative) and forces (of the sum) off sharp corners; on them, where the plain elements
#: take each flank's own normal and five modes follow the load at the flank's very end less well.
INTERIOR, CORNER = 3e-3, 1.5e-2
#: Twice the element length: error of the plain solution off the corners.
COARSE = 4e-3


def scene(**tables: dict) -> fl.Scene:
    """The scene of the reference with other keys in its tables."""
    given = deepcopy(REFERENCE["scene"]) | {"accuracy": {"estimate": False, "tangents": False}}
    for name, keys in tables.items():
        given[name] = {**given[name], **keys}
    return fl.Scene.from_dict(given)


@pytest.fixture(scope="module")
def result() -> fl.Result:
    return solve(scene())


def test_rotation_and_forces_are_those_of_plain_elements(result: fl.Result) -> None:
    corner = result.corner_contact.any(axis=1)
    assert (~corner).sum() >= 6
    bound = np.where(corner, CORNER, INTERIOR)
    expected = np.array(REFERENCE["rotation_rad"])
    assert (np.abs(result.rotation_rad / expected - 1) < bound).all()
    columns = [REFERENCE["sites"].index(site) for site in result.sites]
    forces = np.array(REFERENCE["site_force_N"])
    assert forces.sum() == pytest.approx(forces[:, columns].sum(), rel=1e-9)
    miss = np.abs(result.site_force_N - forces[:, columns]).max(axis=1)
    assert (miss < bound * forces.sum(axis=1)).all()


def test_stored_reference_is_the_result_of_its_script(result: fl.Result) -> None:
    """The same script, live, with elements of twice the length, where no corner works."""
    chosen = np.flatnonzero(~result.corner_contact.any(axis=1))[::3]
    angles = np.degrees(result.position_rad[chosen])
    given = {**REFERENCE["scene"], "positions": {"angles_deg": angles.tolist()}}
    settings = {"element_mm": 0.05, "inner_mm": 0.8, "cell_mm": 0.05}
    rotation, force, _ = solve_plainly(given, **settings, rotation_rad=result.rotation_rad[chosen])
    stored = np.array(REFERENCE["rotation_rad"])[chosen]
    np.testing.assert_allclose(rotation, stored, rtol=COARSE, atol=0)
    np.testing.assert_allclose(rotation, result.rotation_rad[chosen], rtol=COARSE, atol=0)
    assert (rotation < stored).all()  # elements of finite length are too stiff
    np.testing.assert_allclose(
        force.max(axis=1), np.array(REFERENCE["site_force_N"])[chosen].max(axis=1), rtol=COARSE
    )


def test_torques_are_in_the_ratio_of_the_teeth(result: fl.Result) -> None:
    """T2, the moment about O2 of the forces at A along n1, is T1 z2/z1, in the same sense."""
    distance = REFERENCE["scene"]["pair"]["center_distance_mm"]
    interior = np.flatnonzero(~result.corner_contact.any(axis=1))
    assert interior.size
    for k in interior:
        pairs = result.pairs(int(k))
        along_x, along_y = pairs.force_N * pairs.normal_x, pairs.force_N * pairs.normal_y
        moment_1 = np.sum(pairs.x_mm * along_y - pairs.y_mm * along_x)
        moment_2 = np.sum((pairs.x_mm - distance) * along_y - pairs.y_mm * along_x)
        assert moment_1 == pytest.approx(300e3, rel=1e-9)
        assert moment_2 / moment_1 == pytest.approx(60 / 24, rel=1.5e-3)


def test_unloaded_conjugate_flanks_touch_everywhere() -> None:
    found = solve(scene(load={"torque_Nm": 0.0}, positions={"count": 200}))
    np.testing.assert_allclose(found.transmission_error_um, 0.0, rtol=0, atol=1e-5)


def test_state_is_in_balance_and_nothing_penetrates(result: fl.Result) -> None:
    for k in range(result.position_rad.size):
        pairs = result.pairs(k)
        assert (pairs.force_N >= 0).all()
        assert (pairs.gap_um >= -1e-8).all()
        assert not (pairs.force_N * pairs.gap_um).any()


def test_answer_repeats_after_a_pitch_and_after_many() -> None:
    first = solve(scene(positions={"count": 4})).rotation_rad
    one = {"angles_deg": [15.0 * turn + 3.75 * k for turn in (0, 1, 7, -9) for k in range(4)]}
    given = deepcopy(REFERENCE["scene"]) | {
        "positions": one,
        "accuracy": {"estimate": False, "tangents": False},
    }
    found = solve(fl.Scene.from_dict(given)).rotation_rad.reshape(4, 4)
    np.testing.assert_allclose(found, np.broadcast_to(first, (4, 4)), rtol=1e-9, atol=0)


def test_pitch_error_of_the_ring_takes_load_from_its_tooth(result: fl.Result) -> None:
    """Metal that touches early carries more, that of the tooth of pair 0."""
    zero = result.sites.tolist().index(0)
    shares = []
    for error in (-3.0, 0.0, 3.0):
        errors = [error, *([0.0] * 59)]
        found = solve(scene(body_2={"pitch_errors_um": errors}))
        shares.append(found.load_share[6, found.sites.tolist().index(0)])
    assert shares[0] < shares[1] < shares[2]
    assert shares[1] == pytest.approx(result.load_share[6, zero], rel=1e-9)


def test_root_fillet_of_the_ring_carries_contact() -> None:
    """A pinion tip that reaches beyond the form circle presses on the fillet."""
    keys = {"body_1": {"tip_diameter_mm": 79.4}, "body_2": {"root_diameter_mm": 187.6}}
    found = solve(scene(**keys, pair={"center_distance_mm": 53.9}, positions={"count": 24}))
    form = build_bodies(scene(**keys)).body_2.mode_range_mm[0]
    deepest = []
    for k in range(24):
        pairs = found.pairs(k)
        deepest.append(pairs.arc_length_2_mm[pairs.force_N > 0].min())
    assert min(deepest) < form - 0.05
    assert any("below the active flank of body_2" in warning for warning in found.warnings)
    assert any("beyond the form circle of body_2" in warning for warning in found.warnings)


def test_meshes_of_both_bodies_give_the_result_of_the_parameters(
    result: fl.Result, tmp_path: Path
) -> None:
    """Flanks from nodes alone: a ring is recognized by the nodes held outside its flank."""
    pair = build_bodies(scene())
    given = deepcopy(REFERENCE["scene"]) | {"accuracy": {"estimate": False, "tangents": False}}
    for key, body, turn in (
        ("body_1", pair.body_1, pair.pairing.turns_at_zero_rad[0]),
        ("body_2", pair.body_2, pair.pairing.turns_at_zero_rad[1]),
    ):
        write_body(tmp_path / f"{key}.msh", body.mesh, turn_rad=turn)
        given[key] = {"kind": "mesh", "file": str(tmp_path / f"{key}.msh"), "teeth": body.teeth}
        given[key]["reference_radius_mm"] = body.reference_radius_mm
    found = solve(fl.Scene.from_dict(given))
    assert not any("mirror" in warning for warning in found.warnings)
    smooth = ~result.corner_contact.any(axis=1)
    np.testing.assert_allclose(
        found.rotation_rad[smooth], result.rotation_rad[smooth], rtol=3e-3, atol=0
    )


def test_relief_and_rounding_take_load_from_the_tips() -> None:
    body = {"tip_radius_mm": 0.3, "tip_relief_um": 20.0, "tip_relief_shape": "parabolic"}
    plain = solve(scene())
    found = solve(
        scene(
            body_1={**body, "tip_relief_start_diameter_mm": 76.0},
            body_2={**body, "tip_relief_start_diameter_mm": 177.0},
        )
    )
    assert not found.corner_contact.any()
    assert plain.corner_contact.any()
    ratio = "contact_ratio_under_load"
    assert found.summary[ratio] < plain.summary[ratio]


def test_example_has_two_loaded_pairs_at_every_position() -> None:
    found = solve(fl.read_scene(EXAMPLE))
    assert ((found.site_force_N > 0).sum(axis=1) >= 2).all()
    assert not any("reaches" in warning for warning in found.warnings)
    theory = 1.664
    assert found.summary["contact_ratio_under_load"] > theory
