"""Contact on the coast flanks: nothing changes while none touches; preload, balance, symmetry."""

from __future__ import annotations

import json
from math import pi, radians, tan
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import flankload as fl
from flankload.bodies.body import Body
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.near_field import (
    mirrored_loads,
    mode_loads,
    mode_norms,
    mode_values,
)
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.result import Result
from flankload.scene import Ring
from tests.support.cam_scenes import cam_scene
from tests.support.cells_near_field import cells_near_field
from tests.support.pair_scenes import EXTERNAL, RING_PAIR, SPLINE, scene_of, solved
from tests.support.ring_bodies import full_ring, gear_body
from tests.support.tolerances import ROUND_OFF, RUBBING, SOLVER, SPEED_MM

BOTH = {"effects": {"coast_flank": True}}
#: 10 um nearer than FZG type C: both flanks of a tooth touch.
TIGHT = {**EXTERNAL, "pair": {**EXTERNAL["pair"], "center_distance_mm": 91.49}}

#: Rings closed from one sector against meshed ones.
CLOSURE = 1e-10
#: Lumped contacts beside pairs on cells.
LUMPED = 5e-3
#: Pairs by their own normals, not by that of their contact, on their own row levers.
ORACLE = 1e-3
#: Forces at the points of flank 1 along their normals, about either axis: residual of pairing on
#: circles.
ON_CIRCLES = 1.5e-3


def pressed(wider_um: float, torque_Nm: float, **more: object) -> Result:
    """A spline of which the teeth are wider than the spaces."""
    shift = wider_um / 1000.0 / (2 * 2.0 * tan(radians(30.0)))
    pair = {**SPLINE, "body_1": {**SPLINE["body_1"], "profile_shift": shift}}
    return solved(pair, torque_Nm, count=1, **more)


# --- nothing changes while no coast flank touches -----------------------------------------------


@pytest.mark.parametrize("pair", [EXTERNAL, RING_PAIR, SPLINE], ids=["gears", "ring", "spline"])
def test_with_backlash_nothing_changes(pair: dict) -> None:
    one, two = solved(pair, 300.0, count=6), solved(pair, 300.0, count=6, **BOTH)
    assert two.coast_force_N is not None
    assert not two.coast_force_N.any()
    for name in ("rotation_rad", "site_force_N", "peak_pressure_MPa", "status"):
        # more readings, and the cells of flanks that come near, change the order of sums
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), rtol=SOLVER, atol=0.0)
    assert "none carries" in two.table()


def test_effect_is_paid_for_only_where_it_is_asked_for() -> None:
    # each alone: shared bodies cost nothing
    one, two = (fl.solve(scene_of(EXTERNAL, 300.0, count=2, **keys)) for keys in ({}, BOTH))
    assert one.cost["coast_readings"] == 0
    assert one.coast is None
    assert one.coast_force_N is None
    loads = ("unit_loads_normal", "corner_readings")
    assert two.cost["coast_readings"] == sum(two.cost[name] for name in loads) > 0
    for name in (*loads, "fe_factorisations", "influence_columns"):
        assert one.cost[name] == two.cost[name]
    # coast flanks leave the contact in the estimate of the forces
    assert one.cost["pivots"] < two.cost["pivots"]


# --- splines: closed forms ----------------------------------------------------------------------


def test_press_fit_loads_every_tooth_alike_on_both_sides() -> None:
    result = pressed(3.0, 0.0, **BOTH)
    assert result.coast_force_N is not None
    every = np.concatenate([result.site_force_N[0], result.coast_force_N[0]])
    assert every.size == 24
    np.testing.assert_allclose(every, every[0], rtol=100 * SOLVER, atol=0.0)
    # both sides press alike where body 1 is in the middle
    assert result.transmission_error_um[0] == pytest.approx(1.5, rel=100 * SOLVER)


