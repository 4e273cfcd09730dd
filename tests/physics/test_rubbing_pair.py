"""Coulomb friction: known forces, statics, work, symmetry, limits, loads that cannot be held.

Pinned numbers of the FZG type C pair at a coefficient of 0.1 come from another implementation of
the same model (dense tables between nodes); its uncertainty is given beside them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.errors import NoContactState
from tests.support.paths import REFERENCE_SOLUTIONS
from tests.support.plain_friction import solve_rubbing
from tests.support.random_scenes import scenes
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF, SOLVER

#: Energy over a period: residual of pairing on circles, with and without friction.
ENERGY = 1e-3
#: Third differences of the rotation over its mean.
SMOOTH = 1e-3
WIDTH, DISTANCE = 14.0, 91.5
INTERNAL = json.loads((REFERENCE_SOLUTIONS / "internal_pair.json").read_text())["scene"]


def gear(teeth: int, shift: float, tip: float, bore: float, **keys: Any) -> dict[str, Any]:
    return {
        "kind": "gear",
        "teeth": teeth,
        "module_mm": 4.5,
        "profile_shift": shift,
        "tip_diameter_mm": tip,
        "bore_diameter_mm": bore,
        **keys,
    }


def fzg(mu: Any = None, *, driver: str = "body_1", torque: Any = 302.0, **tables: Any) -> fl.Scene:
    """The FZG type C pair."""
    scene = {
        "body_1": gear(16, 0.182, 82.46, 30.0),
        "body_2": gear(24, 0.171, 118.36, 40.0),
        "pair": {"center_distance_mm": DISTANCE, "face_width_mm": WIDTH},
        "load": {"torque_Nm": torque},
        "accuracy": {"estimate": False, "tangents": False, "flank_element_mm": 1.0, "modes": 5},
        **tables,
    }
    scene["positions"] = {"driver": driver, **scene.get("positions", {"count": 8})}
    if mu is not None:
        scene["effects"] = {"friction_coefficient": mu, **scene.get("effects", {})}
    return fl.Scene.from_dict(scene)


@cache
def solved(mu: float | None, driver: str = "body_1", count: int = 8) -> fl.Result:
    return solve(fzg(mu, driver=driver, positions={"count": count}))


#: Of jammed pairs, whose largest torque is searched: the same holds on any cells.
FEW_CELLS = {
    "estimate": False,
    "tangents": False,
    "flank_element_mm": 1.0,
    "modes": 5,
    "strips_per_half_width": 2.5,
    "corner_strips_per_half_width": 2.5,
}


def forces_at(result: fl.Result, p: int) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 2) and forces on body 2 (n, 2) of the pairs of a position, friction included."""
    pairs = result.pairs(p)
    normal = np.stack([pairs.normal_x, pairs.normal_y], axis=1)
    tangent = np.stack([pairs.normal_y, -pairs.normal_x], axis=1)
    force = pairs.force_N[:, None] * normal - pairs.friction_force_N[:, None] * tangent
    return np.stack([pairs.x_mm, pairs.y_mm], axis=1), force


def moment(place: np.ndarray, force: np.ndarray) -> float:
    return float(np.sum(place[:, 0] * force[:, 1] - place[:, 1] * force[:, 0]))


def test_force_at_the_pitch_point() -> None:
    """The sign of sliding changes inside the contact: one sign for all of it gives 612 or 665."""
    result = solved(0.1)
    assert result.site_force_N[0].sum() / WIDTH == pytest.approx(635.7, abs=0.5)
    factor = result.pairs(0).friction_force_N / np.maximum(result.pairs(0).force_N, 1e-300)
    assert factor.min() == pytest.approx(-0.1, rel=1e-12)
    assert factor.max() == pytest.approx(0.1, rel=1e-12)


