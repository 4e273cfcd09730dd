"""Friction in three dimensions: plane limits, statics, work, symmetries, cost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.bodies.body import SectorMesh
from flankload.elasticity.compliance import BodyCompliance
from flankload.elasticity.near_field import mode_loads
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.three_dimensional import (
    HELICAL,
    MIRRORED,
    OTHER_HANDS,
    SMALL,
    deviation,
    solved,
    tree_of,
)
from tests.support.tolerances import SOLVER

SPUR = "external_gear"
#: Work of both torques and of friction over a period: residual of pairing on circles.
ENERGY = 1e-3
SHAFT = {
    "diameters_mm": [35.0],
    "lengths_mm": [120.0],
    "gear_position_mm": 50.0,
    "bearing_positions_mm": [10.0, 110.0],
    "radial_stiffness_N_per_um": [200.0, 300.0],
    "axial_stiffness_N_per_um": [0.0, 100.0],
}


def solve(name: str, mu: Any = 0.2, **changes: Any) -> fl.Result:
    """The small pair in three dimensions with friction; a scene is solved once."""
    keys = {"effects__dimension": 3, "effects__friction_coefficient": mu, **changes}
    return solved(name, keys)


def forces(result: fl.Result, p: int) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 3) and forces on body 2 (n, 3) of the contacts of a position."""
    table = result.pairs(p)
    assert table.z_mm is not None
    assert table.friction_force_N is not None
    assert result.slices is not None
    radius = 3.0 * 25 / 2 / np.cos(np.radians(15.0))
    lever = table.x_mm * table.normal_y - table.y_mm * table.normal_x
    slope = -np.tan(np.radians(15.0)) / radius * lever
    normal = np.column_stack([table.normal_x, table.normal_y, slope])
    normal /= np.hypot(1.0, slope)[:, None]
    along = np.column_stack([table.normal_y, -table.normal_x, np.zeros_like(slope)])
    force = table.force_N[:, None] * normal - table.friction_force_N[:, None] * along
    return np.column_stack([table.x_mm, table.y_mm, table.z_mm]), force


# --- plane limits ---------------------------------------------------------------------------------


def test_a_helix_begins_at_zero() -> None:
    helix = {"body_1__helix_angle_deg": 1e-4, "body_2__helix_angle_deg": 1e-4}
    found = solve(SPUR, body_1__hand="right", body_2__hand="left", **helix)
    none = solve(SPUR)
    assert deviation(found.rotation_rad, none.rotation_rad) < 1e-6
    assert found.friction is not None
    assert none.friction is not None
    assert deviation(found.friction.torque_2_Nm, none.friction.torque_2_Nm) < 1e-6
    assert deviation(found.slice_line_load_N_per_mm, none.slice_line_load_N_per_mm) < 1e-3


ELEMENTS = {"accuracy__modes": 3, "accuracy__flank_element_mm": 3.0}


def _compliance(**changes: Any) -> tuple[BodyCompliance, float]:
    scene = fl.Scene.from_dict(
        tree_of(SPUR, {**ELEMENTS, "effects__friction_coefficient": 0.1, **changes})
    )
    body = build_bodies(scene).body_1
    width = body.axial.width_mm
    return compliance_of(body, scene), width


def test_tangential_modes_of_a_wide_prism_are_those_of_the_plane() -> None:
    """Under even loads as in plane strain, except for the ends, an effect of 1/width.

    Measured, a neighbour: 15 % at 42 mm, 6.0 % at 126 mm; in the limit of both 1.3 %, on the tooth
    itself 0.6 %.
    """
    plane, _ = _compliance()
    wide = []
    for times in (3, 9):
        found, width = _compliance(
            effects__dimension=3,
            pair__face_width_mm=times * 14.0,
            accuracy__axial_degree=6,
            accuracy__load_degree_z=0,
        )
        assert found.tangential is not None
        assert found.near.jump == plane.near.jump
        assert found.near.wedge_along == plane.near.wedge_along
        wide.append(width * found.tangential)
        # the image of a line of the length w behind a corner: c/w (ln(2 w/x) - 1)
        image = sum(found.near.wedge_along) * found.near.kernel
        wide[-1][0, 0, 0] += image * (np.log(2.0 * width) - 1.0)
    assert plane.tangential is not None
    limit = (3 * wide[1] - wide[0]) / 2
    for tooth in (0, 1, -1):
        scale = np.abs(plane.tangential[tooth]).max()
        np.testing.assert_allclose(
            limit[tooth], plane.tangential[tooth], rtol=0.0, atol=0.02 * scale
        )