def test_stiffness_of_both_sides_follows_from_preload_and_one_side() -> None:
    """Sum of the recessions of flanks under equal and opposite forces on both sides of the teeth.

    Each working flank recedes by (S + X) F under preload F on all flanks, by (S - X) dF under
    forces dF against each other, and by S F where the working flanks alone carry: flanks that
    conform up to sharp edges have no other nonlinearity.
    """
    base = 12 * np.cos(radians(30.0))
    preload, more = pressed(3.0, 0.0, **BOTH), pressed(3.0, 200.0, **BOTH)
    alone = pressed(-3.0, 400.0)
    assert more.coast_force_N is not None
    torque_part = 200e3 / (2 * 12 * base)
    force = preload.site_force_N[0]
    np.testing.assert_allclose(more.site_force_N[0], force + torque_part, rtol=1e-5)
    np.testing.assert_allclose(more.coast_force_N[0], force - torque_part, rtol=1e-5)
    turned = more.rotation_rad[0] - preload.rotation_rad[0]
    alike = base * preload.rotation_rad[0] / force[0]
    opposite = base * turned / torque_part
    single = base * alone.rotation_rad[0] / alone.site_force_N[0, 0]
    assert alike + opposite == pytest.approx(2 * single, rel=ORACLE)
    assert 0.0 < alike < single < opposite


def test_coast_flanks_open_when_the_torque_exceeds_the_preload() -> None:
    result = pressed(3.0, 1500.0, **BOTH)
    assert result.coast is not None
    assert not result.coast.force_N.any()
    expected = 1500e3 / (12 * 12 * np.cos(radians(30.0)))
    np.testing.assert_allclose(result.site_force_N[0], expected, rtol=1e-6)


# --- gears without backlash ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def tight() -> Result:
    return solved(TIGHT, 60.0, count=8, **BOTH)


def moments_Nmm(result: Result, p: int) -> tuple[float, float]:
    """Moments about both axes of all forces on body 2, at their points along their normals."""
    assert result.coast is not None
    total = np.zeros(2)
    for table in (result.pairs(p), result.coast.pair_tables[p]):
        for z, axis in enumerate((0.0, result.drawing.center_distance_mm)):
            turned = (table.x_mm - axis) * table.normal_y - table.y_mm * table.normal_x
            total[z] += turned @ table.force_N
    return float(total[0]), float(total[1])


def test_torque_is_held_by_both_sides(tight: Result) -> None:
    assert tight.coast_force_N is not None
    assert (tight.coast_force_N > 0).any()
    for p in range(8):
        one, two = moments_Nmm(tight, p)
        assert one == pytest.approx(60e3, rel=100 * ROUND_OFF)
        if not (tight.corner_contact[p].any() or tight.coast.corner_contact[p].any()):
            assert two == pytest.approx(-90e3, rel=ON_CIRCLES)


def test_curves_close_over_a_pitch() -> None:
    angles = {"positions": {"angles_deg": [3.0, 3.0 + 22.5]}}
    result = solved(TIGHT, 60.0, **BOTH, **angles)
    assert result.coast_force_N is not None
    assert result.rotation_rad[1] == pytest.approx(result.rotation_rad[0], rel=SOLVER)
    for force in (result.site_force_N, result.coast_force_N):
        carry = force > 0
        np.testing.assert_allclose(force[0, carry[0]], force[1, carry[1]], rtol=1e-7)
        # the load of pair j is that of pair j - 1 a pitch later
        np.testing.assert_array_equal(result.sites[carry[0]] - 1, result.sites[carry[1]])


def test_without_torque_both_sides_are_mirror_images() -> None:
    """Body 2 is its own mirror image where the other flank of its space is at the pitch point."""
    pair = build_bodies(scene_of(TIGHT, 0.0, **BOTH))
    mesh = pair.pairing.gear_geometry
    assert mesh is not None
    assert pair.body_2.involute is not None
    space = 2 * pi / 24 - 2 * pair.body_2.involute.tooth_half_angle_at(mesh.pitch_radius_2_mm)
    turn = np.degrees(space * 24 / 16)
    angles = [-2.0, 1.0, 4.0, 7.5]
    mirrored = [float(turn) - angle for angle in angles]
    result = solved(TIGHT, 0.0, **BOTH, positions={"angles_deg": angles + mirrored})
    assert result.coast_force_N is not None
    # pairs are found at the position of body 1 without load: normals of one side are those of the
    # other one but for the play between both, here 2e-4 rad
    play = -mesh.backlash_mm / mesh.pitch_radius_1_mm
    assert play > 0.0
    for p in range(4):
        working = result.site_force_N[p][result.site_force_N[p] > 0]
        coast = result.coast_force_N[p + 4][result.coast_force_N[p + 4] > 0]
        np.testing.assert_allclose(working, coast[::-1], rtol=play, atol=0.0)
        assert working.size > 0
    # turns from the middle of the play
    middle = result.rotation_rad - 0.5 * play
    np.testing.assert_allclose(middle[:4], -middle[4:], rtol=0.0, atol=play * play)