def test_rotation_and_load_share_of_the_known_pair() -> None:
    change = 100 * (solved(0.1).rotation_rad / solved(None).rotation_rad - 1)
    assert change.mean() == pytest.approx(-1.0, abs=0.2)
    assert np.abs(change).max() == pytest.approx(1.9, abs=0.2)
    assert (change < 0).all()
    share = 100 * np.abs(solved(0.1).load_share - solved(None).load_share).max()
    assert share == pytest.approx(2.5, abs=0.2)


@pytest.mark.parametrize("driver", ["body_1", "body_2"])
def test_forces_hold_the_torque_about_the_axis(driver: str) -> None:
    result = solved(0.1, driver)
    for p in range(8):
        assert moment(*forces_at(result, p)) == pytest.approx(302e3, rel=1e-10)


@pytest.mark.parametrize("mu", [0.1, 0.5])
@pytest.mark.parametrize("driver", ["body_1", "body_2"])
def test_work_of_the_driver_is_that_of_the_driven_body_and_of_friction(
    driver: str, mu: float
) -> None:
    """Torque on body 2 from the forces at their places, the loss from the sliding speeds."""
    result = solved(mu, driver, 32)
    torque_2, loss = np.empty(32), np.empty(32)
    for p in range(32):
        place, force = forces_at(result, p)
        torque_2[p] = -moment(place - [DISTANCE, 0.0], force) / 1000.0
        pairs = result.pairs(p)
        loss[p] = np.sum(pairs.friction_force_N * pairs.sliding_mm_per_rad) / 1000.0
        # friction never helps
        assert (pairs.friction_force_N * pairs.sliding_mm_per_rad >= 0).all()
    np.testing.assert_allclose(result.friction.torque_2_Nm, torque_2, rtol=SOLVER, atol=0)
    np.testing.assert_allclose(result.friction.loss_J_per_rad, loss, rtol=SOLVER, atol=0)
    work_1, work_2 = 302.0, torque_2.mean() * 16 / 24
    driven, gave = (work_2, work_1) if driver == "body_1" else (work_1, work_2)
    assert gave == pytest.approx(driven + loss.mean(), rel=ENERGY)
    efficiency = result.friction.efficiency
    assert efficiency == pytest.approx(driven / gave, abs=ENERGY)
    assert 0.85 < efficiency < 0.99
    assert result.friction.work_1_J == pytest.approx(302.0 * 2 * np.pi / 16, rel=1e-12)
    # with a speed, power and loss are in W: 302 N m at 1500 1/min are 47.4 kW
    assert "power_W" not in result.summary
    assert result.geometry is not None
    fast = replace(result, geometry=replace(result.geometry, speed_rpm=1500.0))
    assert fast.summary["power_W"] == pytest.approx(302.0 * 50.0 * np.pi, rel=ROUND_OFF)
    assert fast.summary["power_loss_W"] == pytest.approx(loss.mean() * 50.0 * np.pi, rel=SOLVER)
    assert f"47438.0 W at 1500 1/min, loss by friction {loss.mean() * 50 * np.pi:.1f} W" in str(
        fast.table()
    )


def test_loss_follows_from_the_path_of_contact() -> None:
    """With any cells, the sliding speed at a distance g from the pitch point is g (1 + z1/z2)."""
    result = solved(0.1, "body_1", 32)
    base = 4.5 * 16 / 2 * np.cos(np.radians(20.0))
    way = base * (result.position_rad[:, None] + 2 * np.pi / 16 * result.sites)
    expected = 0.1 * np.sum(result.site_force_N * np.abs(way), axis=1) * (1 + 16 / 24) / 1000.0
    assert result.friction.loss_J_per_rad.mean() == pytest.approx(expected.mean(), rel=2e-3)
    # forces act up to 0.035 mm beside the place of least gap; tip corners act beside the path
    aside = 0.1 * 0.04 * result.site_force_N.sum(axis=1) * (1 + 16 / 24) / 1000.0
    alone = (np.abs(way) > 0.5) | (result.site_force_N == 0)
    inside = alone.all(axis=1) & ~result.corner_contact.any(axis=1)
    assert inside.sum() > 20
    difference = result.friction.loss_J_per_rad - expected
    assert (np.abs(difference[inside]) < aside[inside]).all()


