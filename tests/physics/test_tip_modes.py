"""Compliance of a tooth on a tip rounding or chamfer, against fine elements under plain pressures.

Pressures of Hertz's shape act on the flank, over the start of the tip and on it. The fine
elements carry them as they are: neither modes nor a near field.
"""

from __future__ import annotations

from functools import partial
from operator import attrgetter
from typing import Any
from unittest import mock

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

import flankload as fl
from flankload.bodies import Body
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.bodies.tip_modes import Tip, tip_modes, with_tip
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.compliance.body_compliance import BodyCompliance
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.near_field import (
    consistent_loads,
    loaded_edges,
    mode_products,
    mode_values,
    projected_near_field,
    projected_sign,
    to_coefficients,
)
from flankload.scene import Gear, Ring
from tests.support.cells_near_field import strip_kernel
from tests.support.condensed import condense
from tests.support.tolerances import SOLVER

MODULE = 4.5
GEAR = {
    "teeth": 16,
    "module_mm": MODULE,
    "profile_shift": 0.182,
    "tip_diameter_mm": 82.46,
    "bore_diameter_mm": 30.0,
}
RING = {
    "teeth": 60,
    "module_mm": MODULE,
    "tip_diameter_mm": 262.8,
    "root_diameter_mm": 281.25,
    "outer_diameter_mm": 330.0,
}
#: Half-width of the pressures, modules; nodes of the plain elements, modules.
HALF_WIDTH, NODES = 0.03, 1.0 / 120
STRIPS = 400
#: Errors of elements of 1/4.5 module at places on and before a rounding, in strengths of the
#: logarithm, of 6 to 23 in all. The flank's modes, kept beyond its end, were off by 3 where it
#: begins and by 12 on it.
ROUNDED = 0.2
#: The same of a chamfer, beside whose corner the elements are long; 11 without modes of the tip.
CHAMFERED = 0.32


def made(tips: dict[str, float], nodes: float | None = None, *, ring: bool = False) -> Body:
    keys = {"flank_element_mm": MODULE / 4.5, "flank_nodes_mm": nodes}
    if ring:
        return build_involute_body(Ring(**RING, **tips), "body_2", **keys)
    return build_involute_body(Gear(**GEAR, **tips), "body_1", **keys)


def bumps(s: np.ndarray, places: np.ndarray) -> np.ndarray:
    half = HALF_WIDTH * MODULE
    x = (np.ravel(s)[:, None] - places) / half
    return 2.0 / (np.pi * half) * np.sqrt(np.clip(1.0 - x**2, 0.0, None))


def plainly(body: Body, places: np.ndarray) -> np.ndarray:
    """Mean displacements under the pressures, the cuts of the tooth held."""
    mesh: Any = body.mesh
    loads = consistent_loads(
        mesh,
        lambda s: bumps(s, places),
        count=places.size,
        gauss_points=8,
        edges=loaded_edges(mesh),
    )
    matrix = stiffness(mesh.nodes, mesh.cells, body.material, "strain")
    return condense(matrix, loads, mesh, held=True)[0].local[0]


def by_modes(body: Body, places: np.ndarray) -> np.ndarray:
    """The same by modes and logarithm, on strips."""
    found = flank_compliance(body, JobOptions(n_modes=5, plane="strain"), sectors=1)
    half = HALF_WIDTH * MODULE
    edges = np.linspace(places.min() - half, places.max() + half, STRIPS + 1)
    s, width = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
    force = bumps(s, places)
    force /= force.sum(axis=0)
    modes = force.T @ mode_values(
        s, found.modes.range_mm, found.smooth.shape[1], tip=found.modes.tip
    )
    near = strip_kernel(s[:, None] - s, width, found.near.kernel)
    return modes @ found.smooth[0] @ modes.T + force.T @ near @ force


@pytest.mark.parametrize(
    ("tips", "ring", "left"),
    [
        ({"tip_radius_mm": 0.08 * MODULE}, False, ROUNDED),
        ({"tip_radius_mm": 0.2 * MODULE}, True, ROUNDED),
        ({"tip_chamfer_mm": 0.08 * MODULE}, False, CHAMFERED),
    ],
)
def test_places_on_a_tip(tips: dict[str, float], ring: bool, left: float) -> None:
    fine, coarse = made(tips, NODES * MODULE, ring=ring), made(tips, ring=ring)
    tip = coarse.tip
    assert tip is not None
    start = coarse.mode_range_mm[1]
    length = tip.end_mm - start
    places = start + np.append([-0.2 * MODULE, -HALF_WIDTH * MODULE, 0.0], [length / 3, length / 2])
    strength = flank_compliance(
        coarse, JobOptions(n_modes=1, plane="strain"), sectors=1
    ).near.kernel
    apart = (by_modes(coarse, places) - plainly(fine, places)) / strength
    assert np.abs(apart).max() < left


