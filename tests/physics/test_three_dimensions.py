"""Three-dimensional pairs as scenes: finite elements, plane limits, symmetries, statics."""

from __future__ import annotations

import copy
import csv
import io
import json
import pickle
from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from tests.support.finite_elements_3d import (
    FINITE_ELEMENTS,
    check_rotation_and_loads,
    solved_like_finite_elements,
)
from tests.support.solving import solve as solve_scene
from tests.support.three_dimensional import (
    HELICAL,
    MIRRORED,
    OTHER_HANDS,
    SMALL,
    deviation,
    solved,
    tree_of,
)
from tests.support.tolerances import ROUND_OFF, SOLVER

SPUR = "external_gear"


def solve(name: str, **changes: Any) -> fl.Result:
    """The small pair; a scene is solved once."""
    return solved(name, changes)


def spur(**changes: Any) -> fl.Result:
    """The spur pair in three dimensions."""
    return solve(SPUR, effects__dimension=3, **changes)


# --- another program ------------------------------------------------------------------------------


@cache
def as_finite_elements() -> fl.Result:
    return solved_like_finite_elements(accuracy__slices=56)


def test_nonlinear_finite_elements() -> None:
    """Rotation 0.3 %, load shares 0.3 points, line load of the middle 2 %."""
    check_rotation_and_loads(as_finite_elements(), rotation=3e-3, load=2e-2)


def test_pressure_and_end_load_of_nonlinear_finite_elements() -> None:
    """Mean line load of the last 0.5 mm: 5 %; pressure of the middle: 1 %."""
    found, wanted = as_finite_elements(), FINITE_ELEMENTS
    s = found.sites.tolist().index
    last = np.abs(found.slice_z_mm) > 6.5
    assert last.sum() == 4
    ends = found.slice_line_load_N_per_mm[0, s(0), last].mean()
    assert ends == pytest.approx(wanted["last_half_mm_N_per_mm"], rel=5e-2)
    middle = found.slice_z_mm.size // 2
    for (p, site), pressure in wanted["middle_MPa"].items():
        found_pressure = found.slice_peak_pressure_MPa[p, s(site), middle]
        assert found_pressure == pytest.approx(pressure, rel=1e-2)


# --- plane limits ---------------------------------------------------------------------------------


def test_a_wide_spur_pair_is_in_plane_strain() -> None:
    """Ends and rims are more compliant: the plane pair is stiffer, by less in wide pairs."""
    plane = solve(SPUR, accuracy__axial_degree=None, accuracy__load_degree_z=None,
                  accuracy__slices=None, effects__contact="lumped")  # fmt: skip
    ratios = []
    for times, degree in ((1.0, 6), (3.0, 8), (9.0, 12)):
        wide = spur(
            pair__face_width_mm=14.0 * times,
            load__torque_Nm=302.0 * times,
            accuracy__axial_degree=degree,
            accuracy__load_degree_z=2,
            accuracy__slices=14,
        )
        ratios.append(float(plane.rotation_rad[0] / wide.rotation_rad[0]))
    assert ratios[0] == pytest.approx(0.96, abs=0.01)
    assert ratios[0] < ratios[1] < ratios[2] < 1.0


def test_a_helix_begins_at_zero() -> None:
    """A helix angle of 1e-4 degrees is a spur pair."""
    helix = {"body_1__helix_angle_deg": 1e-4, "body_2__helix_angle_deg": 1e-4}
    found = solve(SPUR, body_1__hand="right", body_2__hand="left", **helix)
    none = spur()
    assert deviation(found.rotation_rad, none.rotation_rad) < 1e-6
    assert deviation(found.slice_line_load_N_per_mm, none.slice_line_load_N_per_mm) < 1e-3


# --- symmetries -----------------------------------------------------------------------------------