def test_driver_decides_the_sense_of_friction() -> None:
    one, two = solved(0.1, "body_1"), solved(0.1, "body_2")
    zero = solved(None)
    first, second = (100 * (r.rotation_rad / zero.rotation_rad - 1) for r in (one, two))
    np.testing.assert_allclose(first, -second, rtol=0, atol=0.11)
    assert np.sign(one.friction.site_friction_N[0]).tolist() != [0.0]
    np.testing.assert_allclose(two.friction.speed_1, -1.0, rtol=0, atol=0)
    np.testing.assert_allclose(two.friction.speed_2, 16 / 24, rtol=ROUND_OFF, atol=0)


def test_little_friction_changes_things_in_proportion() -> None:
    zero = solved(None)
    changes = [solved(mu).rotation_rad - zero.rotation_rad for mu in (1e-4, 1e-3)]
    np.testing.assert_allclose(
        changes[1], 10 * changes[0], rtol=0, atol=0.01 * np.abs(changes[1]).max()
    )
    assert np.abs(changes[1]).max() < 3e-4 * zero.rotation_rad.max()


def test_no_friction_is_bitwise_a_scene_without() -> None:
    zero, none, rubbing = fl.solve(fzg(0.0)), solved(None), fl.solve(fzg(0.1))
    for name in ("rotation_rad", "site_force_N", "peak_pressure_MPa", "status"):
        np.testing.assert_array_equal(getattr(zero, name), getattr(none, name))
    assert zero.friction is None
    assert zero.pairs(0).friction_force_N is None
    assert zero.cost["unit_loads_tangential"] == 0
    assert rubbing.cost["unit_loads_tangential"] == 10
    assert rubbing.cost["unit_loads_normal"] == 10
    assert rubbing.cost["fe_factorisations"] == 2


def test_exchanged_bodies_and_drivers_mirror_the_state() -> None:
    """Equal gears: the torque that body 2 feels, put on body 1 while body 2 drives, at minus ψ."""
    equal = {
        "body_1": gear(20, 0.0, 99.0, 40.0),
        "body_2": gear(20, 0.0, 99.0, 40.0),
        "pair": {"center_distance_mm": 90.0, "face_width_mm": WIDTH},
    }
    for angle in (-5.0, 2.0):
        one = solve(fzg(0.3, positions={"angles_deg": [angle]}, **equal))
        torque = float(one.friction.torque_2_Nm[0])
        two = solve(
            fzg(0.3, driver="body_2", torque=torque, positions={"angles_deg": [-angle]}, **equal)
        )
        mirrored = dict(zip((-two.sites).tolist(), two.site_force_N[0], strict=True))
        atol = 2e-3 * one.site_force_N.max()
        for site, force in zip(one.sites.tolist(), one.site_force_N[0], strict=True):
            assert force == pytest.approx(mirrored.get(site, 0.0), abs=atol)
        # without the pairing's remainder the moments would be equal, too
        assert two.friction.torque_2_Nm[0] == pytest.approx(302.0, rel=3e-3)


@pytest.mark.parametrize("body", ["body_1", "body_2"])
def test_one_body_may_be_rigid(body: str) -> None:
    """The tangential coupling of the other body remains; statics and work are satisfied."""
    rigid = {"body_1": gear(16, 0.182, 82.46, 30.0), "body_2": gear(24, 0.171, 118.36, 40.0)}
    rigid[body] = {**rigid[body], "rigid": True}
    result = fl.solve(fzg(0.3, positions={"count": 16}, **rigid))
    assert result.cost["unit_loads_tangential"] == 5
    assert (result.status == 0).all()
    for p in (0, 5):
        assert moment(*forces_at(result, p)) == pytest.approx(302e3, rel=1e-10)
    friction = result.friction
    assert friction.work_1_J == pytest.approx(
        friction.work_2_J + friction.loss_work_J, rel=2 * ENERGY
    )


