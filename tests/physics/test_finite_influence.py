"""Influence numbers of finite forces (Fig. 5 of the paper), against the same in plain arrays."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.elasticity.nodal_loads import linear_shapes
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.stages import FINITE_STEPS
from flankload.pairing.body_pair import BodyPair
from tests.support.gear_scenes import example
from tests.support.solving import solve
from tests.support.tolerances import SOLVER

SCENE = example("external_gear")
#: Two pairs carry, off tip corners.
ANGLE_DEG = 11.25
#: So many times softer than steel.
SOFT = 8.0
#: Of forces, relative to the largest: over a contact the core has one direction of the force, these
#: arrays one for each pair. The forces of few nodes feel it, their sums do not.
FORCES = 2e-2


def scene_of(soft: float = SOFT, **effects: Any) -> fl.Scene:
    tree = deepcopy(SCENE)
    tree["positions"] = {"angles_deg": [ANGLE_DEG]}
    tree["accuracy"] = {"estimate": False, "tangents": False}
    if effects.get("near_field") == "nodes":
        tree["accuracy"]["flank_element_mm"] = 0.3
    for body in ("body_1", "body_2"):
        tree[body]["young_modulus_MPa"] = 206000.0 / soft
    tree["effects"] = effects
    return fl.Scene.from_dict(tree)


def solved(**effects: Any) -> fl.Result:
    found = solve(scene_of(**effects))
    assert isinstance(found, fl.Result)
    return found


def test_forces_at_a_sharp_corner_come_to_rest_slowly() -> None:
    """40 passes are not enough there."""
    tree = deepcopy(SCENE)
    tree["positions"] = {"angles_deg": [7 * 360 / 16 / 32]}
    tree["accuracy"] = {"estimate": False, "tangents": False}
    small, finite = (
        solve(fl.Scene.from_dict({**tree, "effects": {"influence": influence}}))
        for influence in ("small", "finite")
    )
    assert isinstance(small, fl.Result)
    assert isinstance(finite, fl.Result)
    assert finite.corner_contact.any()
    assert finite.status.tolist() == [0]
    # MODEL: at corners finite forces change the rotation by some 1e-4
    assert finite.rotation_rad[0] == pytest.approx(small.rotation_rad[0], rel=2e-3)


# --- the same in plain arrays ---------------------------------------------------------------------
class Flank:
    """Pairs of one body: places, directions and how they move under unit forces at each pair."""

    def __init__(self, pair: BodyPair, scene: fl.Scene, table: Any, z: int) -> None:
        body = (pair.body_1, pair.body_2)[z]
        s = (table.arc_length_1_mm, table.arc_length_2_mm)[z]
        turn = pair.pairing.turns(pair.position_rad)[z][0]
        sites = np.searchsorted(pair.pairing.sites, table.site)
        axis = np.array([z * pair.pairing.center_distance_mm, 0.0])
        curves = [body.curve.rotated(turn + pair.pairing.site_angles_rad[z][k]) for k in sites]
        self.points = np.array([axis + c.point([x])[0] for c, x in zip(curves, s, strict=True)])
        self.tangents = np.array([c.tangent([x])[0] for c, x in zip(curves, s, strict=True)])
        self.normals = np.stack([-self.tangents[:, 1], self.tangents[:, 0]], axis=1)
        self.levers = np.abs(np.sum(self.points * self.tangents, axis=1))
        found = compliance_of(body, scene)
        assert found.tangential is not None
        teeth = pair.pairing.site_teeth[z][sites]
        block = found.block_of(teeth[:, None], teeth[None, :], body.teeth)
        assert found.modes.nodes is not None
        values = linear_shapes(s, found.modes.nodes)
        self.normal, self.tangential = (
            np.einsum("ia,ijab,jb->ij", values, part[block], values)
            for part in (found.smooth, found.tangential)
        )
        self.normal /= scene.pair.face_width_mm
        self.tangential /= scene.pair.face_width_mm

        # (i, j, 2): of point i for a unit contact force into the body at j
        self.moved = -(
            self.normal[:, :, None] * self.normals[:, None]
            + self.tangential.T[:, :, None] * self.tangents[:, None]
        )

    @staticmethod
    def _cells(table: Any, s: np.ndarray, sites: np.ndarray) -> np.ndarray:
        cells = np.empty(s.size)
        for k in np.unique(sites):
            own = sites == k
            cells[own] = np.abs(np.gradient(s[own]))
        return cells


def cut(line: np.ndarray, radius: float, near: int) -> np.ndarray:
    """Intersection of an extended polyline with a circle: the one closest to a point."""
    one, along = line[:-1], np.diff(line, axis=0)
    a, b = np.sum(along**2, axis=1), np.sum(one * along, axis=1)
    root = np.sqrt(np.maximum(b**2 - a * (np.sum(one**2, axis=1) - radius**2), 0.0))
    found = []
    for t in ((-b - root) / a, (-b + root) / a):
        inside = (t > -1e-12) & (t < 1 + 1e-12)
        inside[0] |= t[0] < 0
        inside[-1] |= t[-1] > 0
        found.append((one + t[:, None] * along)[inside])
    points = np.concatenate(found)
    return points[np.linalg.norm(points - line[near], axis=1).argmin()]


def angle_per_force(
    points: np.ndarray, moved: np.ndarray, sites: np.ndarray, i: int, force: float
) -> float:
    """Least squares through the origin of the angle to the cut over the force."""
    own = np.flatnonzero(sites == sites[i])
    steps = force * np.arange(1, FINITE_STEPS + 1) / FINITE_STEPS
    angles = []
    for part in steps:
        line = points[own] + part * moved[own]
        found = cut(line, float(np.linalg.norm(points[i])), int(np.flatnonzero(own == i)[0]))
        (x, y), (u, v) = points[i], found
        angles.append(np.arctan2(x * v - y * u, x * u + y * v))
    return float(np.dot(angles, steps) / np.dot(steps, steps))


def rebuilt(scene: fl.Scene, table: Any) -> tuple[fl.ContactState, fl.ContactState]:
    """States with small influence numbers, and with those of the forces that were found."""
    pair = build_bodies(scene)
    one, two = (Flank(pair, scene, table, z) for z in (0, 1))
    small = one.normal + two.normal
    lever = 0.5 * (one.levers + two.levers)
    gap = np.arctan2(two.points[:, 1], two.points[:, 0])
    gap -= np.arctan2(one.points[:, 1], one.points[:, 0])
    matrix = small.copy()
    for j in np.flatnonzero(table.force_N > 0):
        for sign, flank in ((-1, one), (1, two)):
            for i in range(lever.size):
                full, least = (
                    angle_per_force(flank.points, flank.moved[:, j], table.site, i, force)
                    for force in (table.force_N[j], 1e-4 * table.force_N[j])
                )
                matrix[i, j] += sign * lever[i] * (full - least)

    def state(numbers: np.ndarray) -> fl.ContactState:
        return fl.solve_contact_general(
            numbers, lever * gap, lever, 1000.0 * scene.torques_Nm[0], load_rows=one.levers
        )

    return state(small), state(matrix)


# --- tests ----------------------------------------------------------------------------------------
def test_soft_bodies_against_plain_arrays() -> None:
    scene = scene_of(near_field="nodes", influence="finite")
    found = solve(scene)
    assert isinstance(found, fl.Result)
    table = found.pairs(0)
    small, finite = rebuilt(scene, table)
    plain = solved(near_field="nodes")
    effect = float(np.squeeze(finite.rotation / small.rotation)) - 1
    assert abs(effect) > 5e-4
    assert found.rotation_rad[0] / plain.rotation_rad[0] - 1 == pytest.approx(effect, rel=0.02)
    np.testing.assert_allclose(
        finite.normal_forces, table.force_N, rtol=0, atol=FORCES * table.force_N.max()
    )


def test_effect_grows_as_bodies_get_softer() -> None:
    """Contacts then widen, and cells with them: each carries as much."""
    changes = []
    for soft in (1.0, 4.0):
        finite, small = (
            solved(soft=soft, influence=kind).rotation_rad[0] for kind in ("finite", "small")
        )
        changes.append(finite / small - 1)
    assert 2.5 < changes[1] / changes[0] < 4.5


def test_steel_gears_on_coarse_nodes_change_by_a_fiftieth_of_a_percent() -> None:
    """The change is -0.02 % with widely spaced pairs, less with more pairs of smaller forces."""
    finite, small = (
        solved(soft=1.0, near_field="nodes", influence=kind) for kind in ("finite", "small")
    )
    assert finite.rotation_rad[0] / small.rotation_rad[0] - 1 == pytest.approx(-2e-4, rel=0.5)
    assert np.abs(finite.load_share - small.load_share).max() < 3e-4


def test_friction_rubs_with_finite_forces_too() -> None:
    """The contribution of forces along the flank vanishes with the coefficient."""
    effects = {}
    for mu in (0.0, 1e-6, 0.2):
        finite, small = (
            solved(near_field="nodes", influence=kind, friction_coefficient=mu).rotation_rad[0]
            for kind in ("finite", "small")
        )
        effects[mu] = finite / small - 1
    assert effects[1e-6] == pytest.approx(effects[0.0], rel=1e-4)
    assert abs(effects[0.2] - effects[0.0]) > 10 * abs(effects[1e-6] - effects[0.0])


@pytest.mark.parametrize("near_field", ["analytic", "nodes"])
def test_roots_have_the_stress_of_normal_forces_alone(near_field: str) -> None:
    """Regression: without friction, finite forces have no root stress along the flanks."""
    finite, small = (
        solved(soft=1.0, near_field=near_field, influence=kind, root_stress=True).root_stress
        for kind in ("finite", "small")
    )
    for one, two in zip(finite, small, strict=True):
        assert one is not None
        assert two is not None
        largest = two.tension.stress_MPa.max()
        np.testing.assert_allclose(one.stress_MPa, two.stress_MPa, rtol=0, atol=1e-3 * largest)


def test_counters_distinguish_finite_forces_from_small_ones() -> None:
    plain = fl.solve(scene_of(soft=1.0))
    assert plain.cost["finite_solutions"] == plain.cost["unit_loads_tangential"] == 0
    finite = fl.solve(scene_of(soft=1.0, influence="finite"))
    states = finite.cost["of_this_torque"]
    assert 2 <= states["finite_solutions"] <= 10 * states["contact_passes"]
    assert finite.cost["unit_loads_tangential"] == finite.cost["unit_loads_normal"]
    np.testing.assert_allclose(finite.rotation_rad, plain.rotation_rad, rtol=1e-3, atol=0)
    assert abs(finite.rotation_rad[0] / plain.rotation_rad[0] - 1) > SOLVER
