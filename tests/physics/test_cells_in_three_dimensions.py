"""Cells in slices along the face width: Hertz, finite elements, slices, symmetries, counters."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

import flankload as fl
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.prediction import predicted_work
from flankload.plot import plot_loaded_pair
from flankload.plot.load_maps import contact_pattern
from flankload.scene.discretization import Grid
from tests.support.crowned_cylinders import hertz_ellipse, press
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
from tests.support.tolerances import SOLVER

SPUR = "external_gear"
SLICED: dict[str, Any] = {"accuracy__slices": 28, "positions__count": 2}
SHAFT = {
    "diameters_mm": [30, 40, 30],
    "lengths_mm": [40, 50, 40],
    "gear_position_mm": 50,
    "bearing_positions_mm": [10, 120],
    "radial_stiffness_N_per_um": [250, 250],
    "axial_stiffness_N_per_um": [0, 100],
}


def solve(name: str, *, contact: str = "pairs", **changes: Any) -> fl.Result:
    """The small pair with cells; a scene is solved once."""
    return solved(name, {"effects__contact": contact, **changes})


# --- Hertz ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("crown_radius", [2000.0, 50.0, 16.0])
def test_the_ellipse_of_hertz(crown_radius: float) -> None:
    """Ellipses 31, 3.3 and 1.6 times as long as wide, the last of which is no line contact."""
    force, radius = 3000.0, 8.0
    wanted = hertz_ellipse(force, radius, crown_radius)
    edges = np.linspace(-1.15, 1.15, 32) * wanted.large
    gap = (edges[1:] ** 3 - edges[:-1] ** 3) / np.diff(edges) / (6.0 * crown_radius)
    found = press(force, radius, edges, gap, level="pairs", grid=Grid(6.0, 9.0, 2.0))
    np.testing.assert_allclose(found.slices.peak_MPa.max(), wanted.pressure, rtol=3e-3)
    np.testing.assert_allclose(found.rotation_rad[0] * 1000.0, wanted.approach, rtol=1e-3)
    # levers of cells differ on a circle of 1 m
    np.testing.assert_allclose(found.site_force_N.sum(), force, rtol=1e-6)
    # half-axes by the second moments of the pressure, a²/5 of an ellipse
    _, columns = found.pairs.at(0)
    z = 0.5 * (edges[1:] + edges[:-1])[found.pairs.slices_at(0)]
    part = columns[:, 7] / force
    x = columns[:, 0] - part @ columns[:, 0]
    np.testing.assert_allclose(np.sqrt(5.0 * part @ x**2), wanted.small, rtol=1e-2)
    np.testing.assert_allclose(np.sqrt(5.0 * part @ z**2), wanted.large, rtol=1e-2)


# --- another program ------------------------------------------------------------------------------


@cache
def as_finite_elements() -> fl.Result:
    return solved_like_finite_elements(effects__contact="pairs")


def test_nonlinear_finite_elements() -> None:
    """Rotation 0.1 %, forces 0.1 points, line load and pressure of the middle 0.5 %."""
    found, wanted = as_finite_elements(), FINITE_ELEMENTS
    check_rotation_and_loads(found, rotation=1e-3, load=5e-3)
    s, middle = found.sites.tolist().index, found.slice_z_mm.size // 2
    for (p, site), pressure in wanted["middle_MPa"].items():
        of_middle = found.slice_peak_pressure_MPa[p, s(site), middle]
        assert of_middle == pytest.approx(pressure, rel=5e-3)


def test_end_load_of_nonlinear_finite_elements() -> None:
    """Mean line load of the last 0.5 mm, of which two and a half slices have a part: 3 %."""
    found, wanted = as_finite_elements(), FINITE_ELEMENTS
    slices = found.slices
    assert slices is not None
    ends = np.append(-7.0, slices.z_mm + 0.5 * slices.width_mm)
    carried = np.append(0.0, np.cumsum(slices.force_N[0, found.sites.tolist().index(0)]))
    last = carried[-1] - np.interp(6.5, ends, carried)
    assert last / 0.5 == pytest.approx(wanted["last_half_mm_N_per_mm"], rel=3e-2)
    # slices are narrower there
    assert slices.width_mm[0] == pytest.approx(0.3 * slices.width_mm[14], rel=SOLVER)


# --- slices ---------------------------------------------------------------------------------------

VARIANTS: dict[str, tuple[str, dict[str, Any]]] = {
    "helical": (HELICAL, {}),
    "slope": (HELICAL, {"body_1__helix_slope_um": 20.0}),
    "twist": (HELICAL, {"body_1__profile_twist_um": 10.0}),
    "shafts": (HELICAL, {"body_1__shaft": SHAFT, "body_2__shaft": SHAFT}),
    "roundings": (SPUR, {"effects__dimension": 3, "body_1__tip_radius_mm": 0.3,
                         "body_2__tip_radius_mm": 0.3}),
}  # fmt: skip


@pytest.mark.parametrize("name", VARIANTS)
def test_slices_are_cells_as_a_whole(name: str) -> None:
    """Rotation 0.1 %, shares 0.2 points, largest line load 2.5 %."""
    scene, changes = VARIANTS[name]
    cells = solve(scene, **SLICED, **changes)
    slices = solve(scene, contact="lumped", **SLICED, **changes)
    assert deviation(cells.rotation_rad, slices.rotation_rad) < 1e-3
    np.testing.assert_allclose(cells.load_share, slices.load_share, atol=2e-3)
    largest = cells.slice_line_load_N_per_mm.max() / slices.slice_line_load_N_per_mm.max()
    assert largest == pytest.approx(1.0, abs=2.5e-2)


def test_a_sloped_spur_flank() -> None:
    """20 um, one pair: the rotation of slices; edges carry more than slices show."""
    sloped = {"effects__dimension": 3, "body_1__helix_slope_um": 20.0, "accuracy__slices": 28,
              "positions__count": None, "positions__angles_deg": [0.0]}  # fmt: skip
    cells, slices = (solve(SPUR, contact=contact, **sloped) for contact in ("pairs", "lumped"))
    assert deviation(cells.rotation_rad, slices.rotation_rad) < 5e-4
    assert cells.face_load_factor == pytest.approx(slices.face_load_factor, rel=3e-2)
    # metal is missing at larger z
    load = cells.slice_line_load_N_per_mm[0].sum(axis=0)
    assert load[0] > 1.1 * load[load.size // 2]
    assert load[-1] < 0.9 * load[load.size // 2]


# --- symmetries -----------------------------------------------------------------------------------

ONE_SIDED = {"body_1__helix_slope_um": 12.0, "body_2__axial_offset_mm": 2.0}
OTHER_SIDE = {"body_1__helix_slope_um": -12.0, "body_2__axial_offset_mm": -2.0}


def test_a_mirrored_scene() -> None:
    """z becomes -z and the hands change: mirrored line loads, the same rotation."""
    one = solve(HELICAL, **ONE_SIDED)
    two = solve(HELICAL, **OTHER_SIDE, **OTHER_HANDS)
    assert deviation(two.rotation_rad, one.rotation_rad) < MIRRORED
    loads = two.slice_line_load_N_per_mm[..., ::-1]
    assert deviation(loads, one.slice_line_load_N_per_mm) < 10 * MIRRORED
    pressures = two.slice_peak_pressure_MPa[..., ::-1]
    assert deviation(pressures, one.slice_peak_pressure_MPa) < 10 * MIRRORED


# --- results --------------------------------------------------------------------------------------


def test_cells_of_a_position() -> None:
    """Forces of cells add up to those of slices; pressures are over areas of the contact line."""
    found = solve(HELICAL, **SLICED)
    assert found.slices is not None
    for p in range(found.position_rad.size):
        table = found.pairs(p)
        assert table.z_mm is not None
        assert table.half_width_mm is None
        s = np.searchsorted(found.sites, table.site)
        j = np.searchsorted(found.slice_z_mm, table.z_mm)
        force = np.zeros_like(found.slices.force_N[p])
        np.add.at(force, (s, j), table.force_N)
        np.testing.assert_allclose(force, found.slices.force_N[p], rtol=SOLVER, atol=1e-9)
        peak = np.zeros_like(force)
        np.maximum.at(peak, (s, j), table.pressure_MPa)
        np.testing.assert_allclose(peak, found.slice_peak_pressure_MPa[p], rtol=1e-4, atol=1e-6)
        # several cells across each loaded slice, and their gaps close
        assert np.bincount(s * j.size + j, weights=table.force_N > 0).max() > 8
        assert np.abs(table.gap_um[table.force_N > 0]).max() < 1e-6
        assert (table.gap_um >= -1e-6).all()


def test_half_widths_are_those_of_slices() -> None:
    """The widest slice of each flank, as a Hertz contact and by its cells; not their sum."""
    cells, slices = (solve(HELICAL, contact=each, **SLICED) for each in ("pairs", "lumped"))
    wide = slices.site_force_N > 500.0
    for found in (cells, slices):
        assert found.contact_half_width_mm[wide].max() < 0.25
    np.testing.assert_allclose(
        cells.contact_half_width_mm[wide], slices.contact_half_width_mm[wide], rtol=3e-2
    )


def test_a_contact_pattern_of_cells() -> None:
    """The pressures of the cells of all positions, and between these."""
    keys = {**SLICED, "positions__count": 16}
    cells, slices = (solve(HELICAL, contact=each, **keys) for each in ("pairs", "lumped"))
    (diameter, pressure), (_, wanted) = (contact_pattern(each, 1) for each in (cells, slices))
    assert 73.9 < diameter[0] < diameter[-1] < 84.8
    assert pressure.shape == (240, 28)
    assert pressure.max() == pytest.approx(cells.peak_pressure_MPa.max(), rel=1e-2)
    assert (pressure > 0).mean() == pytest.approx((wanted > 0).mean(), abs=2e-2)


def test_the_loaded_pair_shows_line_loads() -> None:
    """The cells of a slice are one band, with the line load of the slice."""
    cells = solve(HELICAL, **SLICED)
    drawn = plot_loaded_pair(cells, 0).findobj(PolyCollection)
    bands = next(each for each in drawn if each.get_array() is not None)
    loads = np.asarray(bands.get_array())
    wanted = cells.slice_line_load_N_per_mm[0]
    assert loads.size == (wanted > 0).sum()
    assert loads.max() == pytest.approx(wanted.max(), rel=SOLVER)


def test_a_list_of_torques() -> None:
    tree = tree_of(HELICAL, {**SMALL, "effects__contact": "pairs", "load__torque_Nm": [50.0, 250]})
    _, high = solve_scene(fl.Scene.from_dict(tree))
    alone = solve(HELICAL)
    np.testing.assert_allclose(high.rotation_rad, alone.rotation_rad, rtol=SOLVER)
    np.testing.assert_allclose(
        high.slice_line_load_N_per_mm, alone.slice_line_load_N_per_mm, rtol=SOLVER, atol=1e-6
    )


def test_tangents_and_estimate() -> None:
    """Tangent stiffness as of slices to 0.5 %; the sources of errors of cells and of slices."""
    keys = {**SLICED, "accuracy__tangents": True, "accuracy__estimate": True}
    cells, slices = (solve(HELICAL, contact=contact, **keys) for contact in ("pairs", "lumped"))
    np.testing.assert_allclose(
        cells.stiffness_tangent_Nm_per_rad, slices.stiffness_tangent_Nm_per_rad, rtol=5e-3
    )
    assert cells.estimate is not None
    assert {"strips", "modes", "axial", "slices"} <= set(cells.estimate["by_source"])
    assert cells.estimate["by_source"]["strips"]["transmission_error"] < 1e-3


def test_counted_work() -> None:
    """An influence column for each cell, one pass at each position; states are predicted."""
    found = solve(HELICAL, **SLICED)
    work = found.cost["of_this_torque"]
    assert work["contact_passes"] == 2
    assert work["influence_columns"] == sum(len(found.pairs(p)) for p in range(2))
    assert work["lumped_solutions"] > 0
    scene = fl.Scene.from_dict(tree_of(HELICAL, {**SMALL, "effects__contact": "pairs", **SLICED}))
    predicted = predicted_work(scene, build_bodies(scene))["sweep"]
    assert predicted["states"] == 2
    assert predicted["slices"] == 56
    assert "influence_columns" not in predicted


def test_keys_of_cells() -> None:
    """More cells by the keys of the plane; without contact = "pairs" these stay refused."""
    scene = tree_of(HELICAL, {**SMALL, "accuracy__strips_per_half_width": 8.0})
    with pytest.raises(fl.SceneError, match="strips_per_half_width"):
        fl.Scene.from_dict(scene)
    fine = solve(HELICAL, accuracy__strips_per_half_width=12.0)
    assert len(fine.pairs(0)) > 1.8 * len(solve(HELICAL).pairs(0))
    assert deviation(fine.rotation_rad, solve(HELICAL).rotation_rad) < 3e-4


def test_cells_of_splines_are_refused() -> None:
    """Their slices have no place of least gap."""
    keys = {"effects__dimension": 3, "effects__contact": "pairs"}
    with pytest.raises(fl.SceneError) as raised:
        fl.Scene.from_dict(tree_of("spline", keys))
    assert str(raised.value) == (
        "effects.contact: expected nothing, since effects.dimension = 3 requires three dimensions: "
        "slices of splines have one unknown each, found 'pairs'"
    )