ONE_SIDED = {
    "body_1__helix_slope_um": 12.0,
    "body_2__end_relief_um": [0.0, 15.0],
    "body_2__end_relief_length_mm": [4.0, 6.0],
    "body_2__axial_offset_mm": 2.0,
    "body_1__face_width_mm": 27.0,
    "pair__inclination_um_per_mm": 0.2,
}
ONE_SIDED_MIRRORED = {
    **ONE_SIDED,
    "body_1__helix_slope_um": -12.0,
    "body_2__end_relief_um": [15.0, 0.0],
    "body_2__end_relief_length_mm": [6.0, 4.0],
    "body_2__axial_offset_mm": -2.0,
    "pair__inclination_um_per_mm": -0.2,
}


@pytest.mark.parametrize(
    ("changes", "mirrored"), [({}, {}), (ONE_SIDED, ONE_SIDED_MIRRORED)], ids=["even", "one-sided"]
)
def test_a_mirrored_scene(changes: dict[str, Any], mirrored: dict[str, Any]) -> None:
    """z becomes -z and the hands change: mirrored line loads, the same rotation."""
    one = solve(HELICAL, **changes)
    two = solve(HELICAL, **mirrored, **OTHER_HANDS)
    assert deviation(two.rotation_rad, one.rotation_rad) < MIRRORED
    loads = two.slice_line_load_N_per_mm[..., ::-1]
    assert deviation(loads, one.slice_line_load_N_per_mm) < 10 * MIRRORED
    assert one.slices is not None
    assert two.slices is not None
    assert deviation(-two.slices.axial_force_N, one.slices.axial_force_N) < MIRRORED
    np.testing.assert_allclose(
        -two.slices.tilting_moment_Nm, one.slices.tilting_moment_Nm, rtol=0.0, atol=1e-8
    )


def test_a_helix_slope_of_either_body_is_the_same_gap() -> None:
    """Metal is removed at the end of larger z from one or the other flank."""
    one, two = (solve(HELICAL, **{f"body_{z}__helix_slope_um": 15.0}) for z in (1, 2))
    assert deviation(one.rotation_rad, two.rotation_rad) < SOLVER
    assert deviation(one.slice_line_load_N_per_mm, two.slice_line_load_N_per_mm) < SOLVER
    assert one.slices is not None
    even = solve(HELICAL).slices
    assert even is not None
    # less metal at larger z: the load moves to smaller z
    assert (one.slices.tilting_moment_Nm < even.tilting_moment_Nm).all()


@pytest.mark.parametrize("key", ["inclination", "deviation"])
def test_a_misalignment_is_a_helix_slope(key: str) -> None:
    """The same gap of bodies that begin at z = 0, where a misalignment has none."""
    centered = {"body_1__axial_offset_mm": 12.5, "body_2__axial_offset_mm": 12.5}
    # ISO 6336-1: base tangent components, by the working pressure angle
    transverse = np.arctan(np.tan(np.radians(20.0)) / np.cos(np.radians(15.0)))
    sum_of_base_radii = 3.0 * (25 + 60) / 2 / np.cos(np.radians(15.0)) * np.cos(transverse)
    working = np.arccos(sum_of_base_radii / 132.0)
    factor = np.sin(working) if key == "inclination" else np.cos(working)
    one = solve(HELICAL, **centered, **{f"pair__{key}_um_per_mm": 0.5})
    two = solve(HELICAL, **centered, body_2__helix_slope_um=float(0.5 * 25.0 * factor))
    assert deviation(one.rotation_rad, two.rotation_rad) < SOLVER
    assert deviation(one.slice_line_load_N_per_mm, two.slice_line_load_N_per_mm) < SOLVER
    even = solve(HELICAL, **centered)
    assert deviation(one.slice_line_load_N_per_mm, even.slice_line_load_N_per_mm) > 0.02


# --- statics --------------------------------------------------------------------------------------


#: Positions of a pitch, for means over it.
OVER_A_PITCH = {"accuracy__slices": 16, "positions__count": 16}