def test_loads_along_the_profile_are_per_area() -> None:
    """Area elements ds dz/cos(beta_b) of involutes, directions in the section."""
    keys = ("tip_relief_um", "tip_relief_start_diameter_mm", "tip_relief_shape")
    scene = fl.Scene.from_dict(tree_of(HELICAL, SMALL | {f"body_1__{k}": None for k in keys}))
    body = build_bodies(scene).body_1
    assert isinstance(body.mesh, SectorMesh)
    twist = body.axial.twist_rad_per_mm
    plane, found = (
        mode_loads(body.mesh, body.mode_range_mm, 2, along="tangent", twist=kappa)
        for kappa in (None, twist)
    )
    found, plane = found.reshape(-1, 3, 2), plane.reshape(-1, 2, 2)
    secant = np.hypot(1.0, twist * body.base_radius_mm)
    scale = np.abs(plane).max()
    np.testing.assert_allclose(found[:, :2], secant * plane, rtol=0.0, atol=1e-4 * scale)
    assert not found[:, 2].any()


# --- cells ----------------------------------------------------------------------------------------

CELLS = {"effects__contact": "pairs"}


@pytest.mark.parametrize("shafts", [{}, {"body_1__shaft": SHAFT, "body_2__shaft": SHAFT}])
def test_slices_are_cells_as_a_whole(shafts: dict[str, Any]) -> None:
    """Rotation, torque on body 2 and loss 0.2 %; on shafts tips carry more, loss 0.5 %."""
    keys: dict[str, Any] = {"mu": 0.3, "accuracy__slices": 12, **shafts}
    cells, slices = solve(HELICAL, **CELLS, **keys), solve(HELICAL, **keys)
    assert cells.friction is not None
    assert slices.friction is not None
    assert not cells.status.any()
    assert cells.rotation_rad.mean() == pytest.approx(slices.rotation_rad.mean(), rel=2e-3)
    for name in ("torque_2_Nm", "loss_J_per_rad"):
        one, two = getattr(cells.friction, name), getattr(slices.friction, name)
        assert one.mean() == pytest.approx(two.mean(), rel=5e-3 if shafts else 2e-3)


def test_shafts_give_way_to_friction_of_cells() -> None:
    """The rotation added by friction on a soft shaft is that of slices to 1.4 %; without tips."""
    stiff = {"radial_stiffness_N_per_um": [50.0, 75.0], "axial_stiffness_N_per_um": [0.0, 25.0]}
    keys = {"body_1__shaft": SHAFT | stiff, "load__torque_Nm": 80.0, "accuracy__slices": 12}
    added = [
        solve(HELICAL, mu=0.3, **keys, **level).rotation_rad
        - solve(HELICAL, mu=None, **keys, **level).rotation_rad
        for level in (CELLS, {})
    ]
    assert deviation(*added) < 3e-2


def test_sliding_changes_its_sign_within_a_position() -> None:
    """On both sides of the pitch point cells rub in opposite directions."""
    table = solve(HELICAL, **CELLS).pairs(0)
    assert table.friction_force_N is not None
    assert table.sliding_mm_per_rad is not None
    loaded = table.force_N > 0
    part = table.friction_force_N[loaded] / table.force_N[loaded]
    assert part.max() == pytest.approx(0.2, rel=SOLVER)
    assert part.min() == pytest.approx(-0.2, rel=SOLVER)
    assert (part * table.sliding_mm_per_rad[loaded] >= 0.0).all()


# --- symmetries -----------------------------------------------------------------------------------


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
def test_a_mirrored_scene(contact: str) -> None:
    """z becomes -z and the hands change, on a shaft, with a slope."""
    one_sided = {"body_1__helix_slope_um": 12.0, "body_2__axial_offset_mm": 2.0}
    other_side = {"body_1__helix_slope_um": -12.0, "body_2__axial_offset_mm": -2.0}
    shaft = {**SHAFT, "bearing_positions_mm": [10.0, 90.0]}
    turned = {
        **SHAFT,
        "gear_position_mm": 70.0,
        "bearing_positions_mm": [30.0, 110.0],
        **{key: SHAFT[key][::-1] for key in SHAFT if "stiffness" in key},
    }
    keys = {"effects__contact": contact}
    one = solve(HELICAL, **one_sided, body_1__shaft=shaft, **keys)
    two = solve(HELICAL, **other_side, **OTHER_HANDS, body_1__shaft=turned, **keys)
    assert deviation(two.rotation_rad, one.rotation_rad) < MIRRORED
    loads = two.slice_line_load_N_per_mm[..., ::-1]
    assert deviation(loads, one.slice_line_load_N_per_mm) < 10 * MIRRORED
    assert deviation(-two.axial_force_N, one.axial_force_N) < MIRRORED
    assert one.friction is not None
    assert two.friction is not None
    assert deviation(two.friction.torque_2_Nm, one.friction.torque_2_Nm) < MIRRORED


