"""Expansion of three-dimensional bodies by heat and speed: sizes, helices, flanks, refusals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from msgspec import structs

import flankload as fl
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.compliance import JobOptions, flank_compliance, no_compliance
from flankload.elasticity.compliance.contributions import Expansion
from flankload.elasticity.prism import Prism
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.stages import expanded_pair
from flankload.pairing.expansion import BodyLoad
from flankload.scene.plane_section import plane_section
from tests.support.ring_bodies import gear
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

RISE, STRAIN = 200.0, 11.5e-6 * 200.0
WEBBED = {
    "web_width_mm": 3.0,
    "web_outer_diameter_mm": 85.0,
    "hub_diameter_mm": 45.0,
    "hub_width_mm": 17.0,
}
BASE_HELIX = np.arcsin(np.sin(np.radians(15.0)) * np.cos(np.radians(20.0)))


def solve(**changes: Any) -> fl.Result:
    return solved(HELICAL, {"body_1__lead_crowning_um": None, **changes})


def test_a_pair_that_grows_as_a_whole_is_as_it_was() -> None:
    """Both bodies and the centre distance: no gap opens, forces keep their places."""
    warm = {"effects__temperature_rise_K": RISE, "pair__center_distance_mm": 132.0 * (1 + STRAIN)}
    unloaded = solve(load__torque_Nm=0.0, **warm).rotation_rad
    # positions count from flanks of the cold bodies
    assert np.ptp(unloaded) < 1e-11
    cold, found = solve(positions__count=16), solve(positions__count=16, **warm)
    # levers grow by the strain, and displacements turn the body by so much less again; face
    # widths stay: measured 0.1 %
    turned = (found.rotation_rad - unloaded[0]) * (1 + STRAIN) ** 2
    assert turned.mean() == pytest.approx(cold.rotation_rad.mean(), rel=2e-3)
    loads = found.slice_line_load_N_per_mm.sum(axis=(0, 1)) * (1 + STRAIN)
    assert deviation(loads, cold.slice_line_load_N_per_mm.sum(axis=(0, 1))) < 3e-3


@pytest.mark.parametrize("warm", [0, 1])
def test_a_helix_of_one_warm_body_is_longer(warm: int) -> None:
    """Its sections turn back by e tan(beta_b)/r_b per length, about the middle of its width."""
    scene = fl.Scene.from_dict(tree_of(HELICAL, {**SMALL, "body_1__axial_offset_mm": 3.0}))
    pair = build_bodies(scene)
    bodies = pair.body_1, pair.body_2
    expansions = [Expansion(STRAIN if z == warm else 0.0) for z in (0, 1)]
    one, two = (
        replace(no_compliance(body), expansion=expansion)
        for body, expansion in zip(bodies, expansions, strict=True)
    )
    grown, compliances = expanded_pair(pair, (one, two))
    assert grown.slices is not None
    middle = (3.0, 0.0)[warm]
    twist = (1.0, -1.0)[warm] * np.tan(BASE_HELIX) / bodies[warm].base_radius_mm
    back = -twist * (pair.slices.z_mm - middle) * STRAIN / (1 + STRAIN)
    changed = [np.subtract(grown.slices.turns_rad[z], pair.slices.turns_rad[z]) for z in (0, 1)]
    np.testing.assert_allclose(changed[warm], back, rtol=1e-9, atol=1e-15)
    assert not changed[1 - warm].any()
    for z, body in enumerate((grown.body_1, grown.body_2)):
        before = bodies[z].axial
        assert before is not None
        wanted = before.twist_rad_per_mm / (1 + STRAIN * (z == warm))
        assert body.axial.twist_rad_per_mm == pytest.approx(wanted, rel=ROUND_OFF)
        modes = compliances[z].modes.axial
        assert modes is not None
        assert modes.twist == pytest.approx(wanted, rel=ROUND_OFF)


def test_a_warm_wheel_loads_one_end() -> None:
    """Helices of two lengths: the load moves to the side on which the wheel is ahead."""
    even = solve()
    found = [
        solve(effects__temperature_rise_K=rises, effects__beyond_limits=True)
        for rises in ([RISE, 0.0], [0.0, RISE])
    ]
    ends = [
        (load[..., -1].sum(axis=1) - load[..., 0].sum(axis=1)).mean()
        for load in (result.slice_line_load_N_per_mm for result in (even, *found))
    ]
    # a right-hand pinion that is longer lags at larger z, its mate forward
    assert ends[1] < ends[0] - 20.0
    assert ends[2] > ends[0] + 20.0


# --- expansion that is not uniform ----------------------------------------------------------------
FREE = {"body_1__bore": "torque", "body_2__bore": "torque"}


@pytest.mark.parametrize("twist", [0.0, 0.01])
def test_a_free_bore_lets_a_prism_expand_evenly(twist: float) -> None:
    """This holds with any support, also with webs and hubs of other widths."""
    spec = gear(teeth=24, tip_diameter_mm=119.0, bore="torque", **WEBBED)
    body = build_involute_body(spec, "body_1", flank_element_mm=3.0)
    regions = (("web", (-2.0, 1.0)), ("hub", (-9.0, 8.0)))
    prism = Prism((-5.0, 7.0), twist, 5, 1, regions=regions)
    found = flank_compliance(
        body,
        JobOptions(n_modes=3, prism=prism),
        body_load=BodyLoad(strain=STRAIN, held_strain=0.3 * STRAIN),
    ).expansion
    assert found.strain == pytest.approx(STRAIN, rel=SOLVER)
    assert found.axial_strain == pytest.approx(STRAIN, rel=ROUND_OFF)
    assert np.abs(found.shifts["temperature"]).max() < SOLVER * STRAIN * spec.tip_diameter_mm


def test_a_narrow_pair_at_speed_is_in_plane_stress() -> None:
    """Its flanks move along normals that a helix inclines: measured 1.6e-3 of the rotation."""
    changes = {
        **SMALL,
        **FREE,
        "body_1__lead_crowning_um": None,
        "load__torque_Nm": 0.0,
        "pair__face_width_mm": 1.0,
        "accuracy__slices": 4,
        "effects__speed_rpm": 9000.0,
    }
    scene = fl.Scene.from_dict(tree_of(HELICAL, changes))
    section = plane_section(scene)
    thin = replace(section, accuracy=structs.replace(section.accuracy, plane="stress"))
    found, wanted = (solve_scene(each).rotation_rad for each in (scene, thin))
    assert np.abs(wanted).min() > 1e-5
    np.testing.assert_allclose(found, wanted, rtol=3e-3)


def test_both_flanks_of_a_fast_pair_are_mirror_images() -> None:
    """The other hands carry the same loads, end for end, on working and coast flanks."""
    keys: dict[str, Any] = {
        "pair__center_distance_mm": 131.91,
        "load__torque_Nm": 0.0,
        "effects__coast_flank": True,
        "effects__speed_rpm": 20000.0,
        "effects__temperature_rise_K": 40.0,
        "effects__support_expansion_per_K": 0.0,
        "effects__beyond_limits": True,
        "body_1__axial_offset_mm": 2.0,
        "positions__count": 2,
    }
    one = solve(**keys)
    other = solve(**{**keys, **OTHER_HANDS, "body_1__axial_offset_mm": -2.0})
    slow = solve(**{**keys, "effects__speed_rpm": None})
    loads, images, still = (result.slice_line_load_N_per_mm for result in (one, other, slow))
    assert loads.max() > 100.0
    assert deviation(still, loads) > 1e-2
    assert deviation(images[..., ::-1], loads) < MIRRORED