def test_state_is_that_of_an_independent_assembly(tight: Result) -> None:
    """Gaps from the placed bodies, K from blocks and strips, the problem solved as such."""
    p = 4
    scene = scene_of(TIGHT, 60.0, **BOTH)
    pair = build_bodies(scene)
    assert tight.coast is not None
    tables = (tight.pairs(p), tight.coast.pair_tables[p])
    sides = np.concatenate([np.full(len(t), s) for t, s in zip(tables, (1, -1), strict=True)])
    joined = {
        name: np.concatenate([getattr(table, name) for table in tables])
        for name in ("site", "arc_length_1_mm", "arc_length_2_mm", "cell_mm", "force_N")
    }
    matrix = np.zeros((sides.size, sides.size))
    gaps, levers = np.zeros(sides.size), np.zeros(sides.size)
    for i, side in enumerate(sides):
        gaps[i], levers[i] = _gap_and_lever(
            pair, p, int(joined["site"][i]), int(side), float(joined["arc_length_1_mm"][i])
        )
    for z, body in enumerate((pair.body_1, pair.body_2)):
        matrix += _compliance(body, z, sides, joined) / 14.0
    state = fl.solve_contact_general(matrix, gaps, motions=levers, loads=60e3)
    assert (state.normal_forces[sides < 0] > 0).any()
    assert state.motions[0] == pytest.approx(tight.rotation_rad[p], rel=ORACLE)
    for site in np.unique(joined["site"]):
        for side in (1, -1):
            own = (joined["site"] == site) & (sides == side)
            assert state.normal_forces[own].sum() == pytest.approx(
                joined["force_N"][own].sum(), rel=0.0, abs=ORACLE * joined["force_N"].sum()
            )


def _gap_and_lever(pair: BodyPair, p: int, site: int, side: int, s_1: float) -> tuple[float, float]:
    """Gap along the normal (mm) and lever (mm) of a point of flank 1, both negative on the coast.

    The coast flank of a tooth is its working one mirrored on its centre line.
    """
    one, two = pair.body_1, pair.body_2
    turn_1, turn_2 = (turn[p] for turn in pair.pairing.turns(pair.position_rad))
    tooth_2 = -site if side > 0 else 1 - site
    angle_1, angle_2 = turn_1 + 2 * pi * site / one.teeth, turn_2 + 2 * pi * tooth_2 / two.teeth

    def placed(body: Body, angle: float, axis: float, s: float) -> np.ndarray:
        assert body.involute is not None
        x, y = body.curve.rotated(-body.involute.turn_rad).point([s])[0]
        c, d = np.cos(angle + body.involute.turn_rad), np.sin(angle + body.involute.turn_rad)
        return np.array([axis + c * x - d * side * y, d * x + c * side * y])

    point = placed(one, angle_1, 0.0, s_1)
    radius = np.hypot(*point)
    distance = pair.pairing.center_distance_mm
    low, high = two.mode_range_mm
    s_2 = brentq(
        lambda s: np.hypot(*placed(two, angle_2, distance, s)) - radius, low, high, xtol=1e-13
    )
    other = placed(two, angle_2, distance, s_2)
    ahead = np.arctan2(point[0] * other[1] - point[1] * other[0], point @ other)
    base = pair.body_1.base_radius_mm
    assert base is not None
    return ahead * side * base, side * base


def _compliance(body: Body, z: int, sides: np.ndarray, joined: dict[str, np.ndarray]) -> np.ndarray:
    """Recession of one body at all pairs under forces at all pairs, mm²/N."""
    found = flank_compliance(body, JobOptions(n_modes=5, plane="strain", coast_flanks=True))
    assert found.coast is not None
    s = joined[f"arc_length_{z + 1}_mm"]
    low, high = body.mode_range_mm
    values = mode_values(s, (low, high), 5)
    tooth = joined["site"] if z == 0 else np.where(sides > 0, -joined["site"], 1 - joined["site"])
    result = np.empty((s.size, s.size))
    for i in range(s.size):
        for j in range(s.size):
            apart = int(tooth[i] - tooth[j])
            block = found.smooth if sides[i] == sides[j] else found.coast.normal[: body.teeth]
            # seen from a coast flank teeth count the other way
            block = block[(apart if sides[j] > 0 else -apart) % body.teeth]
            result[i, j] = values[i] @ block @ values[j]
    same = (joined["site"][:, None] == joined["site"]) & (sides[:, None] == sides)
    cell = np.sqrt(joined["cell_mm"][:, None] * joined["cell_mm"])
    return np.where(same, result + cells_near_field(found, s, cell), result)