def test_internal_pair_balances_its_work() -> None:
    result = solve(
        fl.Scene.from_dict(
            {
                **INTERNAL,
                "positions": {"count": 12},
                "effects": {"friction_coefficient": 0.1},
                "accuracy": {"estimate": False, "tangents": False},
            }
        )
    )
    friction = result.friction
    assert (result.status == 0).all()
    # both bodies turn the same way
    assert (friction.speed_2 > 0).all()
    assert (friction.torque_2_Nm > 0).all()
    assert friction.work_1_J == pytest.approx(friction.work_2_J + friction.loss_work_J, rel=ENERGY)
    # little sliding: 1/z1 - 1/z2 in place of the sum
    assert 0.99 < friction.efficiency < 0.998


def spline(mu: float, *, errors_um: Sequence[float] = (), **pair: Any) -> fl.Scene:
    """A spline of 18 teeth, all of them in contact; index errors of the shaft."""
    spline = {"teeth": 18, "module_mm": 2.0, "young_modulus_MPa": 210000.0}
    return fl.Scene.from_dict(
        {
            "body_1": {
                "kind": "spline_shaft",
                **spline,
                "profile_shift": 0.45,
                "tip_diameter_mm": 39.6,
                "root_diameter_mm": 35.4,
                "bore_diameter_mm": 20.0,
                **({"pitch_errors_um": list(errors_um)} if errors_um else {}),
            },
            "body_2": {
                "kind": "spline_hub",
                **spline,
                "profile_shift": 0.45,
                "tip_diameter_mm": 36.0,
                "root_diameter_mm": 40.4,
                "outer_diameter_mm": 60.0,
            },
            "pair": {"face_width_mm": 20.0, **pair},
            "load": {"torque_Nm": 500.0},
            "positions": {"count": 1},
            # an offset takes up its backlash of nothing
            "effects": {"friction_coefficient": mu, "beyond_limits": True},
            "accuracy": {"estimate": False, "tangents": False},
        }
    )


def test_spline_on_common_axes_does_not_slide() -> None:
    rubbed, plain = (solve(spline(mu)) for mu in (0.2, 0.0))
    np.testing.assert_allclose(rubbed.rotation_rad, plain.rotation_rad, rtol=SOLVER, atol=0)
    np.testing.assert_allclose(
        rubbed.site_force_N, plain.site_force_N, rtol=0, atol=1e-8 * plain.site_force_N.max()
    )
    assert any("friction has no effect" in note for note in rubbed.warnings)
    assert abs(rubbed.friction.loss_J_per_rad[0]) < 1e-9 * 500.0


def test_spline_on_axes_apart_rubs() -> None:
    """Flanks slide to and fro by the offset; the hub receives less work than the shaft supplies."""
    result = solve(spline(0.2, center_offset_mm=0.02))
    friction = result.friction
    assert not any("friction has no effect" in note for note in result.warnings)
    assert friction.loss_J_per_rad[0] > 0.0
    # no flank slides faster than the offset
    total = result.site_force_N.sum() / 1000.0
    assert friction.loss_J_per_rad[0] < 0.2 * 0.02 * total
    assert friction.torque_2_Nm[0] + friction.loss_J_per_rad[0] == pytest.approx(500.0, rel=ENERGY)


