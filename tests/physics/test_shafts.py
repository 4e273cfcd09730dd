"""Bodies in slices on shafts, against the same contact with the displacements as gaps."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.bodies.shaft import Shaft
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import BodyCompliance
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.from_sweep import shaft_loads
from flankload.mechanisms.flank_pair.stages import contact_of
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.slices import Slices
from flankload.result.optional_results import ShaftLoads
from tests.support.gear_scenes import example
from tests.support.solving import solve
from tests.support.three_dimensional import HELICAL, SMALL, tree_of
from tests.support.tolerances import SOLVER

TORQUE = 302e3
#: One pair carries, and two, off the corners of the tips.
POSITIONS = np.array([0.0, 0.2])
COARSE = {
    **{"flank_element_mm": 4.0, "modes": 4, "axial_degree": 5, "load_degree_z": 1},
    **{"slices": 8, "estimate": False, "tangents": False},
}
#: Forces of slices settle to 1e-6 of the largest; an error of a place is as small.
SETTLED = 1e-5
#: Relative to the effect of shafts: normals and levers are those of undisplaced flanks in the core,
#: and those of the loaded contacts by hand. Of rotations, of forces.
AS_GAPS, FORCES_AS_GAPS = 1e-3, 3e-2
#: Sides that change their sign in a mirror z -> -z.
MIRROR = np.diag([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])
BEAM: dict[str, Any] = {
    "diameters_mm": [40.0],
    "lengths_mm": [120.0],
    "gear_position_mm": 40.0,
    "bearing_positions_mm": [10.0, 110.0],
    "radial_stiffness_N_per_um": [300.0, 300.0],
    "axial_stiffness_N_per_um": [0.0, 100.0],
}


def tables(helix: float = 0.0) -> dict[str, Any]:
    """The FZG pair in three dimensions, or one as large with a helix."""
    scene = example("external_gear")
    scene |= {"effects": {"dimension": 3}, "accuracy": COARSE, "positions": {"angles_deg": [0, 6]}}
    for name, hand in (("body_1", "right"), ("body_2", "left")):
        if helix:
            module = 4.5 * float(np.cos(np.radians(helix)))
            scene[name] |= {"helix_angle_deg": abs(helix), "module_mm": module}
            scene[name]["hand"] = hand if helix > 0 else {"right": "left", "left": "right"}[hand]
            scene[name]["profile_shift"] = 0.1
            scene["pair"]["center_distance_mm"] = 91.0
    return scene


@cache
def prepared(helix: float = 0.0) -> tuple[fl.Scene, BodyPair, tuple[BodyCompliance, ...]]:
    scene = fl.Scene.from_dict(tables(helix))
    pair = build_bodies(scene)
    return scene, pair, tuple(compliance_of(b, scene) for b in (pair.body_1, pair.body_2))


def on_shafts(pair: BodyPair, *shafts: np.ndarray | None) -> BodyPair:
    """The pair on shafts with these compliances."""
    bodies = []
    for body, rows in zip((pair.body_1, pair.body_2), shafts, strict=True):
        shaft = None if rows is None else Shaft(rows, 0.0, np.zeros((0, 3, 6)))
        bodies.append(replace(body, axial=replace(body.axial, shaft=shaft)))
    return replace(pair, bodies=(bodies[0], bodies[1]))


def run(pair: BodyPair, helix: float = 0.0, torque: float = TORQUE) -> Sweep:
    scene, _, compliances = prepared(helix)
    (found,) = sweep(contact_of(scene, pair, compliances), POSITIONS, [torque])
    return found


def soft(seed: int = 1, size: float = 1e-6) -> np.ndarray:
    """Any compliance: definite, without rotation about the axis."""
    random = np.random.default_rng(seed).normal(size=(6, 6))
    scale = np.sqrt(size) * np.array([0.5, 0.5, 0.5, 0.1, 0.1, 0.0])
    rows = scale[:, None] * (random @ random.T / 6.0) * scale
    return np.asarray(0.5 * (rows + rows.T))


def loads(pair: BodyPair, found: Sweep) -> ShaftLoads:
    shafts = shaft_loads(pair, pair.slices, found)
    assert shafts is not None
    return shafts


@dataclass(frozen=True)
class WithGaps(Slices):
    """Slices with a gap of their own (S, J) on each flank, along the base tangent."""

    gap_mm: np.ndarray | None = None

    def site_deviations(self, deviations_mm: np.ndarray, body: int) -> np.ndarray:
        known = super().site_deviations(deviations_mm, body)
        return known - self.gap_mm.ravel() if body == 0 and self.gap_mm is not None else known


def recession(pair: BodyPair, found: Sweep, p: int) -> np.ndarray:
    """(S, J) By how much both bodies recede along the normals; a dense product, by hand."""
    twist = pair.body_1.axial.twist_rad_per_mm
    site, table = found.pairs.at(p)
    number = found.pairs.slices_at(p)
    column = dict(zip(found.pairs.names, table.T, strict=True))
    n_t = np.stack([column["normal_x"], column["normal_y"]])
    lever = column["x"] * n_t[1] - column["y"] * n_t[0]
    cosine = 1.0 / np.sqrt(1.0 + (twist * lever) ** 2)
    total = np.zeros(site.size)
    for z, body in enumerate((pair.body_1, pair.body_2)):
        if body.axial.shaft is None:
            continue
        x = column["x"] - z * pair.pairing.center_distance_mm
        n = np.stack([cosine * n_t[0], cosine * n_t[1], -twist * lever * cosine])
        at = np.stack([x, column["y"], pair.slices.z_mm[number]])
        w = np.concatenate([n, np.cross(at.T, n.T).T])
        total += w.T @ body.axial.shaft.compliance @ w @ column["force"]
    receded = np.zeros((pair.pairing.sites.size, pair.slices.count))
    receded[site, number] = total / cosine
    return receded


@pytest.mark.parametrize("helix", [0.0, 15.0])
@pytest.mark.parametrize("which", [(True, False), (False, True), (True, True)])
def test_shafts_are_gaps_that_follow_the_forces(helix: float, which: tuple[bool, bool]) -> None:
    """The same forces and rotation as of fixed bores with w' S w F added to the gaps by hand."""
    _, pair, _ = prepared(helix)
    held = on_shafts(pair, *(soft(z) if has else None for z, has in enumerate(which)))
    found = run(held, helix)
    rigid = run(pair, helix)
    for p in range(POSITIONS.size):
        gaps = recession(held, found, p)
        by_hand = run(replace(pair, slices=WithGaps(**vars(pair.slices), gap_mm=gaps)), helix)
        turned = found.rotation_rad[p] - rigid.rotation_rad[p]
        assert turned > 0.01 * rigid.rotation_rad[p]
        np.testing.assert_allclose(
            by_hand.rotation_rad[p] - rigid.rotation_rad[p], turned, rtol=AS_GAPS
        )
        moved = found.slices.force_N[p] - rigid.slices.force_N[p]
        assert np.abs(moved).max() > 0.01 * found.slices.force_N[p].max()
        np.testing.assert_allclose(
            by_hand.slices.force_N[p] - rigid.slices.force_N[p],
            moved,
            rtol=0.0,
            atol=FORCES_AS_GAPS * np.abs(moved).max(),
        )