# --- compliance across a tooth ------------------------------------------------------------------


RING = Ring(
    teeth=12, module_mm=3.0, tip_diameter_mm=35.0, root_diameter_mm=43.0, outer_diameter_mm=55.0
)


@pytest.mark.parametrize(
    "body",
    [
        gear_body(7, 2.5, profile_shift=0.5),
        build_involute_body(RING, "body_2", flank_element_mm=2.0),
    ],
    ids=["outwards", "inwards"],
)
def test_compliance_across_a_tooth_is_that_of_the_meshed_ring(body: Body) -> None:
    mesh, span, n_modes = body.mesh, body.mode_range_mm, 3
    assert body.involute is not None
    loads = mode_loads(mesh, span, n_modes)
    other, tooth = mirrored_loads(mesh, loads, body.involute.turn_rad)
    whole = full_ring(mesh, span, n_modes, other)[:, n_modes:]
    norms = mode_norms(span, n_modes)
    expected = np.roll(whole, tooth, axis=0) / (norms[:, None] * norms)
    options = JobOptions(n_modes=n_modes, plane="strain", coast_flanks=True)
    coast = flank_compliance(body, options).coast
    assert coast is not None
    found = coast.normal[: body.teeth]
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()
    # a force on a working flank pushes the coast flank of its own tooth out, wherever both are
    nearest = np.abs(found[:, 0, 0]).argmax()
    assert found[nearest, 0, 0] < 0.0
    place = mesh.nodes[np.flatnonzero(np.abs(other).max(axis=1).reshape(-1, 2).any(axis=1))]
    polar = np.arctan2(place[:, 1], place[:, 0])
    center = body.involute.turn_rad + 2 * pi * tooth / body.teeth
    assert (polar < center).all()
    assert (polar > center - pi / body.teeth).all()


# --- friction -----------------------------------------------------------------------------------


def test_friction_on_both_sides_keeps_the_balance_of_work() -> None:
    result = solved(
        TIGHT, 60.0, count=8, effects={"coast_flank": True, "friction_coefficient": 0.1}
    )
    smooth = solved(TIGHT, 60.0, count=8, **BOTH)
    assert result.friction is not None
    assert result.coast is not None
    assert smooth.coast is not None
    friction = result.friction
    off = ~(result.corner_contact | result.coast.corner_contact).any(axis=1)
    assert off.sum() >= 4
    work_2 = friction.torque_2_Nm * np.abs(friction.speed_2)
    np.testing.assert_allclose(
        (work_2 + friction.loss_J_per_rad)[off], 60.0, rtol=ON_CIRCLES, atol=0.0
    )
    # both sides lose work
    carries = (result.coast.force_N > 0).any(axis=1)
    assert (carries & off).sum() >= 3
    for p in np.flatnonzero(carries & off):
        table = result.coast.pair_tables[p]
        assert table.sliding_mm_per_rad is not None
        assert table.friction_force_N is not None
        loss = table.sliding_mm_per_rad * table.friction_force_N
        assert (loss >= -ROUND_OFF * np.abs(loss).max()).all()
        # sliding of rigid bodies along the tangent to the tip, on this side right of the normal
        t = np.stack([-table.normal_y, table.normal_x])
        y, x_1, x_2 = table.y_mm, table.x_mm, table.x_mm - 91.49
        one = -y * t[0] + x_1 * t[1]
        two = -16 / 24 * (-y * t[0] + x_2 * t[1])
        weight = table.force_N / table.force_N.sum()
        rolling = float(weight @ (two - one))
        # points are those before body 1 has turned by its rotation
        moved = (1 + 16 / 24) * float(np.abs(result.rotation_rad[p] * table.radius_mm).max())
        assert weight @ table.sliding_mm_per_rad == pytest.approx(
            rolling, rel=RUBBING, abs=SPEED_MM + moved
        )