@cache
def forces_on_both() -> dict[str, np.ndarray]:
    """Force, levers and axial forces of all pairs at all positions by the normal of each body."""
    found = solve(HELICAL, **OVER_A_PITCH)
    slope = np.tan(np.radians(15.0))
    radii = [3.0 * z / 2.0 / np.cos(np.radians(15.0)) for z in (25, 60)]
    rows: dict[str, list[np.ndarray]] = {}
    for p in range(found.position_rad.size):
        table = found.pairs(p)
        levers = [
            x_mm * table.normal_y - table.y_mm * table.normal_x
            for x_mm in (table.x_mm, table.x_mm - 132.0)
        ]
        in_section = table.force_N / np.hypot(1.0, slope / radii[0] * levers[0])
        # the normal of a twisted body is perpendicular to its helices
        axial = [
            in_section * sign * slope / radius * lever
            for sign, radius, lever in zip((1, -1), radii, levers, strict=True)
        ]
        for key, values in {
            "position": np.full(len(table), p),
            "lever_1": levers[0],
            "lever_2": levers[1],
            "torque_1": in_section * levers[0],
            "torque_2": -in_section * levers[1],
            "axial_1": axial[0],
            "axial_2": axial[1],
        }.items():
            rows.setdefault(key, []).append(values)
    return {key: np.concatenate(parts) for key, parts in rows.items()}


def at_positions(values: np.ndarray) -> np.ndarray:
    """Sums over the pairs of each position."""
    return np.bincount(forces_on_both()["position"].astype(int), weights=values)


def test_forces_times_levers_hold_the_torque() -> None:
    both = forces_on_both()
    np.testing.assert_allclose(np.abs(at_positions(both["torque_1"])), 250e3, rtol=1e-4)


def test_torques_of_both_bodies() -> None:
    """Means over a pitch are in the ratio of the teeth, since no work is lost."""
    both = forces_on_both()
    ratio = at_positions(both["torque_2"]) / at_positions(both["torque_1"])
    np.testing.assert_allclose(ratio, 60 / 25, rtol=2e-3)
    assert ratio.mean() == pytest.approx(60 / 25, rel=1e-4)


def test_axial_forces_of_both_bodies() -> None:
    """Action and reaction by the normals of both bodies; the axial force of the result."""
    both, found = forces_on_both(), solve(HELICAL, **OVER_A_PITCH)
    base_mm = found.reference_radius_mm * np.array([1.0, -60 / 25])
    on_involutes = np.logical_and(
        *(np.abs(both[f"lever_{z + 1}"] / base_mm[z] - 1.0) < 1e-4 for z in (0, 1))
    )
    assert on_involutes.mean() > 0.5
    np.testing.assert_allclose(
        both["axial_1"][on_involutes], both["axial_2"][on_involutes], rtol=1e-4
    )
    assert found.slices is not None
    one, two = (at_positions(both[f"axial_{z}"]) for z in (1, 2))
    np.testing.assert_allclose(one, two, rtol=2e-3)
    # a right-hand pinion that turns counter-clockwise is pushed along z
    np.testing.assert_allclose(found.slices.axial_force_N, np.abs(one), rtol=2e-3)
    assert (found.slices.axial_force_N > 0).all()


def test_forces_of_slices_are_those_of_flanks() -> None:
    found = solve(HELICAL, accuracy__slices=16)
    assert found.slices is not None
    np.testing.assert_allclose(found.slices.force_N.sum(axis=2), found.site_force_N, rtol=SOLVER)


def test_pressures_of_single_pairs_are_those_of_slices() -> None:
    """A force over the length of its contact line, which is longer than the slice is wide."""
    found = solve(HELICAL, **OVER_A_PITCH)
    for p in range(found.position_rad.size):
        table = found.pairs(p)
        assert table.z_mm is not None
        s = np.searchsorted(found.sites, table.site)
        j = np.searchsorted(found.slice_z_mm, table.z_mm)
        np.testing.assert_allclose(
            table.pressure_MPa, found.slice_peak_pressure_MPa[p, s, j], rtol=1e-4
        )


# --- widths ---------------------------------------------------------------------------------------