# --- statics and work -----------------------------------------------------------------------------


def test_forces_hold_the_torque_and_the_bearings_hold_the_forces() -> None:
    result = solve(HELICAL, body_1__shaft=SHAFT)
    assert result.friction is not None
    assert result.shafts is not None
    for p in range(result.position_rad.size):
        place, force = forces(result, p)
        torque_1 = np.cross(place, force)[:, 2].sum()
        assert torque_1 == pytest.approx(result.torque_Nm * 1e3, rel=1e-4)
        place[:, 0] -= 132.0
        torque_2 = np.cross(place, force)[:, 2].sum() / 1e3
        assert torque_2 == pytest.approx(-result.friction.torque_2_Nm[p], rel=SOLVER)
        on_bearings = result.shafts.bearing_force_1_N[p].sum(axis=0)
        np.testing.assert_allclose(on_bearings, -force.sum(axis=0), rtol=0.0, atol=0.1)
        rubbing = result.pairs(p).friction_force_N @ result.pairs(p).z_mm / 1e3
        assert result.friction.tilting_moment_Nm[p] == pytest.approx(rubbing, rel=SOLVER)
        assert result.axial_force_N[p] == pytest.approx(-force[:, 2].sum(), rel=1e-3)


@pytest.mark.parametrize("name", [SPUR, HELICAL, "internal_helical"])
def test_work_over_a_period(name: str) -> None:
    """Work of body 1 = work on body 2 + loss; measured 1e-4 (spur), 1e-5 and 6e-5 (helical)."""
    friction = solve(name, mu=0.1, positions__count=16).friction
    assert friction is not None
    work_1, work_2, loss = friction.work_1_J, friction.work_2_J, friction.loss_work_J
    assert work_1 is not None
    assert work_2 is not None
    assert loss is not None
    assert 0.004 < loss / work_1 < 0.03
    assert work_2 + loss == pytest.approx(work_1, rel=ENERGY * loss / work_1 * 10)


def test_work_of_cells_over_a_period() -> None:
    """Measured 2.7e-4 of the work; without friction the pairing on circles leaves 2.2e-4."""
    friction = solve(HELICAL, mu=0.1, positions__count=8, **CELLS).friction
    assert friction is not None
    work_1, work_2, loss = friction.work_1_J, friction.work_2_J, friction.loss_work_J
    assert work_1 is not None
    assert work_2 is not None
    assert loss is not None
    assert work_2 + loss == pytest.approx(work_1, rel=ENERGY)


def test_friction_changes_axial_forces_and_tilt() -> None:
    without, found = (solve(HELICAL, mu=mu) for mu in (None, 0.2))
    for name in ("axial_force_N", "tilting_moment_Nm"):
        assert deviation(getattr(found, name), getattr(without, name)) > 0.01
    # friction of the driver helps on one side of the pitch point and hinders on the other
    back = solve(HELICAL, positions__driver="body_2")
    assert deviation(back.rotation_rad, found.rotation_rad) > 0.01


def test_small_friction_is_small() -> None:
    """Changes are proportional to a small coefficient."""
    without, little, more = (solve(HELICAL, mu=mu) for mu in (None, 1e-4, 2e-4))
    once, twice = (found.rotation_rad - without.rotation_rad for found in (little, more))
    np.testing.assert_allclose(twice, 2.0 * once, rtol=0.0, atol=1e-2 * np.abs(once).max())


# --- cost -----------------------------------------------------------------------------------------


def test_loads_along_the_flank_are_solved_for_friction_and_sharp_tips() -> None:
    counts = []
    for mu in (None, 0.0, 0.2):
        changes = {**SMALL, "effects__dimension": 3, "effects__friction_coefficient": mu}
        scene = fl.Scene.from_dict(tree_of(SPUR, {**changes, "positions__count": 1}))
        stage = fl.solve(scene).cost["stages"]["compliance body 1"]
        counters, predicted = stage["counters"], stage["predicted"]["counters"]
        names = ("unit_loads_normal", "unit_loads_tangential", "corner_readings")
        counts.append(tuple(counters.get(name, 0) for name in names))
        assert counters["fe_solutions"] == predicted["fe_solutions"] == sum(counts[-1])
    assert counts == [(6, 0, 6), (6, 0, 6), (6, 6, 0)]


def test_a_jammed_pair_names_the_torque_that_it_holds() -> None:
    with pytest.raises(fl.FlankloadError, match="jams by friction"):
        solve(
            SPUR,
            mu=1.5,
            positions__count=None,
            positions__angles_deg=[-6.0],
            positions__driver="body_2",
        )