# --- results ------------------------------------------------------------------------------------


def test_files_and_table_have_the_coast_flanks(tight: Result) -> None:
    assert tight.coast_force_N is not None
    tree = json.loads(tight.to_json())
    np.testing.assert_allclose(tree["coast_force_N"], tight.coast_force_N)
    assert len(tree["coast_pairs"]) == 8
    assert sum(tree["coast_pairs"][4]["force_N"]) == pytest.approx(tight.coast_force_N[4].sum())
    header = tight.to_csv().splitlines()[0]
    assert "coast_force_N_pair_0" in header
    assert "coast_peak_pressure_MPa_pair_0" in header
    summary = tight.summary
    assert summary["coast_force_N"] == pytest.approx(float(tight.coast_force_N.max()))
    assert summary["coast_flanks_loaded_max"] == (tight.coast_force_N > 0).sum(axis=1).max()
    line = next(text for text in tight.table().splitlines() if text.startswith("coast flanks"))
    assert " carry, up to " in line
    fit = pressed(3.0, 100.0, **BOTH)
    assert "coast  pressure" in fit.table()


# --- refused scenes -----------------------------------------------------------------------------


def refused(*scene: Any, **more: Any) -> str:
    with pytest.raises(SceneError) as caught:
        build_bodies(scene_of(*scene, **more))
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_bodies_whose_coast_flanks_are_not_known_are_refused() -> None:
    with pytest.raises(SceneError) as caught:
        fl.Scene.from_dict(cam_scene(**BOTH))
    assert str(caught.value) == (
        "effects.coast_flank: expected false with body_1.kind 'follower', which has one flank, "
        "found true"
    )
    mesh = {"kind": "mesh", "file": "a.msh", "teeth": 16, "reference_radius_mm": 34.0}
    assert refused({**EXTERNAL, "body_2": mesh}, 1.0, **BOTH) == (
        "effects.coast_flank: expected false with body_2.kind 'mesh', of whose teeth a file names "
        "one flank, found true"
    )


def test_two_rigid_bodies_cannot_press_on_each_other() -> None:
    assert refused(EXTERNAL, 0.0, rigid=True, **BOTH) == (
        "effects.coast_flank: expected false with body_1.rigid and body_2.rigid: flanks that press "
        "on each other across a tooth must be elastic, found true"
    )


def test_root_stress_is_refused_beside_it() -> None:
    both = {"effects": {"coast_flank": True, "root_stress": True}}
    assert refused(EXTERNAL, 1.0, **both) == (
        "effects.root_stress: expected false with effects.coast_flank: stress is known for forces "
        "on the working flanks only, found true"
    )


@pytest.mark.parametrize(("torque_Nm", "friction"), [(0.0, 0.0), (100.0, 0.0), (50.0, 0.08)])
def test_lumped_contacts_carry_on_both_flanks(torque_Nm: float, friction: float) -> None:
    """Regression: refused. Pressed against each other as on cells, also without torque."""
    rubs = {"friction_coefficient": friction} if friction else {}
    cells, lumped = (
        solved(TIGHT, torque_Nm, count=4, effects={"coast_flank": True, **model, **rubs})
        for model in ({}, {"contact": "lumped"})
    )
    force = cells.site_force_N.max()
    assert cells.coast_force_N is not None
    assert lumped.coast_force_N is not None
    assert cells.coast_force_N.max() > 0.3 * force
    np.testing.assert_allclose(lumped.rotation_rad, cells.rotation_rad, rtol=LUMPED)
    for name in ("site_force_N", "coast_force_N"):
        found, wanted = getattr(lumped, name), getattr(cells, name)
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=LUMPED * force)


def test_a_press_fit_has_its_limits() -> None:
    wide = {**SPLINE, "body_1": {**SPLINE["body_1"], "profile_shift": 0.05}}
    assert "effects.coast_flank = true" in refused(wide, 1.0)
    assert refused(wide, 1.0, **BOTH) == (
        "body_1.profile_shift: expected a tooth wider than its space by at most 0.0544 mm on the "
        "pitch circle (0.01 of the base pitch), even with effects.coast_flank, found 0.1155 mm"
    )