def test_a_wider_pinion_supports_the_ends() -> None:
    """Its rotation falls by some percent; the ends of the contact carry more than without."""
    fine = {"accuracy__slices": 28, "accuracy__axial_degree": 8, "accuracy__load_degree_z": 4}
    same, wide = spur(**fine), spur(**fine, body_1__face_width_mm=18.0)
    ratio = wide.rotation_rad / same.rotation_rad
    assert (ratio < 0.99).all()
    assert (ratio > 0.90).all()
    assert wide.slice_z_mm.size == same.slice_z_mm.size == 28
    ends = [found.slice_line_load_N_per_mm[0].sum(axis=0)[0] for found in (wide, same)]
    assert ends[0] > 1.02 * ends[1]


def test_an_offset_leaves_the_common_width() -> None:
    """Bodies of 14 mm, 3 mm apart: 11 mm carry, more where the pinion overhangs."""
    found = spur(body_2__axial_offset_mm=3.0)
    half = 0.5 * 11.0 / 8
    np.testing.assert_allclose(found.slice_z_mm[[0, -1]], [-4.0 + half, 7.0 - half], rtol=SOLVER)
    np.testing.assert_allclose(
        found.site_force_N.sum(axis=1), spur().site_force_N.sum(axis=1), rtol=1e-3
    )  # tip corners have other levers
    assert (found.rotation_rad > 1.05 * spur().rotation_rad).all()
    mirrored = spur(body_2__axial_offset_mm=-3.0)
    loads = mirrored.slice_line_load_N_per_mm[..., ::-1]
    assert deviation(loads, found.slice_line_load_N_per_mm) < 10 * MIRRORED


# --- discretization along the axis ----------------------------------------------------------------

DEFAULT = {
    "accuracy__axial_degree": None,
    "accuracy__load_degree_z": None,
    "accuracy__slices": None,
}


@pytest.mark.parametrize("name", [SPUR, HELICAL])
@pytest.mark.parametrize(
    ("finer", "limit"),
    [({"accuracy__axial_degree": 10, "accuracy__load_degree_z": 4}, 2e-4),
     ({"accuracy__slices": 56}, 5e-4)],
    ids=["axial_degree", "slices"],
)  # fmt: skip
def test_the_defaults_along_the_axis_suffice(
    name: str, finer: dict[str, Any], limit: float
) -> None:
    spatial = {"effects__dimension": 3}
    one = solve(name, **spatial, **DEFAULT)
    two = solve(name, **spatial, **{**DEFAULT, **finer})
    assert deviation(two.rotation_rad, one.rotation_rad) < limit


# --- every kind of sweep --------------------------------------------------------------------------


def test_a_list_of_torques() -> None:
    tree = tree_of(HELICAL, {**SMALL, "load__torque_Nm": [50.0, 250.0]})
    low, high = solve_scene(fl.Scene.from_dict(tree))
    np.testing.assert_allclose(high.rotation_rad, solve(HELICAL).rotation_rad, rtol=SOLVER)
    np.testing.assert_allclose(
        high.slice_line_load_N_per_mm,
        solve(HELICAL).slice_line_load_N_per_mm,
        rtol=SOLVER,
        atol=1e-6,
    )
    assert low.slices is not None
    alone = solve(HELICAL, load__torque_Nm=50.0)
    np.testing.assert_allclose(low.rotation_rad, alone.rotation_rad, rtol=SOLVER)
    assert low.slices.force_N.shape[-1] == 8


def test_adaptive_positions() -> None:
    found = solve(
        HELICAL,
        positions__count=8,
        positions__adaptive=True,
        positions__tolerance=0.02,
    )
    assert found.position_rad.size > 8
    even = solve(HELICAL, positions__count=32)
    assert np.ptp(found.transmission_error_um) == pytest.approx(
        np.ptp(even.transmission_error_um), rel=0.03
    )
    assert found.slice_line_load_N_per_mm.shape[0] == found.position_rad.size