def test_a_turned_force_at_the_corner_of_a_chamfer() -> None:
    """Modes of flank and chamfer, weighted with its parts, agree with fine elements under it."""
    tips = {"tip_chamfer_mm": 0.08 * MODULE}
    fine, coarse = made(tips, NODES * MODULE), made(tips)
    found = flank_compliance(coarse, JobOptions(n_modes=5, plane="strain"), sectors=1)
    tip, start = found.modes.tip, coarse.mode_range_mm[1]
    assert tip is not None
    turns = tip.turn_rad * np.array([0.0, 0.3, 0.7])
    place = np.array([start - HALF_WIDTH * MODULE])
    mesh: Any = fine.mesh
    normal, along = (
        consistent_loads(
            mesh,
            lambda s: bumps(s, place),
            count=1,
            along=direction,
            gauss_points=8,
            edges=loaded_edges(mesh),
        )
        for direction in ("normal", "tangent")
    )
    loads = np.cos(turns) * normal + np.sin(turns) * along
    matrix = stiffness(mesh.nodes, mesh.cells, fine.material, "strain")
    exact = np.diag(condense(matrix, loads, mesh, held=True)[0].local[0])
    n = found.smooth.shape[1]
    on_flank, on_chamfer = (
        mode_values(np.array([s]), found.modes.range_mm, n, tip=tip)[0]
        for s in (place[0], start + 1e-9)
    )
    parts = np.stack([np.sin(tip.turn_rad - turns), np.sin(turns)]) / np.sin(tip.turn_rad)
    modes = parts.T @ np.stack([on_flank, on_chamfer])
    moved = np.einsum("ka,ab,kb->k", modes, found.smooth[0], modes)
    apart = (moved - moved[0]) - (exact - exact[0])
    assert exact[2] < 0.7 * exact[0]
    assert np.abs(apart).max() < CHAMFERED * found.near.kernel


def test_more_modes_are_more_on_the_tip() -> None:
    """Regression: with 12 modes on the flank and two on the rounding, this peak was too low."""
    rounded = {"teeth": 19, "module_mm": 1.3, "pressure_angle_deg": 30, "tip_radius_mm": 0.12}
    scene = {
        "body_1": {
            "kind": "spline_shaft",
            "tip_diameter_mm": 25.8,
            "root_diameter_mm": 22.9,
            "bore_diameter_mm": 6.2,
            **rounded,
        },
        "body_2": {
            "kind": "spline_hub",
            "profile_shift": 0.02,
            "tip_diameter_mm": 23.6,
            "root_diameter_mm": 26.5,
            "outer_diameter_mm": 40.0,
            **rounded,
        },
        "pair": {"face_width_mm": 13.0},
        "load": {"torque_Nm": 170.0},
    }

    def peak(modes: int) -> float:
        accuracy = {"modes": modes, "estimate": False, "tangents": False}
        found = fl.solve(fl.Scene.from_dict({**scene, "accuracy": accuracy}))
        return float(found.peak_pressure_MPa.max())

    assert peak(12) == pytest.approx(peak(5), rel=0.01)


@pytest.mark.parametrize("flank", range(1, 14))
def test_number_of_a_tips_modes(flank: int) -> None:
    """The record of a body contains all modes; those of the tip follow from their number."""
    assert tip_modes(with_tip(flank)) == with_tip(flank) - flank


def modes_by_gauss(mode_range: tuple[float, float], tip: Tip, n: int) -> tuple[np.ndarray, ...]:
    """Places, weights and values on panels that shrink towards the ends of flank and tip."""
    points, weights = leggauss(20)
    ratios = 0.5 * 0.3 ** np.arange(23, -1, -1)
    parts = np.concatenate([[0.0], ratios, 1.0 - ratios[-2::-1]])
    flank, behind = np.diff([*mode_range, tip.end_mm])
    breaks = np.append(
        mode_range[0] + flank * parts, mode_range[1] + behind * np.append(parts, 1.0)
    )
    half = 0.5 * np.diff(breaks)[:, None]
    s = (breaks[:-1, None] + half * (1 + points)).ravel()
    return s, (half * weights).ravel(), mode_values(s, mode_range, n, tip=tip)


