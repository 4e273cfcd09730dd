"""Thin rims whose bore is free but for its torque: another program, gears, rings, roots."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import skfem
from scipy.sparse import block_array
from scipy.sparse.linalg import splu
from skfem.models.elasticity import lame_parameters, linear_elasticity

import flankload as fl
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.mean_motion import bore_reactions
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.sector_closure import close_ring
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.description import describe
from flankload.mechanisms.flank_pair.rims import held_rim, rim_notes
from flankload.studies.verification.triangles import quadratic, refined, whole_body
from tests.support.condensed import condense
from tests.support.pair_scenes import RING_PAIR
from tests.support.paths import SCENES
from tests.support.plane_sectors import STEEL
from tests.support.ring_bodies import gear_body
from tests.support.solving import solve
from tests.support.tolerances import SOLVER

#: Elements of 2 mm, and triangles of 3 mm, beside each other; 0.1 % with 1.5 mm.
DISCRETIZATION = 0.006
COARSE = {"flank_element_mm": 3.0, "modes": 4, "estimate": False, "tangents": False}


def test_the_rim_bends_as_that_of_another_program() -> None:
    """Triangles of scikit-fem on the whole gear, its mean motion held by its own integrals."""
    teeth, body = 12, gear_body(12, 2.0, bore_diameter_mm=40.0, bore="torque")
    mesh, (low, high) = body.mesh, body.mode_range_mm
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    pressure = mode_loads(mesh, (low, high), 1)
    reactions = bore_reactions(mesh, matrix, STEEL.young_modulus_MPa)
    sector, _ = condense(matrix, pressure, mesh, reactions=reactions)
    found = close_ring(sector, teeth)[:, 0, 0]

    flanks = tuple((tooth, 2.0 * np.pi * tooth / teeth) for tooth in range(teeth))
    triangles = refined(whole_body(body, flanks), lambda places: np.full(len(places), 3.0))
    nodes, cells, _ = quadratic(triangles)
    other, border = skfem.MeshTri2(nodes.T, cells.T), triangles.border
    element = skfem.ElementVector(skfem.ElementTriP2())
    numbers = {tuple(ends): k for k, ends in enumerate(np.sort(other.facets.T).tolist())}

    def basis_of(rows: np.ndarray) -> skfem.FacetBasis:
        facets = [numbers[tuple(sorted(ends))] for ends in border.ends[rows].tolist()]
        return skfem.FacetBasis(other, element, facets=np.array(facets), intorder=6)

    loads = []
    for tooth in range(teeth):
        s = np.where(border.flank[:, None] == tooth, border.s, -1.0)
        own = basis_of((s.min(axis=1) > low - 1e-6) & (s.max(axis=1) < high + 1e-6))
        form = skfem.LinearForm(lambda v, w: w.n[0] * v[0] + w.n[1] * v[1])
        loads.append(form.assemble(own))
    motions = (
        lambda v, _: v[0],
        lambda v, _: v[1],
        lambda v, w: w.x[0] * v[1] - w.x[1] * v[0],
    )
    bore = basis_of(border.held)
    means = np.stack([skfem.LinearForm(form).assemble(bore) for form in motions], axis=1)
    moduli = lame_parameters(STEEL.young_modulus_MPa, STEEL.poisson_ratio)
    whole = linear_elasticity(*moduli).assemble(skfem.Basis(other, element, intorder=4))
    system = splu(block_array([[whole, means], [means.T, None]]).tocsc())
    moved = system.solve(np.append(loads[0], np.zeros(3)))[:-3]
    wanted = np.array([load @ moved for load in loads])
    # the far side gives way by a third of the loaded tooth, in opposite directions
    assert wanted[2] < -0.25 * wanted[0]
    np.testing.assert_allclose(found, wanted, rtol=0, atol=DISCRETIZATION * wanted[0])


def scene(bore_mm: float, support: str, **more: Any) -> fl.Scene:
    """A pinion of 20 teeth of 4 mm: its root circle is 70 mm, its teeth are 9 mm high."""
    gear = {"kind": "gear", "module_mm": 4.0, "tip_radius_mm": 0.3}
    pinion = {"teeth": 20, "tip_diameter_mm": 88.0, "bore_diameter_mm": bore_mm, "bore": support}
    return fl.Scene.from_dict(
        {
            "body_1": {**gear, **pinion, **more.pop("pinion", {})},
            "body_2": {**gear, "teeth": 40, "tip_diameter_mm": 168.0, "bore_diameter_mm": 40.0},
            "pair": {"center_distance_mm": 120.0, "face_width_mm": 40.0},
            "load": {"torque_Nm": 100},
            "positions": {"count": 4},
            "accuracy": {**COARSE, **more.pop("accuracy", {})},
            "effects": {"contact": "lumped", **more},
        }
    )


@cache
def solved(bore_mm: float, support: str, **more: Any) -> fl.Result:
    found = solve(scene(bore_mm, support, **more))
    assert isinstance(found, fl.Result)
    return found


def test_a_thinner_rim_gives_way_only_where_the_bore_is_free() -> None:
    """Regression: a rim got stiffer as it got thinner, without a word."""
    held, free = (
        [solved(bore, support).transmission_error_um for bore in (30.0, 45.0, 55.0, 60.0)]
        for support in ("held", "torque")
    )
    held_mean, mean = np.mean(held, axis=1), np.mean(free, axis=1)
    assert (np.diff(held_mean) < 0.0).all()
    assert (np.diff(np.ptp(free, axis=1)) > 0.0).all()
    # the twist inside of the bore does not count: 1/30^2 - 1/45^2
    assert mean[1] == pytest.approx(mean[0], rel=0.03)
    assert (np.diff(mean[1:]) > 0.0).all()
    assert mean[0] == pytest.approx(held_mean[0], rel=0.03)
    assert mean[3] > 1.8 * held_mean[3]
    note = (
        "body_1: the rim of 7.5 mm is 0.83 tooth heights, below 1.2: held, it cannot bend "
        '(body_1.bore = "torque" holds only its mean motion)'
    )
    assert note in solved(55.0, "held").warnings
    for quiet in (solved(40.0, "held"), solved(55.0, "torque")):
        assert not any("rim of" in line for line in quiet.warnings)


def test_check_names_the_support_of_the_bore() -> None:
    """Regression: a bore held in the mean had "0 nodes" held."""
    rows = [dict(describe(scene(55.0, bore)).rows["body_1: gear"]) for bore in ("held", "torque")]
    assert rows[1]["held in the mean"] == rows[0]["held"]
    assert not rows[0]["held"].startswith("0 nodes")


def test_the_rotation_is_that_of_the_mean_of_the_bore() -> None:
    """Twist between both circles in closed form, for a rim as stiff as a disc."""
    small, large = (solved(bore, "torque").rotation_rad for bore in (12.0, 24.0))
    shear = 206000.0 / 2.6
    twist = 100e3 / 40.0 / (4.0 * np.pi * shear) * (1.0 / 6.0**2 - 1.0 / 12.0**2)
    np.testing.assert_allclose(small - large, twist, rtol=0.05)


def test_a_free_bore_expands_with_any_support() -> None:
    """A warm rim is free to grow, as on a support that grows with it."""
    warm = {"temperature_rise_K": 2.0, "thermal_expansion_per_K": 11.5e-6, "beyond_limits": True}
    free, on_cold, held = (
        solve(scene(60.0, support, **warm, support_expansion_per_K=[of_bore, 11.5e-6])).rotation_rad
        for support, of_bore in (("torque", 11.5e-6), ("torque", 0.0), ("held", 0.0))
    )
    cold = solved(60.0, "torque").rotation_rad
    assert np.abs(free - cold).min() > 0.001 * np.abs(cold).max()
    np.testing.assert_allclose(on_cold, free, rtol=SOLVER)
    assert np.abs(held - free).min() > 1e-6


def test_solid_bodies_bend_as_plane_ones() -> None:
    solid = {"dimension": 3, "accuracy": {"axial_degree": 5, "load_degree_z": 0, "slices": 4}}
    ratios = [
        solve(scene(60.0, support, **solid)).transmission_error_um.mean()
        / solved(60.0, support).transmission_error_um.mean()
        for support in ("held", "torque")
    ]
    assert ratios == pytest.approx([1.02, 1.02], abs=0.015)


def test_roots_of_a_thin_rim_are_pressed_more() -> None:
    """The rim bends towards its axis under a loaded tooth, which relieves the side in tension."""
    held, free = (
        solved(60.0, support, root_stress=True).root_stress[0] for support in ("held", "torque")
    )
    assert free.compression.stress_MPa.min() < 2.0 * held.compression.stress_MPa.min()
    assert free.tension.stress_MPa.max() < 0.8 * held.tension.stress_MPa.max()


def test_a_ring_that_is_free_but_for_its_torque() -> None:
    def run(outer_mm: float, support: str) -> fl.Result:
        body = {**RING_PAIR["body_2"], "outer_diameter_mm": outer_mm, "rim": support}
        tables = {**RING_PAIR, "body_2": body, "load": {"torque_Nm": 50}}
        tables |= {"positions": {"count": 2}, "accuracy": COARSE, "effects": {"contact": "lumped"}}
        return solve(fl.Scene.from_dict(tables))

    thick, thin = (run(outer, "held").transmission_error_um.mean() for outer in (220.0, 205.0))
    assert thin < thick
    assert run(205.0, "torque").transmission_error_um.mean() > 5.0 * thick
    notes = [line for line in run(205.0, "held").warnings if "rim of" in line]
    wanted = "body_2: the rim of 8.75 mm is 2.92 modules, below 3.5: held, it cannot bend "
    assert notes == [wanted + '(body_2.rim = "torque" holds only its mean motion)']


def test_rims_of_helical_rings_count_normal_modules() -> None:
    helical = fl.read_scene(SCENES / "internal_helical.toml")
    ring, rim = helical.body_2, held_rim(build_bodies(helical).body_2)
    thickness = 0.5 * (ring.outer_diameter_mm - ring.root_diameter_mm)
    assert rim.thickness_mm == pytest.approx(thickness, rel=SOLVER)
    assert rim.ratio == pytest.approx(thickness / ring.module_mm, rel=SOLVER)


def test_a_thin_rim_on_a_flexible_shaft_has_another_remedy() -> None:
    """A bore that follows a flexible shaft cannot be free."""
    steps = {"diameters_mm": [55.0], "lengths_mm": [140.0], "gear_position_mm": 70.0}
    ends = {"bearing_positions_mm": [10.0, 130.0], "radial_stiffness_N_per_um": [200.0, 200.0]}
    shaft = {**steps, **ends, "under_teeth": "flexible", "torque_end": "I"}
    pair = build_bodies(scene(55.0, "held", pinion={"shaft": shaft}))
    (note,) = rim_notes(pair.names, pair.bodies)
    remedy = "held, it cannot bend (on a pinion shaft, half the root diameter suits "
    assert note.endswith(remedy + "body_1.bore_diameter_mm)")


def test_a_bore_moves_with_its_shaft_in_the_mean() -> None:
    """A shaft that tilts and shifts adds its own displacement, with either support."""
    solid = {"dimension": 3, "accuracy": {"axial_degree": 5, "load_degree_z": 0, "slices": 4}}
    rows = np.diag([3e-6, 3e-6, 1e-6, 1e-9, 1e-9, 0.0]).tolist()
    shaft = {"shaft": {"compliance": rows}}
    added = [
        solve(scene(40.0, support, pinion=shaft, **solid)).rotation_rad
        - solve(scene(40.0, support, **solid)).rotation_rad
        for support in ("held", "torque")
    ]
    np.testing.assert_allclose(added[1], added[0], rtol=2e-3)
    assert added[0].min() > SOLVER
