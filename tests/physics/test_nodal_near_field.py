"""Forces at the nodes of the flanks in place of modes: the way of the paper in the sweep."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.elasticity import nodal_loads
from flankload.elasticity.near_field import mode_loads
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.gear_scenes import example
from tests.support.nodal_position import NodalPosition
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF, SOLVER

SCENE = example("external_gear")
# One pair, two pairs; no tip corner at work. Hertz half-widths 0.18, 0.14 mm.
ANGLES_DEG = [2.0, 11.25]
#: Error of the rotation with nodes at these distances, against modes, and the last of the largest
#: pressure.
SPACINGS = (0.2, 0.1, 0.05)
ROTATION = (0.03, 0.01, 0.003)
PRESSURE = 0.1
#: Of the rotation, and of the largest force: over a contact the core has one direction of the force
#: by both chords, the plain way each circle that of its points (1e-4 of the levers). With the same
#: levers nothing is left.
DIRECTION, FORCES = 1e-4, 3e-3


def solved(
    rigid: int | None = None, angles: Any = None, by: Callable[..., Any] = solve, **effects: Any
) -> fl.Result:
    tree = deepcopy(SCENE)
    tree["positions"] = {"angles_deg": ANGLES_DEG if angles is None else angles}
    tree["accuracy"] = {"estimate": False, "tangents": False}
    if "h" in effects:
        tree["accuracy"]["flank_element_mm"] = effects.pop("h")
    if rigid is not None:
        tree[f"body_{rigid}"]["rigid"] = True
    tree["effects"] = effects
    found = by(fl.Scene.from_dict(tree))
    assert isinstance(found, fl.Result)
    return found


def nodal_scene(h: float) -> fl.Scene:
    tree = deepcopy(SCENE) | {"positions": {"angles_deg": ANGLES_DEG}}
    tree["accuracy"] = {"flank_element_mm": h, "estimate": False, "tangents": False}
    tree["effects"] = {"near_field": "nodes"}
    return fl.Scene.from_dict(tree)


def error(found: fl.Result, reference: fl.Result) -> float:
    return float(np.abs(found.rotation_rad / reference.rotation_rad - 1).max())


@pytest.fixture(scope="module")
def modes() -> fl.Result:
    return solved()


@pytest.fixture(scope="module")
def nodes() -> fl.Result:
    return solved(near_field="nodes", h=0.1)


# --- loads ----------------------------------------------------------------------------------------
def test_unit_forces_of_all_nodes_make_an_even_pressure() -> None:
    body = build_bodies(nodal_scene(0.5)).body_1
    assert body.mesh is not None
    places = nodal_loads.flank_nodes(body.mesh)
    loads = nodal_loads.nodal_unit_loads(body.mesh, places)
    even = mode_loads(body.mesh, body.mode_range_mm, 1)[:, 0]
    widths = nodal_loads.shape_widths(places)
    np.testing.assert_allclose(loads @ widths, even, rtol=0, atol=ROUND_OFF * np.abs(even).max())
    fewer, parts = nodal_loads.every_second_node(places)
    coarse = nodal_loads.nodal_unit_loads(body.mesh, fewer)
    np.testing.assert_allclose(loads @ parts, coarse, rtol=0, atol=ROUND_OFF * np.abs(coarse).max())
    np.testing.assert_allclose(parts.sum(axis=0), 1.0, rtol=0, atol=ROUND_OFF)


def test_a_rounded_tip_has_nodes_up_to_its_end() -> None:
    tree = deepcopy(SCENE)
    tree["body_1"]["tip_radius_mm"] = 0.5
    tree["effects"] = {"near_field": "nodes"}
    tree["accuracy"] = {"flank_element_mm": 0.1, "estimate": False, "tangents": False}
    tree["positions"] = {"count": 8}
    found = solve(fl.Scene.from_dict(tree))
    tree["effects"] = {}
    tree["accuracy"] = {"estimate": False, "tangents": False}
    reference = solve(fl.Scene.from_dict(tree))
    assert isinstance(found, fl.Result)
    assert isinstance(reference, fl.Result)
    body = build_bodies(fl.Scene.from_dict(tree)).body_1
    assert body.mesh is not None
    last = nodal_loads.flank_nodes(body.mesh)[-1]
    np.testing.assert_allclose(last, body.curve.length_mm, rtol=ROUND_OFF, atol=0)
    # where the tip works its rounding carries
    assert error(found, reference) < 0.03


# --- results --------------------------------------------------------------------------------------
def test_error_falls_with_the_spacing(modes: fl.Result, nodes: fl.Result) -> None:
    found = [
        solved(near_field="nodes", h=SPACINGS[0]),
        nodes,
        solved(near_field="nodes", h=SPACINGS[2]),
    ]
    errors = [error(result, modes) for result in found]
    assert np.all(np.array(errors) < ROTATION), errors
    assert errors[0] > 2 * errors[1] > 4 * errors[2]
    np.testing.assert_allclose(found[2].load_share, modes.load_share, rtol=0, atol=2e-3)
    carries = modes.peak_pressure_MPa > 0
    peaks = found[2].peak_pressure_MPa[carries] / modes.peak_pressure_MPa[carries]
    assert np.abs(peaks - 1).max() < PRESSURE, peaks


def count_of_nodes(h: float) -> int:
    """Nodes of both flanks."""
    pair = build_bodies(nodal_scene(h))
    return sum(
        nodal_loads.flank_nodes(body.mesh).size for body in (pair.body_1, pair.body_2) if body.mesh
    )


def test_counters_distinguish_nodes_from_modes() -> None:
    modes, nodes = solved(by=fl.solve), solved(near_field="nodes", h=0.4, by=fl.solve)
    assert nodes.cost["unit_loads_normal"] == count_of_nodes(0.4)
    assert nodes.cost["unit_loads_nodal"] == nodes.cost["unit_loads_normal"]
    assert nodes.cost["unit_loads_tangential"] == 0
    assert modes.cost["unit_loads_nodal"] == modes.cost["finite_solutions"] == 0
    assert nodes.cost["finite_solutions"] == 0


def test_default_distance_of_nodes_is_a_fifth_of_the_half_width() -> None:
    tree = deepcopy(SCENE)
    tree["effects"] = {"near_field": "nodes"}
    pair = build_bodies(fl.Scene.from_dict(tree))
    # Hertz at mid-height under all of the load: sqrt(8 F rho (1 - nu²)/(pi E)), the radii where
    # the flanks meet on the line of action
    half_width = 0.26
    for body in (pair.body_1, pair.body_2):
        assert body.mesh is not None
        apart = np.diff(nodal_loads.flank_nodes(body.mesh))
        assert 0.15 * half_width < apart.min() <= apart.max() < 0.21 * half_width


def test_one_position_is_that_of_the_plain_interface(nodes: fl.Result) -> None:
    """The same tables and nodes through `flankload_position` and the contact loop.

    There the flanks are splines through the nodes.
    """
    scene = nodal_scene(0.1)
    pair = build_bodies(scene)
    p = 1
    width = scene.pair.face_width_mm
    turns = pair.pairing.turns(pair.position_rad[p : p + 1])
    axes = (np.zeros(2), np.array([pair.pairing.center_distance_mm, 0.0]))
    sites = np.flatnonzero(np.isin(pair.pairing.sites, np.unique(nodes.pairs(p).site)))
    points, tables, sizes = [], [], []
    for z, body in enumerate((pair.body_1, pair.body_2)):
        compliance = compliance_of(body, scene)
        assert compliance.modes.nodes is not None
        angles = turns[z][0] + pair.pairing.site_angles_rad[z][sites]
        points.append(
            np.concatenate(
                [axes[z] + body.curve.rotated(a).point(compliance.modes.nodes) for a in angles]
            )
        )
        teeth = pair.pairing.site_teeth[z][sites]
        block = compliance.block_of(teeth[:, None], teeth[None, :], body.teeth)
        n = compliance.modes.nodes.size
        tables.append(compliance.smooth[block].transpose(0, 2, 1, 3).reshape(2 * n, 2 * n) / width)
        sizes.append(np.full(2, n, dtype=np.intc))
    plain = NodalPosition(
        torque_Nmm=1000.0 * scene.torques_Nm[0],
        axes=axes,
        sizes=(sizes[0], sizes[1]),
        points=(points[0], points[1]),
        compliances=(tables[0], tables[1]),
    )
    flank, radius, gap_angle, lever, row, _, matrix = plain.pairs()
    state = fl.solve_contact_general(
        matrix, lever * gap_angle, lever, plain.torque_Nmm, load_rows=row
    )
    np.testing.assert_allclose(state.rotation, nodes.rotation_rad[p], rtol=DIRECTION, atol=0)
    table = nodes.pairs(p)
    carrying = table.force_N > 0
    largest = table.force_N.max()
    for k, site in enumerate(pair.pairing.sites[sites], start=1):
        own = carrying & (table.site == site)
        theirs = (flank == k) & (state.normal_forces > 0)
        np.testing.assert_allclose(radius[theirs], table.radius_mm[own], rtol=SOLVER, atol=0)
        np.testing.assert_allclose(
            state.normal_forces[theirs], table.force_N[own], rtol=0, atol=FORCES * largest
        )


def test_friction_has_the_same_effect_with_nodes_as_with_modes(modes: fl.Result) -> None:
    nodes = solved(near_field="nodes", h=SPACINGS[0])
    rubbing = solved(friction_coefficient=0.1)
    found = solved(friction_coefficient=0.1, near_field="nodes", h=SPACINGS[0], by=fl.solve)
    grown = found.rotation_rad / nodes.rotation_rad, rubbing.rotation_rad / modes.rotation_rad
    np.testing.assert_allclose(*grown, rtol=0, atol=5e-4)
    assert np.abs(grown[1] - 1).max() > 3e-3
    count = count_of_nodes(SPACINGS[0])
    assert found.cost["unit_loads_tangential"] == found.cost["unit_loads_normal"] == count


@pytest.mark.parametrize("rigid", [1, 2])
def test_one_body_may_be_rigid(rigid: int) -> None:
    """Pairs are on circles through the nodes of the body with nodes."""
    reference = solved(rigid=rigid)
    assert error(solved(rigid=rigid, near_field="nodes", h=0.1), reference) < 0.02


def test_root_stress_comes_from_forces_at_nodes() -> None:
    plain = solved(rigid=2, root_stress=True).root_stress[0]
    found = solved(rigid=2, root_stress=True, near_field="nodes", h=0.1).root_stress[0]
    assert plain is not None
    assert found is not None
    np.testing.assert_allclose(
        found.tension.stress_MPa, plain.tension.stress_MPa, rtol=0.01, atol=1.0
    )


def test_error_estimate_is_that_of_half_as_many_nodes() -> None:
    tree = deepcopy(SCENE)
    tree["positions"] = {"angles_deg": ANGLES_DEG}
    tree["effects"] = {"near_field": "nodes"}
    tree["accuracy"] = {"flank_element_mm": 0.1, "tangents": False}
    found = solve(fl.Scene.from_dict(tree))
    assert isinstance(found, fl.Result)
    estimated = found.estimate["transmission_error"]
    # nodes 0.2 mm apart leave 2.6 %, 0.1 mm 0.8 %
    assert 0.005 < estimated < 0.05


def test_nodes_too_far_apart_get_a_warning(nodes: fl.Result) -> None:
    (distance, other) = solved(near_field="nodes", h=0.4).warnings[-2:]
    assert distance.startswith("body_1: nodes up to 0.39 mm apart, 1.5 Hertz half-widths")
    assert other.startswith("body_2: nodes up to")
    assert not any("apart" in warning for warning in nodes.warnings)