def test_displaced_bodies_turn_by_the_work_of_the_force() -> None:
    """Displacements alone leave the forces as they are: F S F/torque more rotation."""
    _, pair, _ = prepared()
    rows = np.diag([2e-6, 1e-6, 3e-6, 0.0, 0.0, 0.0])
    rigid, found = run(pair), run(on_shafts(pair, rows, None))
    scale = rigid.slices.force_N.max()
    np.testing.assert_allclose(
        found.slices.force_N, rigid.slices.force_N, rtol=0.0, atol=SETTLED * scale
    )
    assert pair.pairing.gear_geometry is not None
    angle = pair.pairing.gear_geometry.pressure_angle_rad
    normal = np.array([np.sin(angle), np.cos(angle)])
    work = rigid.site_force_N.sum(axis=1) ** 2 * (normal @ rows[:2, :2] @ normal)
    turned = found.rotation_rad - rigid.rotation_rad
    np.testing.assert_allclose(turned, work / TORQUE, rtol=AS_GAPS)


@pytest.mark.parametrize("helix", [0.0, 15.0])
def test_a_stiff_shaft_is_a_fixed_bore(helix: float) -> None:
    _, pair, _ = prepared(helix)
    rigid = run(pair, helix)
    found = run(on_shafts(pair, 1e-10 * soft(), 1e-10 * soft()), helix)
    np.testing.assert_allclose(found.rotation_rad, rigid.rotation_rad, rtol=SOLVER)
    scale = rigid.slices.force_N.max()
    np.testing.assert_allclose(
        found.slices.force_N, rigid.slices.force_N, rtol=0.0, atol=SOLVER * scale
    )