@pytest.mark.parametrize("power", [0, 1])
def test_projections(power: int) -> None:
    """Over flank and tip: products, logarithm and sign, by other rules."""
    span, tip, n = (0.0, 3.0), Tip(3.7, power, 0.9), 5
    s, weight, values = modes_by_gauss(span, tip, n)
    np.testing.assert_allclose(
        mode_products(span, n, tip), values.T @ (weight[:, None] * values), atol=1e-12
    )
    # mode 0 is 1 on both: int ln|s - s'| ds' and int sign(s - s') ds' are closed forms
    total = tip.end_mm - span[0]
    ends = np.stack([s - span[0], tip.end_mm - s])
    expected = values.T @ (weight * (ends * np.log(ends) - ends).sum(axis=0))
    np.testing.assert_allclose(
        projected_near_field(n, 3.0, tip=tip)[:, 0], expected, rtol=0, atol=1e-11
    )
    sign = values.T @ (weight * (2 * (s - span[0]) - total))
    np.testing.assert_allclose(projected_sign(n, 3.0, tip=tip)[:, 0], sign, rtol=0, atol=1e-12)
    near = projected_near_field(n, 3.0, wedge=(0.4, 0.0), tip=tip)
    # int ln(d + d') dd' by mode 0
    ends = np.stack([s - span[0] + total, s - span[0]])
    image = ends * np.log(ends) - ends
    expected += 0.4 * (values.T @ (weight * (image[0] - image[1])))
    np.testing.assert_allclose(near[:, 0], expected, rtol=0, atol=1e-11)
    np.testing.assert_allclose(near, near.T, rtol=0, atol=1e-14)


@pytest.mark.parametrize("power", [0, 1])
def test_coefficients_give_a_mode_back(power: int) -> None:
    span, tip, n = (1.0, 9.0), Tip(9.4, power, 0.9), 6
    products = mode_products(span, n, tip)
    np.testing.assert_allclose(
        to_coefficients(products, span, tip=tip), np.eye(n), rtol=0, atol=1e-12
    )


def test_modes_go_on_steadily_over_a_rounding() -> None:
    """A step in the displacement would be one in the pressure."""
    span, tip = (1.0, 9.0), Tip(9.4, 1, 0.9)
    below, above = (mode_values(np.array([9.0 + d]), span, 7, tip=tip)[0] for d in (-1e-9, 1e-9))
    np.testing.assert_allclose(above, below, rtol=0, atol=1e-7)


def test_fewer_modes_are_those_of_a_smaller_job() -> None:
    """The tip keeps its own; the load of the flank's highest mode goes to the others."""
    body = made({"tip_radius_mm": 0.2 * MODULE})
    more, fewer = (
        flank_compliance(body, JobOptions(n_modes=n, plane="strain", friction=True), sectors=1)
        for n in (6, 4)
    )
    left = more.fewer_modes(2)
    assert left.modes.tip == fewer.modes.tip
    for name in ("smooth", "tangential"):
        one, other = getattr(left, name), getattr(fewer, name)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-8 * np.abs(other).max())
    # the coefficients of a load, and its integrals with the modes
    span, tip, onto = more.modes.range_mm, more.modes.tip, more.onto_lower_modes(2)
    all_of, own = (mode_values(np.array([2.0]), span, with_tip(n), tip=tip)[0] for n in (6, 4))
    expected = np.zeros(all_of.size)
    expected[np.r_[:4, 6 : 2 + own.size]] = to_coefficients(own, span, tip=tip)
    close = partial(np.testing.assert_allclose, rtol=0, atol=SOLVER * np.abs(expected).max())
    close(onto @ to_coefficients(all_of, span, tip=tip), expected)
    products = mode_products(span, all_of.size, tip)
    close(np.linalg.solve(products, onto.T @ all_of), expected)


def test_far_from_the_tip_its_modes_change_nothing() -> None:
    """Loads along the flank and displacements of coast flanks included; elements as long."""
    body = made({"tip_radius_mm": 0.1 * MODULE})

    def job() -> BodyCompliance:
        keys = {"n_modes": 6, "plane": "strain", "friction": True, "along": True}
        return flank_compliance(body, JobOptions(coast_flanks=True, **keys))

    found = job()
    with mock.patch.object(Body, "tip", None):
        without = job()
    low, high = body.mode_range_mm
    s = low + np.array([0.3, 0.6, 0.9]) * (high - low)

    def values(compliance: BodyCompliance) -> np.ndarray:
        count = compliance.smooth.shape[1]
        return mode_values(s, compliance.modes.range_mm, count, tip=compliance.modes.tip)

    for name in ("smooth", "tangential", "along", "coast.normal", "coast.tangential"):
        one, other = (
            modes @ attrgetter(name)(compliance)[:2] @ modes.T
            for compliance, modes in ((found, values(found)), (without, values(without)))
        )
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-3 * np.abs(other).max())