def test_pitch_errors_over_the_whole_period() -> None:
    """A tooth that lags by 20 um carries less, over its whole width."""
    errors = [0.0] * 25
    errors[3] = -20.0
    found = solve(
        HELICAL,
        body_1__pitch_errors_um=errors,
        positions__pitches="hunting",
        positions__count=2,
    )
    assert found.position_rad.size == 50
    assert found.slices is not None
    plain = solve(HELICAL, positions__count=2)
    np.testing.assert_allclose(
        found.slices.force_N.sum(axis=(1, 2)).mean(),
        plain.site_force_N.sum(axis=1).mean(),
        rtol=1e-3,
    )
    assert np.ptp(found.rotation_rad) > 1.5 * np.ptp(plain.rotation_rad)
    apart = np.abs(found.rotation_rad.reshape(-1, 2) - plain.rotation_rad).max(axis=1)
    assert (apart < 1e-3 * plain.rotation_rad.max()).sum() >= 20  # elsewhere nothing is new


def test_without_torque_nothing_carries() -> None:
    """Conjugate helical flanks touch without error, crowned ones in the middle."""
    found = solve(HELICAL, load__torque_Nm=0.0, body_1__lead_crowning_um=None)
    assert found.slice_line_load_N_per_mm.shape[2] == 8
    assert not found.slice_line_load_N_per_mm.any()
    np.testing.assert_allclose(found.transmission_error_um, 0.0, rtol=0.0, atol=1e-3)
    sloped = solve(HELICAL, load__torque_Nm=0.0, body_1__helix_slope_um=16.0)
    assert (sloped.transmission_error_um > 0.5).all()
    assert sloped.face_load_factor == 1.0


@pytest.mark.parametrize("rigid", [1, 2])
def test_a_rigid_body(rigid: int) -> None:
    """Stiffer than two elastic bodies, with all of the load; also in the error estimate."""
    keys = {f"body_{rigid}__rigid": True, "accuracy__estimate": True}
    found, elastic = solve(HELICAL, **keys), solve(HELICAL)
    assert found.estimate is not None
    assert found.estimate["transmission_error"] < 0.2
    turned = found.rotation_rad / elastic.rotation_rad
    assert (turned > 0.2).all()
    assert (turned < 0.9).all()
    np.testing.assert_allclose(
        found.site_force_N.sum(axis=1), elastic.site_force_N.sum(axis=1), rtol=2e-3
    )


# --- results --------------------------------------------------------------------------------------


def test_a_plane_result_has_one_slice() -> None:
    pytest.importorskip("xarray")
    plane = solve(SPUR, **DEFAULT, effects__contact="lumped").to_xarray()
    spatial = solve(HELICAL).to_xarray()
    assert plane.sizes["slice"] == 1
    assert spatial.sizes["slice"] == 8
    for name in ("slice_line_load_N_per_mm", "slice_peak_pressure_MPa"):
        assert plane[name].dims == spatial[name].dims == ("position", "site", "slice")
        assert plane[name].attrs == spatial[name].attrs
    assert set(plane.data_vars) == set(spatial.data_vars)
    np.testing.assert_array_equal(plane["slice"], [0.0])
    assert plane["line_load_N_per_mm"].dims == ("position", "site")
    assert spatial["line_load_N_per_mm"].dims == ("position", "site", "slice")


def test_loads_along_the_axis_of_a_plane_result() -> None:
    plane = solve(SPUR, **DEFAULT, effects__contact="lumped")
    assert not plane.axial_force_N.any()
    assert not plane.tilting_moment_Nm.any()
    assert plane.face_load_factor == 1.0
    assert (plane.flank_face_load_factor == 1.0).all()
    np.testing.assert_array_equal(plane.slice_line_load_N_per_mm[..., 0], plane.line_load_N_per_mm)


def test_files_of_a_three_dimensional_result(tmp_path: Any) -> None:
    found = solve(HELICAL)
    assert found.slices is not None
    found.to_json(tmp_path / "a.json")
    tree = json.loads((tmp_path / "a.json").read_text())
    for name in ("slice_z_mm", "slice_line_load_N_per_mm", "slice_peak_pressure_MPa"):
        np.testing.assert_array_equal(tree[name], getattr(found, name))
    np.testing.assert_array_equal(tree["axial_force_N"], found.slices.axial_force_N)
    assert tree["summary"]["face_load_factor"] == found.face_load_factor
    rows = list(csv.DictReader(io.StringIO(found.to_csv())))
    assert len(rows) == found.position_rad.size
    site = int(found.sites[0])
    np.testing.assert_array_equal(
        [float(row[f"site_force_N_pair_{site}"]) for row in rows], found.site_force_N[:, 0]
    )
    np.testing.assert_allclose(
        [float(row[f"line_load_N_per_mm_pair_{site}"]) for row in rows],
        found.line_load_N_per_mm[:, 0].mean(axis=1),
        rtol=ROUND_OFF,
    )