def test_a_shaft_of_either_body() -> None:
    """Spur flanks see the sum of both: one shaft on body 1 is the same on body 2."""
    _, pair, _ = prepared()
    rows = soft(3)
    one, two = run(on_shafts(pair, rows, None)), run(on_shafts(pair, None, rows))
    half = run(on_shafts(pair, 0.5 * rows, 0.5 * rows))
    for other in (two, half):
        np.testing.assert_allclose(other.rotation_rad, one.rotation_rad, rtol=SOLVER)
        np.testing.assert_allclose(other.slices.force_N, one.slices.force_N, atol=1e-5)


def test_mirrored_bodies_on_mirrored_shafts() -> None:
    """z -> -z with the other hand."""
    _, pair, _ = prepared(15.0)
    _, other, _ = prepared(-15.0)
    one = run(on_shafts(pair, soft(1), soft(2)), 15.0)
    mirrored = [MIRROR @ soft(seed) @ MIRROR for seed in (1, 2)]
    two = run(on_shafts(other, *mirrored), -15.0)
    np.testing.assert_allclose(two.rotation_rad, one.rotation_rad, rtol=1e-8)
    scale = one.slices.force_N.max()
    np.testing.assert_allclose(
        two.slices.force_N[..., ::-1], one.slices.force_N, rtol=0.0, atol=1e-7 * scale
    )


def test_the_tilt_is_a_helix_slope() -> None:
    """Forces on shafts are those on fixed bores with the tilt as a gap."""
    _, pair, _ = prepared()
    held = on_shafts(pair, soft(1), soft(2))
    found = run(held)
    tilt = loads(held, found).tilt_um_per_mm
    assert np.abs(tilt).min() > 0.05
    for p, slope in enumerate(tilt):
        gap = slope / 1000.0 * (pair.slices.z_mm - pair.slices.z_mm[0])
        sloped = replace(pair.slices, removed_mm=(gap, np.zeros_like(gap)))
        wanted = run(replace(pair, slices=sloped)).slices.force_N[p]
        np.testing.assert_allclose(
            found.slices.force_N[p], wanted, rtol=0.0, atol=5.0 * SETTLED * wanted.max()
        )


@cache
def solved(gear_position_mm: float, helix: float = 0.0, body: str = "body_1") -> Any:
    """Results for 150 and 300 N m of a pair, one of whose gears is on a shaft."""
    scene = tables(helix)
    scene[body]["shaft"] = {**BEAM, "gear_position_mm": gear_position_mm}
    scene["load"]["torque_Nm"] = [150, 300]
    return solve(fl.Scene.from_dict(scene))


def test_a_pinion_in_the_middle_does_not_tilt() -> None:
    for result in solved(60.0):
        assert np.abs(result.tilt_um_per_mm).max() < 1e-12
        load = result.slices.line_load_N_per_mm
        np.testing.assert_allclose(load[..., ::-1], load, rtol=0.0, atol=1e-8 * load.max())
        one, two = np.moveaxis(result.shafts.bearing_force_1_N, 1, 0)
        np.testing.assert_allclose(one, two, rtol=0.0, atol=1e-6)