def test_spline_with_index_errors_slides_by_its_offset_alone() -> None:
    """Axes c apart, one rate: v2 - v1 = (0, -c) everywhere, also where flanks do not quite conform.

    Teeth that their index errors bring to bear late have no even gap; half a thousandth between the
    normals of both flanks would turn their sliding round.
    """
    offset, errors = 0.02, np.random.default_rng(5).uniform(-6.0, 6.0, 18).round(1)
    pairs = solve(spline(0.1, errors_um=errors.tolist(), center_offset_mm=offset)).pairs(0)
    np.testing.assert_allclose(
        pairs.sliding_mm_per_rad, offset * pairs.normal_x, rtol=0, atol=ROUND_OFF * offset
    )
    loaded = (pairs.force_N > 0) & (np.abs(pairs.normal_x) > 0.1)
    assert np.unique(pairs.site[loaded]).size > 3
    np.testing.assert_allclose(
        pairs.friction_force_N[loaded],
        0.1 * np.sign(pairs.normal_x[loaded]) * pairs.force_N[loaded],
        rtol=SOLVER,
        atol=0,
    )


def test_state_is_smooth_through_the_pitch_point() -> None:
    """Steps of force and rotation halve with the steps of the position.

    In the cell in which the sliding changes its sign, friction has the mean sign over the cell.
    """
    steps = []
    for count in (41, 81):
        angles = np.linspace(-0.8, 0.8, count).tolist()
        result = solve(fzg(0.3, positions={"angles_deg": angles}))
        steps.append(
            [
                np.abs(np.diff(result.rotation_rad)).max(),
                np.abs(np.diff(result.site_force_N.sum(axis=1))).max(),
            ]
        )
        for p in (0, count // 4):
            pairs = result.pairs(p)
            assert (pairs.site == 0).all()
            loaded = pairs.force_N > 0
            over_cell = np.abs(np.gradient(pairs.sliding_mm_per_rad))
            sign = np.clip(pairs.sliding_mm_per_rad / (0.5 * over_cell), -1, 1)[loaded]
            assert (np.abs(sign) < 1).sum() == 1
            np.testing.assert_allclose(
                pairs.friction_force_N[loaded],
                0.3 * sign * pairs.force_N[loaded],
                rtol=SOLVER,
                atol=0,
            )
    assert (np.array(steps[0]) > 1.8 * np.array(steps[1])).all()


def test_rotation_is_smooth_where_friction_acts_on_a_sharp_corner() -> None:
    """Regression: its second differences scattered by 1 % of the rotation, now by less than 0.1."""
    scene = scenes(5, seed=4343)[4][1]
    angles = (np.arange(12) * 360.0 / scene["body_1"]["teeth"] / 128).tolist()
    quiet = {"estimate": False, "tangents": False}
    scene = {**scene, "positions": {"angles_deg": angles}, "accuracy": quiet}
    found = solve(fl.Scene.from_dict(scene))
    assert isinstance(found, fl.Result)
    assert (found.corner_contact > 0).any(axis=1).all()
    steps = np.diff(found.rotation_rad, 3) / found.rotation_rad.mean()
    assert np.abs(steps).max() < SMOOTH


def test_coefficients_of_single_teeth() -> None:
    """Entry k is the tooth that comes into contact as the k-th, from that of pair 0."""
    alike = solve(fzg([0.1] * 16))
    np.testing.assert_array_equal(alike.site_force_N, solved(0.1).site_force_N)
    np.testing.assert_array_equal(alike.rotation_rad, solved(0.1).rotation_rad)
    assert alike.closed
    # pair -1 follows pair 0
    second = solve(fzg([0.0, 0.2] + [0.0] * 14))
    assert not second.closed
    assert second.friction.efficiency is None
    assert second.period_rad == pytest.approx(2 * np.pi, rel=ROUND_OFF)
    seen = set()
    for p in range(8):
        pairs = second.pairs(p)
        loaded = pairs.force_N > 0
        rubs = pairs.friction_force_N[loaded] != 0
        np.testing.assert_array_equal(rubs, pairs.site[loaded] == -1)
        seen |= set(pairs.site[loaded].tolist())
    assert {-1, 0} <= seen


def test_coefficient_over_the_roll_position() -> None:
    """Rows of roll position and coefficient: even ones are a number, others are interpolated."""
    even = solve(fzg([[-5.0, 0.1], [5.0, 0.1]]))
    np.testing.assert_allclose(even.rotation_rad, solved(0.1).rotation_rad, rtol=SOLVER, atol=0)
    result = solve(fzg([[-12.0, 0.02], [-2.0, 0.1], [8.0, 0.3], [20.0, 0.3]]))
    base = 4.5 * 16 / 2 * np.cos(np.radians(20.0))
    pitch = DISTANCE * 16 / 40
    for p in range(8):
        pairs = result.pairs(p)
        loaded = pairs.force_N > 0
        roll = np.sqrt(pairs.radius_mm[loaded] ** 2 - base**2) - np.sqrt(pitch**2 - base**2)
        found = np.abs(pairs.friction_force_N[loaded] / pairs.force_N[loaded])
        expected = np.interp(roll, [-12.0, -2.0, 8.0], [0.02, 0.1, 0.3])
        slides = np.abs(roll) > 0.5
        np.testing.assert_allclose(found[slides], expected[slides], rtol=0, atol=2e-4)


@pytest.mark.parametrize(("friction", "angle"), [(1.8, 17.2), (1.5, 16.875)])
def test_error_of_a_jammed_pair_gives_the_largest_torque(friction: float, angle: float) -> None:
    """A little less is held, a little more not; the second place works on a tip edge."""

    def jam(torque: float) -> fl.Result:
        # next to jamming a torque presses on the flanks with many times its force
        beyond = {"positions": {"angles_deg": [angle]}, "effects": {"beyond_limits": True}}
        return solve(fzg(friction, driver="body_2", torque=torque, accuracy=FEW_CELLS, **beyond))

    with pytest.raises(NoContactState, match=r"position 0 .* jams .* N m can be held") as caught:
        jam(302.0)
    held = caught.value.largest_torque
    assert 0.0 < held < 302e3
    assert moment(*forces_at(jam(0.999e-3 * held), 0)) == pytest.approx(0.999 * held, rel=1e-9)
    with pytest.raises(NoContactState):
        jam(1.001e-3 * held)


def test_nothing_is_held_where_every_lever_turns_round() -> None:
    with pytest.raises(NoContactState, match="about 0 N m can be held") as caught:
        solve(fzg(2.0, driver="body_2", positions={"angles_deg": [12.0]}))
    assert caught.value.proven


def test_plain_elements_find_the_same_changes() -> None:
    """Hats over fine elements, equal cells, the sign from the pitch circle: nothing in common.

    Both have errors of their own (0.2 % without friction): the effects of friction are compared.
    """
    keys = {
        "body_1": gear(16, 0.182, 82.46, 30.0),
        "body_2": gear(24, 0.171, 118.36, 40.0),
        "pair": {"center_distance_mm": DISTANCE, "face_width_mm": WIDTH},
        "load": {"torque_Nm": 302.0},
        "positions": {"angles_deg": [-4.0, 12.0]},
    }
    mus = (0.0, 0.2)
    results = [
        solve(
            fl.Scene.from_dict(
                {
                    **keys,
                    "effects": {"friction_coefficient": mu},
                    "accuracy": {"estimate": False, "tangents": False},
                }
            )
        )
        for mu in mus
    ]
    rotation, forces, sites = solve_rubbing(
        keys,
        mus=mus,
        element_mm=0.08,
        inner_mm=1.2,
        cell_mm=0.03,
        rotation_rad=results[0].rotation_rad,
    )
    zero, rubbed = results
    change = rubbed.rotation_rad / zero.rotation_rad
    np.testing.assert_allclose(change, rotation[1] / rotation[0], rtol=5e-4, atol=0)
    assert np.abs(change - 1).max() > 0.02
    np.testing.assert_allclose(
        rubbed.site_force_N - zero.site_force_N,
        (forces[1] - forces[0])[:, np.searchsorted(sites, zero.sites)],
        rtol=0,
        atol=1e-3 * zero.site_force_N.max(),
    )
