"""Uniform thermal expansion of three-dimensional bodies: sizes, helices, refused scenes."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.elasticity.compliance import no_compliance
from flankload.elasticity.compliance.contributions import Expansion
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.stages import expanded_pair
from tests.support.solving import solve as solve_scene
from tests.support.three_dimensional import HELICAL, SMALL, deviation, tree_of
from tests.support.tolerances import ROUND_OFF

RISE, STRAIN = 200.0, 11.5e-6 * 200.0
BASE_HELIX = np.arcsin(np.sin(np.radians(15.0)) * np.cos(np.radians(20.0)))


@cache
def _solved(text: str) -> fl.Result:
    found = solve_scene(fl.Scene.from_dict(json.loads(text)))
    assert isinstance(found, fl.Result)
    return found


def solve(**changes: Any) -> fl.Result:
    keys = {**SMALL, "body_1__lead_crowning_um": None, **changes}
    return _solved(json.dumps(tree_of(HELICAL, keys), sort_keys=True))


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


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"effects__support_expansion_per_K": 1e-6}, "support_expansion_per_K"),
        ({"effects__speed_rpm": 3000.0}, "speed_rpm"),
    ],
)
def test_loads_of_an_expansion_are_refused(changes: dict[str, Any], key: str) -> None:
    tree = tree_of(HELICAL, {"effects__temperature_rise_K": RISE, **changes})
    with pytest.raises(fl.FlankloadError, match=f"effects.{key}: expected nothing, since"):
        fl.Scene.from_dict(tree)