def test_a_pinion_beside_the_middle_tilts() -> None:
    """More load on one end, the more the farther; the tilt grows with the torque."""
    middle, near, far = solved(60.0), solved(40.0), solved(25.0)
    for t in (0, 1):
        factors = [results[t].face_load_factor for results in (middle, near, far)]
        assert 1.0 < factors[0] < factors[1] < factors[2]
        # the flanks approach each other where more load is
        load = far[t].slices.line_load_N_per_mm.sum(axis=1)
        closes = -np.sign(far[t].tilt_um_per_mm)
        assert (closes * (load[:, -1] - load[:, 0]) > 0.0).all()
    np.testing.assert_allclose(
        far[1].tilt_um_per_mm / far[1].torque_Nm,
        far[0].tilt_um_per_mm / far[0].torque_Nm,
        rtol=2e-2,
    )
    other = solved(80.0)[1]
    np.testing.assert_allclose(other.tilt_um_per_mm, -near[1].tilt_um_per_mm, rtol=1e-8)


@pytest.mark.parametrize("body", ["body_1", "body_2"])
def test_bearings_carry_the_force_of_the_teeth(body: str) -> None:
    """Their sum; on the line of action, against the turning of body 1."""
    for result in solved(40.0, 15.0, body):
        name = f"bearing_force_{body[-1]}_N"
        force = getattr(result.shafts, name).sum(axis=1)
        sign = 1.0 if body == "body_1" else -1.0
        whole = result.site_force_N.sum(axis=1)
        np.testing.assert_allclose(np.linalg.norm(force, axis=1), whole, rtol=1e-4)
        np.testing.assert_allclose(sign * force[:, 2], result.slices.axial_force_N, rtol=1e-3)
        # body 1 turns counter-clockwise and drives at positive x: it is pushed down
        assert (sign * force[:, 1] < 0.0).all()
        # axial force: the fixed bearing alone
        np.testing.assert_allclose(getattr(result.shafts, name)[:, 0, 2], 0.0, atol=1e-9)


def test_the_state_of_an_overhung_pinion_with_sharp_tips_is_unique() -> None:
    """Regression: open slices on corners were too wide, so K was not definite (status 3)."""
    overhung = {
        "diameters_mm": [40.0],
        "lengths_mm": [200.0],
        "gear_position_mm": 140.0,
        "bearing_positions_mm": [20.0, 90.0],
        "radial_stiffness_N_per_um": [300.0, 300.0],
        "axial_stiffness_N_per_um": [100.0, 0.0],
    }
    changes = {**SMALL, "accuracy__slices": 24, "positions__count": 2}
    result = solve(fl.Scene.from_dict(tree_of(HELICAL, {**changes, "body_1__shaft": overhung})))
    assert result.status.tolist() == [0, 0]


def test_tilt_and_bearing_forces_are_exported() -> None:
    result = solved(40.0)[1]
    tree = json.loads(result.to_json())
    assert tree["tilt_um_per_mm"] == result.tilt_um_per_mm.tolist()
    assert tree["bearing_force_1_N"] == result.shafts.bearing_force_1_N.tolist()
    assert "bearing_force_2_N" not in tree
    summary = tree["summary"]
    assert summary["tilt_mean_um_per_mm"] == pytest.approx(result.tilt_um_per_mm.mean())
    norms = np.linalg.norm(result.shafts.bearing_force_1_N, axis=2)
    assert summary["bearing_force_1_max_N"] == norms.max(axis=0).tolist()
    assert "tilt_um_per_mm" in result.to_csv().splitlines()[0].split(",")
    plain = solve(fl.Scene.from_dict(tables()))
    assert plain.shafts is None
    assert "tilt_um_per_mm" not in json.loads(plain.to_json())


def test_an_imposed_compliance_is_that_of_its_beam() -> None:
    """The 6 x 6 matrix of the same shaft gives the same result, without bearings."""
    scene = tables()
    scene["load"]["torque_Nm"] = [150, 300]
    beam = fl.Scene.from_dict({**scene, "body_1": {**scene["body_1"], "shaft": BEAM}})
    body = build_bodies(beam).body_1
    assert body.axial.shaft is not None
    scene["body_1"]["shaft"] = {"compliance": body.axial.shaft.compliance.tolist()}
    for one, two in zip(solve(fl.Scene.from_dict(scene)), solved(40.0), strict=True):
        np.testing.assert_array_equal(one.rotation_rad, two.rotation_rad)
        np.testing.assert_array_equal(one.tilt_um_per_mm, two.tilt_um_per_mm)
        assert one.shafts.bearing_forces == {}
