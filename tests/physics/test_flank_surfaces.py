"""Metal removed over height and width of a flank, and helix slopes of single teeth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.base.arrays import Floats
from flankload.bodies.profile_deviation import deviation_at
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.paths import SCENES
from tests.support.three_dimensional import (
    HELICAL,
    MIRRORED,
    OTHER_HANDS,
    SMALL,
    deviation,
    solve_small,
    tree_of,
)
from tests.support.tolerances import ROUND_OFF, SOLVER

WIDTH = 25.0
#: Diameters of the active flank of the pinion, beyond the active flank by rounding of the file.
LOW, HIGH = 73.951, 84.8
#: A key is a gap at the least gap of the flank without it, a grid the modified flank: half of this
#: difference is the place of contact in the tip relief, which moves by the metal removed.
FIRST_ORDER = 4e-3
#: Forces have the direction of the flank without the grid: a relief of 20 um turns them a little.
DIRECTION = 1e-3
NO_RELIEF = {
    "body_1__tip_relief_um": None,
    "body_1__tip_relief_start_diameter_mm": None,
    "body_1__tip_relief_shape": None,
}
NO_CROWN = {"body_1__lead_crowning_um": None}


def solve(**changes: Any) -> fl.Result:
    found = solve_small(HELICAL, changes)
    assert isinstance(found, fl.Result)
    return found


def write_grid(
    path: Path,
    removed_um: Callable[[float, float], float],
    *,
    rows: int = 12,
    columns: int = 2,
) -> str:
    """A file with the metal removed at diameters and distances from the end of smaller z."""
    z = np.linspace(0.0, WIDTH, columns)
    lines = [",".join(["diameter_mm", *(f"{at:.9g}" for at in z)])]
    for diameter in np.linspace(LOW, HIGH, rows):
        values = [f"{removed_um(float(diameter), float(at)):.9g}" for at in z]
        lines.append(",".join([f"{diameter:.9g}", *values]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(path)


def pinion(**changes: Any) -> Any:
    return build_bodies(fl.Scene.from_dict(tree_of(HELICAL, {**SMALL, **changes}))).body_1


def removed_from_plane_flank(**keys: Any) -> Callable[[float, float], float]:
    """Metal removed from the flank of a plane profile, by the turn of each of its points."""
    body, plain = pinion(**{**NO_RELIEF, **keys}), pinion(**NO_RELIEF)
    points = body.curve.point(np.linspace(*body.mode_range_mm, 2001))
    radii, angles = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    nominal = np.array([plain.involute.polar_angle_at(radius) for radius in radii])
    removed = 1000.0 * plain.base_radius_mm * (nominal - angles)
    return lambda diameter, _: float(np.interp(0.5 * diameter, radii, removed))


# --- a grid that reproduces a key -----------------------------------------------------------------


def test_a_topography_of_lead_crowning_is_lead_crowning(tmp_path: Path) -> None:
    """Chords of the parabola: an error of second order in the distance of the columns."""
    crowned = solve(body_1__lead_crowning_um=8.0)
    errors = []
    for columns in (9, 33):
        grid = write_grid(
            tmp_path / f"{columns}.csv",
            lambda _, z: 8.0 * (2 * z / WIDTH - 1) ** 2,
            columns=columns,
        )
        found = solve(**NO_CROWN, body_1__topography_file=grid)
        errors.append(deviation(found.rotation_rad, crowned.rotation_rad))
    assert errors[1] < 3e-4
    assert errors[1] < errors[0] / 8
    loads = found.slice_line_load_N_per_mm, crowned.slice_line_load_N_per_mm
    assert deviation(*loads) < FIRST_ORDER
    plain = solve(**NO_CROWN)
    assert deviation(plain.slice_line_load_N_per_mm, loads[1]) > 0.3


@pytest.mark.parametrize(
    "keys",
    [
        {
            "body_1__tip_relief_um": 20,
            "body_1__tip_relief_start_diameter_mm": 80.0,
            "body_1__tip_relief_shape": "parabolic",
        },
        {"body_1__profile_crowning_um": 12},
    ],
    ids=["tip relief", "profile crowning"],
)
def test_a_topography_alike_over_the_width_is_the_plane_profile(
    keys: dict[str, Any], tmp_path: Path
) -> None:
    """Place of least gap and curvature are those of the modified flank."""
    grid = write_grid(tmp_path / "profile.csv", removed_from_plane_flank(**keys), rows=80)
    for rigid, tolerance in ((True, 1e-4), (False, DIRECTION)):
        by_key = solve(**{**NO_RELIEF, **keys}, body_1__rigid=rigid)
        found = solve(**NO_RELIEF, body_1__topography_file=grid, body_1__rigid=rigid)
        assert deviation(found.rotation_rad, by_key.rotation_rad) < tolerance
        assert deviation(found.site_force_N, by_key.site_force_N) < 1.5 * tolerance
        loads = found.slice_line_load_N_per_mm, by_key.slice_line_load_N_per_mm
        assert deviation(*loads) < FIRST_ORDER
        pressures = found.slice_peak_pressure_MPa, by_key.slice_peak_pressure_MPa
        assert deviation(*pressures) < FIRST_ORDER
    plain = solve(**NO_RELIEF)
    assert deviation(plain.slice_peak_pressure_MPa, pressures[1]) > 0.05


def test_a_topography_of_twist_is_twist(tmp_path: Path) -> None:
    """Linear in the arc length of the active flank, and linear over the width."""
    body = pinion()
    s = np.linspace(*body.mode_range_mm, 2001)
    at = 2.0 * np.hypot(*body.curve.point(s).T)

    def twisted(diameter: float, z: float) -> float:
        xi = float(np.interp(diameter, at, (s - s[0]) / (s[-1] - s[0])))
        return 0.5 * 14.0 * (2 * z / WIDTH - 1) * (2 * xi - 1)

    grid = write_grid(tmp_path / "twist.csv", twisted)
    one, two = solve(body_1__profile_twist_um=14.0), solve(body_1__topography_file=grid)
    assert deviation(two.rotation_rad, one.rotation_rad) < 1e-6
    assert deviation(two.slice_line_load_N_per_mm, one.slice_line_load_N_per_mm) < 1e-5
    plain = solve()
    assert deviation(plain.slice_line_load_N_per_mm, one.slice_line_load_N_per_mm) > 0.1


# --- plane scenes ---------------------------------------------------------------------------------


def test_keys_of_zero_leave_a_plane_scene_as_it_is(tmp_path: Path) -> None:
    """The same work and the same bits; a topography of zeros is three-dimensional."""
    coarse = {"accuracy__flank_element_mm": 3.0, "accuracy__modes": 3, "positions__count": 2}
    coarse["accuracy__tangents"] = True
    zeros = {"body_1__profile_twist_um": 0.0, "body_2__tooth_helix_slope_um": [0.0] * 24}
    grid = tmp_path / "zeros.csv"
    grid.write_text("d_mm,0,14\n60,0,0\n90,0,0\n", encoding="utf-8")
    spatial = {"body_1__topography_file": str(grid), "effects__contact": "lumped"}
    counted, found = [], []
    for keys in ({}, zeros, spatial):
        result = fl.solve(fl.Scene.from_dict(tree_of("external_gear", {**coarse, **keys})))
        stages = result.cost["stages"].values()
        counted.append([{**stage["counters"]} for stage in stages])
        found.append(result)
    assert counted[1] == counted[0]
    assert counted[2] != counted[0]
    np.testing.assert_array_equal(found[1].rotation_rad, found[0].rotation_rad)
    np.testing.assert_array_equal(found[1].site_force_N, found[0].site_force_N)
    assert found[0].slices is None
    assert found[2].slices is not None


# --- symmetries -----------------------------------------------------------------------------------


def test_a_mirrored_scene_with_surfaces_and_slopes(tmp_path: Path) -> None:
    """z becomes -z and the hands change: mirrored line loads, the same rotation."""

    def bumps(diameter: float, z: float) -> float:
        return 3.0 * np.sin(diameter) + 0.4 * z + 2.0 * np.cos(0.3 * z + 0.2 * diameter)

    slopes = np.linspace(-10.0, 14.0, 25)
    forwards = write_grid(tmp_path / "one.csv", bumps, rows=9, columns=6)
    backwards = write_grid(
        tmp_path / "two.csv", lambda d, z: bumps(d, WIDTH - z), rows=9, columns=6
    )
    one = solve(
        body_1__topography_file=forwards,
        body_1__tooth_helix_slope_um=slopes.tolist(),
        body_2__profile_twist_um=9.0,
    )
    two = solve(
        body_1__topography_file=backwards,
        body_1__tooth_helix_slope_um=(-slopes).tolist(),
        body_2__profile_twist_um=-9.0,
        **OTHER_HANDS,
    )
    assert deviation(two.rotation_rad, one.rotation_rad) < MIRRORED
    loads = two.slice_line_load_N_per_mm[..., ::-1]
    assert deviation(loads, one.slice_line_load_N_per_mm) < 10 * MIRRORED
    assert deviation(loads[..., ::-1], one.slice_line_load_N_per_mm) > 0.1


# --- single teeth ---------------------------------------------------------------------------------


@pytest.mark.parametrize("slope", [12.0, -12.0])
def test_equal_helix_slopes_of_all_teeth_are_the_helix_slope(slope: float) -> None:
    one = solve(body_1__helix_slope_um=slope)
    two = solve(body_1__tooth_helix_slope_um=[slope] * 25)
    assert deviation(two.rotation_rad, one.rotation_rad) < SOLVER
    assert deviation(two.slice_line_load_N_per_mm, one.slice_line_load_N_per_mm) < SOLVER


def test_helix_slopes_add_to_that_of_all_teeth() -> None:
    one = solve(body_2__helix_slope_um=12.0)
    two = solve(body_2__helix_slope_um=5.0, body_2__tooth_helix_slope_um=[7.0] * 60)
    assert deviation(two.rotation_rad, one.rotation_rad) < SOLVER


@pytest.mark.parametrize(("number", "teeth"), [(1, 25), (2, 60)])
def test_a_sloped_tooth_is_the_one_with_a_pitch_error(number: int, teeth: int) -> None:
    """Both lists count the teeth in the order in which they come into contact."""
    for entry in (3, teeth - 1):
        slopes, errors = [0.0] * teeth, [0.0] * teeth
        slopes[entry], errors[entry] = 30.0, -15.0
        keys = {"positions__pitches": 6, "positions__count": 1}
        plain = solve(**keys).rotation_rad
        sloped = solve(**keys, **{f"body_{number}__tooth_helix_slope_um": slopes}).rotation_rad
        moved = solve(**keys, **{f"body_{number}__pitch_errors_um": errors}).rotation_rad
        touched = [abs(found - plain) > 1e-2 * plain for found in (sloped, moved)]
        assert touched[0].any()
        np.testing.assert_array_equal(*touched)


def test_sloped_teeth_over_the_whole_period() -> None:
    """A tooth that is sloped by 20 um carries less at one of its ends."""
    slopes = [0.0] * 25
    slopes[3] = 20.0
    found = solve(
        body_1__tooth_helix_slope_um=slopes, positions__pitches="hunting", positions__count=2
    )
    assert found.position_rad.size == 50
    plain = solve(positions__count=2)
    apart = np.abs(found.rotation_rad.reshape(-1, 2) - plain.rotation_rad).max(axis=1)
    assert apart.max() > 1e-2 * plain.rotation_rad.max()
    assert (apart < 1e-3 * plain.rotation_rad.max()).sum() >= 20  # elsewhere nothing is new


# --- the flanks of the slices ---------------------------------------------------------------------


def test_flanks_of_slices_deviate_by_the_metal_removed(tmp_path: Path) -> None:
    """Along the base tangent, at the diameters of the file; tip and root keep their circles."""
    from flankload.bodies.flank_surface import section_curves

    grid = write_grid(
        tmp_path / "grid.csv", lambda d, z: 8.0 + 0.5 * (d - 80.0) - 0.2 * z, rows=5, columns=3
    )
    pair = build_bodies(
        fl.Scene.from_dict(
            tree_of(HELICAL, {**SMALL, **NO_RELIEF, "body_1__topography_file": grid})
        )
    )
    body, slices = pair.body_1, pair.slices
    assert slices.surfaces_mm[0] is not None
    assert slices.surfaces_mm[1] is None
    curves = section_curves(body, slices.surfaces_mm[0])
    assert len(curves) == slices.count == 8
    s = np.linspace(*body.mode_range_mm, 50)
    for z, curve in zip(slices.z_mm + 0.5 * WIDTH, curves, strict=True):
        points = curve.point(s)
        np.testing.assert_allclose(np.hypot(*points.T), np.hypot(*body.curve.point(s).T), rtol=1e-9)
        removed = -1000.0 * deviation_at(body.involute, points)[1]
        # cubic through 5 rows of a line in the diameter, which is no line in the arc length
        expected = 8.0 + 0.5 * (2.0 * np.hypot(*points.T) - 80.0) - 0.2 * z
        np.testing.assert_allclose(removed, expected, rtol=0.0, atol=5e-3)
        ends = [curve.breaks[0], curve.length_mm]
        np.testing.assert_allclose(
            np.hypot(*curve.point(ends).T), np.hypot(*body.curve.point(ends).T), rtol=1e-12
        )
        # smooth at all breaks of the active flank
        inner = curve.breaks[(curve.breaks > s[0]) & (curve.breaks < s[-1])]
        beside = 1e-7
        np.testing.assert_allclose(
            curve.curvature(inner - beside), curve.curvature(inner + beside), rtol=0.0, atol=1e-5
        )


def test_a_surface_of_zeros_changes_nothing(tmp_path: Path) -> None:
    grid = write_grid(tmp_path / "zeros.csv", lambda _, __: 0.0)
    one, two = solve(), solve(body_1__topography_file=grid)
    assert deviation(two.rotation_rad, one.rotation_rad) < SOLVER
    assert deviation(two.slice_line_load_N_per_mm, one.slice_line_load_N_per_mm) < 1e-7


def test_rounded_tips_and_active_flanks_alone() -> None:
    """The tip follows the end of the flank; without tip contact, the flanks of slices are cut."""
    tip = {**NO_RELIEF, "body_1__tip_radius_mm": 0.3}
    for keys in (tip, {"effects__tip_contact": False}):
        plain = solve(**keys)
        # conjugate flanks: more of it decides where a gap that is even is least
        found = solve(**keys, body_1__profile_twist_um=1e-8)
        assert deviation(found.rotation_rad, plain.rotation_rad) < SOLVER
        twisted = solve(**keys, body_1__profile_twist_um=10.0)
        assert 1e-4 < deviation(twisted.rotation_rad, plain.rotation_rad) < 0.1


@pytest.mark.parametrize("twist", [100.0, -150.0])
def test_places_are_found_where_the_metal_removed_changes_much(twist: float) -> None:
    """s is not the arc length of this flank, so one step along its tangent is not exact."""
    found = solve(body_1__profile_twist_um=twist)
    twist_per_mm = pinion().axial.twist_rad_per_mm
    for p in range(found.position_rad.size):
        table = found.pairs(p)
        lever = table.x_mm * table.normal_y - table.y_mm * table.normal_x
        torque = table.force_N / np.hypot(1.0, twist_per_mm * lever) * lever
        # rotation and torque share a lever of both bodies, also where a tip corner carries
        assert abs(torque.sum()) == pytest.approx(250e3, rel=3e-3)


def test_added_metal_that_takes_up_the_backlash_is_refused(tmp_path: Path) -> None:
    """80 um on all flanks are a pitch error of all teeth."""
    grid = write_grid(tmp_path / "thick.csv", lambda _, __: -80.0)
    for key, value in (("topography_file", grid), ("pitch_errors_um", [80.0] * 25)):
        with pytest.raises(fl.PremiseError, match=r"14\.8 um of overlap") as caught:
            solve(load__torque_Nm=1.0, **{f"body_1__{key}": value})
        assert caught.value.key == f"body_1.{key}"


def test_rows_of_a_topography_lie_at_their_diameters_on_teeth_that_point_inwards(
    tmp_path: Path,
) -> None:
    """Regression: places were looked up along ascending diameters only."""
    scene = fl.read_scene(SCENES / "internal_helical.toml")
    ring = build_bodies(scene).body_2
    ends = 2.0 * np.hypot(*ring.curve.point(ring.mode_range_mm).T)
    rows = np.linspace(ends.min(), ends.max(), 6)
    path = tmp_path / "ring.csv"
    path.write_text("d,0,100\n" + "".join(f"{d!r},{k},{k}\n" for k, d in enumerate(rows.tolist())))
    surface = build_bodies(
        scene.replace({"body_2.topography_file": str(path)})
    ).body_2.axial.surface
    assert surface is not None
    grid = surface.topography
    assert grid is not None
    assert (np.diff(grid.s_mm) > 0).all()
    found = 2.0 * np.hypot(*ring.curve.point(grid.s_mm).T)
    # places are interpolated between samples of the flank
    np.testing.assert_allclose(found, rows[::-1], rtol=0, atol=1e-6)
    np.testing.assert_allclose(1000.0 * grid.removed_mm[:, 0], np.arange(6)[::-1], rtol=ROUND_OFF)


def test_a_hump_in_the_middle_slice_touches_where_one_of_full_width_does(tmp_path: Path) -> None:
    """Flanks of all other slices are equal; without load, the slice that touches first counts."""

    def unloaded(name: str, over: tuple[float, float]) -> Floats:
        columns = [0.0, over[0], over[0] + 0.01, over[1] - 0.01, over[1], 14.0]
        lines = [",".join(["diameter_mm", *(f"{z:g}" for z in columns)])]
        for diameter in np.linspace(67.7, 82.46, 60):
            hump = f"{-150.0 * np.exp(-(((diameter - 69.3) / 0.4) ** 2)):.6f}"
            lines.append(",".join([f"{diameter:.6f}", "0", "0", hump, hump, "0", "0"]))
        (tmp_path / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
        changes = {
            **SMALL,
            "body_1__topography_file": str(tmp_path / name),
            "effects__contact": "lumped",
            "effects__beyond_limits": True,
            "accuracy__slices": 7,
            "positions__count": 40,
        }
        found = fl.solve(fl.Scene.from_dict(tree_of("external_gear", changes)))
        assert found.unloaded_rotation_rad is not None
        return found.unloaded_rotation_rad

    everywhere, middle = unloaded("all.csv", (0.005, 13.995)), unloaded("middle.csv", (5.9, 8.1))
    np.testing.assert_allclose(middle, everywhere, rtol=0, atol=1e-9)