def test_copies_of_a_three_dimensional_result() -> None:
    found = solve(HELICAL)
    for twin in (pickle.loads(pickle.dumps(found)), copy.copy(found), copy.deepcopy(found)):
        np.testing.assert_array_equal(twin.slice_z_mm, found.slice_z_mm)
        np.testing.assert_array_equal(twin.slice_line_load_N_per_mm, found.slice_line_load_N_per_mm)
        assert twin.face_load_factor == found.face_load_factor
    with pytest.raises(ValueError, match="read-only"):
        found.slice_line_load_N_per_mm[0] = 0.0


# --- error estimate -------------------------------------------------------------------------------


@pytest.mark.parametrize("tips", ["relieved", "sharp"])
def test_lumped_error_is_that_beside_cells(tips: str) -> None:
    """Regression: fixed estimates were 0.25 % and more, and too small at some sharp corners."""
    keys = ("tip_relief_um", "tip_relief_start_diameter_mm", "tip_relief_shape")
    bare = {f"body_{z}__{key}": None for z in (1, 2) for key in keys if tips == "sharp"}
    scene = {"accuracy__slices": 28, "positions__count": 16, **bare}
    found = solve(HELICAL, accuracy__estimate=True, **scene)
    cells = solve(HELICAL, effects__contact="pairs", **scene)
    assert found.estimate is not None
    error = found.estimate["by_source"]["lumped"]
    beside = deviation(found.rotation_rad, cells.rotation_rad)
    # graded slices of the cells have an error of their own
    assert 0.5 * beside < error["transmission_error"] < 3.0 * beside
    shares = np.abs(found.load_share - cells.load_share).max()
    assert 0.5 * shares < error["load_share"] < 3.2 * shares


def test_sampling_error_is_that_beside_four_times_as_many_positions() -> None:
    """Regression: peaks of line loads between positions were missed. The change is in doubt."""
    found, many = (
        solve(HELICAL, accuracy__slices=28, positions__count=count, accuracy__estimate=count == 4)
        for count in (4, 16)
    )
    assert found.estimate is not None
    errors = found.estimate["by_source"]["positions"]
    for name in ("face_load_factor", "line_load_factor"):
        change = abs(getattr(many, name) / getattr(found, name) - 1.0)
        assert change > 0
        assert errors[name] == pytest.approx(2.0 * change, rel=SOLVER), name
    mean = abs(many.rotation_rad.mean() / found.rotation_rad.mean() - 1.0)
    assert errors["transmission_error_mean"] >= mean


def test_no_warning_names_a_contact_model_that_slices_lack() -> None:
    """Contacts of the example reach the ends of its flanks; there are no cells for them."""
    found = solve(HELICAL, **OVER_A_PITCH)
    beside = [text for text in found.warnings if "pressures there are Hertz values" in text]
    assert len(beside) == 1
    assert "pairs" not in beside[0]


def test_root_relief_acts_as_in_the_plane() -> None:
    relief = {"body_1__root_relief_um": 20.0, "body_1__root_relief_start_diameter_mm": 71.0}
    flat: dict[str, Any] = {"accuracy__slices": None, "accuracy__axial_degree": None}
    flat |= {"accuracy__load_degree_z": None, "effects__contact": "lumped"}
    plane, solid = (
        np.array(solve(SPUR, **keys, **relief).transmission_error_um)
        - np.array(solve(SPUR, **keys).transmission_error_um)
        for keys in (flat, {"effects__dimension": 3})
    )
    assert plane.max() > 3.0
    # plane strain is 2 % stiffer than teeth with free ends
    np.testing.assert_allclose(solid, plane, rtol=0.03, atol=0.01)
