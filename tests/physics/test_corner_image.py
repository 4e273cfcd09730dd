"""Pressure and contact beside free corners: modes with mirror images against fine elements."""

from __future__ import annotations

import tomllib
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

import flankload as fl
from flankload.bodies.free_corner import image_strengths
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.near_field import (
    consistent_loads,
    logarithm_strength,
    mode_norms,
    mode_values,
    projected_image,
    projected_near_field,
)
from flankload.mechanisms import Earlier, Parts, run_once
from flankload.mechanisms.flank_pair import assembly
from flankload.scene import Gear, Ring
from tests.support.condensed import condense
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF

SCENE = tomllib.loads(
    (Path(__file__).parents[2] / "examples" / "scenes" / "external_gear.toml").read_text("utf-8")
)
#: A band of pressure that ends in the corner, mm, and its elements.
BAND, ELEMENT = 0.1, 0.025
MODES = (4, 5, 6, 8, 12)
GEARS = {
    "pinion": SCENE["body_1"],
    "60 teeth": SCENE["body_1"]
    | {"teeth": 60, "profile_shift": 0.0, "tip_diameter_mm": 279.0, "bore_diameter_mm": 200.0},
}
#: Percent of the band's mean displacement that so many modes leave (measured 0.58, 0.23 …, the
#: largest of both gears and one of 24 teeth), and the least error without the image.
LEFT = {4: 0.9, 5: 0.3, 6: 0.12, 8: 0.05, 12: 0.02}
WITHOUT = {4: 2.0, 5: 1.4, 6: 1.2, 8: 0.6, 12: 0.08}
RING = {
    "teeth": 60,
    "module_mm": 3.0,
    "tip_diameter_mm": 175.2,
    "root_diameter_mm": 187.5,
    "outer_diameter_mm": 220.0,
}
#: Part of the image at the end of the ring's flank that seven further modes contain,
#: on elements of 1/18 module.
BESIDE = 0.15
#: Positions of the FZG type C pair at which a tip corner works, and one pair, two pairs.
CORNERS_DEG, OTHERS_DEG = [5.625, 6.328, 16.172, 16.875], [2.0, 11.25]
#: Those at which the gap is not least at the corner, over which the contact reaches.
REACHES_DEG = [6.328, 16.172]
#: Of the largest rotation, and of the load: the default against 12 modes on fine elements.
PAIR = 1e-3
FINE = {"modes": 12, "flank_element_mm": 0.25}
#: Bodies and elements of solutions whose forces do not turn.
STRAIGHT = Parts()


@cache
def of_band(name: str) -> dict[int, tuple[float, float]]:
    """Error of the mean displacement of the loaded band by modes, with and without image, %."""
    spec = Gear(**{key: value for key, value in GEARS[name].items() if key != "kind"})
    body = build_involute_body(spec, "body_1", flank_element_mm=0.5, flank_nodes_mm=ELEMENT)
    mesh, span = body.mesh, body.mode_range_mm
    assert mesh is not None
    starts = mesh.flank_arc_length[mesh.flank_edges[:, 0]]
    start = starts[np.abs(starts - span[1] + BAND).argmin()]
    most = max(MODES)

    def pressures(s: np.ndarray) -> np.ndarray:
        return np.column_stack([mode_values(s, span, most), s > start])

    loads = consistent_loads(mesh, pressures, count=most + 1, gauss_points=10)
    matrix = stiffness(mesh.nodes, mesh.cells, body.material, "strain")
    found = condense(matrix, loads, mesh, held=True)[0].local
    points, weights = np.polynomial.legendre.leggauss(20)
    width = span[1] - start
    on_modes = 0.5 * width * weights @ mode_values(start + 0.5 * width * (points + 1), span, most)
    strength, psi = logarithm_strength(body.material, "strain"), image_strengths(body)[1]

    def error(modes: int, image: float) -> float:
        near = projected_near_field(modes, span[1] - span[0], wedge=(0.0, image))
        norms = mode_norms(span, modes)
        smooth = (found[0][:modes, :modes] + strength * near) / np.outer(norms, norms)
        moved = on_modes[:modes] @ smooth @ on_modes[:modes]
        # means of ln|s - s'| and of ln(d + d') over the band, times its square
        moved -= strength * width**2 * (np.log(width) - 1.5)
        moved -= strength * image * width**2 * (np.log(4 * width) - 1.5)
        return float(100 * abs(moved / found[0][-1, -1] - 1))

    return {modes: (error(modes, psi), error(modes, 0.0)) for modes in MODES}


@pytest.mark.parametrize("modes", MODES)
@pytest.mark.parametrize("name", GEARS)
def test_band_at_the_tip(name: str, modes: int) -> None:
    with_image, without = of_band(name)[modes]
    assert with_image < LEFT[modes]
    assert without > WITHOUT[modes]


def test_smooth_part_at_the_tip_of_a_ring_does_not_grow_with_the_modes() -> None:
    body = build_involute_body(Ring(**RING), "body_2", flank_element_mm=3.0 / 18)
    fine = flank_compliance(body, JobOptions(n_modes=12, plane="strain"))
    low, high = body.mode_range_mm
    norms = mode_norms((low, high), 12)
    image = fine.near.wedge[1] * projected_image(12, high - low, at_high_end=True)
    added, had = (
        matrix.sum() - matrix[:5, :5].sum()  # all modes are 1 at the end
        for matrix in (fine.smooth[0] / fine.near.kernel, image / np.outer(norms, norms))
    )
    assert abs(had) > 1.0
    assert abs(added) < BESIDE * abs(had)


def solved(
    size: float = 1.0,
    angles: Any = None,
    *,
    turned: bool = True,
    width: float | None = None,
    **accuracy: Any,
) -> fl.Result:
    """The pair, larger by `size` at the same stress; without `turned`, forces keep the direction
    of the flank's normal over a corner, and the elements are those of such solutions alone."""
    tree = deepcopy(SCENE)
    for key in ("body_1", "body_2"):
        lengths = [name for name in tree[key] if name.endswith("_mm")]
        tree[key] |= {name: size * tree[key][name] for name in lengths}
    tree["pair"] = {name: size * value for name, value in tree["pair"].items()}
    tree["load"]["torque_Nm"] *= size**3
    if width is not None:
        tree["load"]["torque_Nm"] *= width / tree["pair"]["face_width_mm"]
        tree["pair"]["face_width_mm"] = width
    tree["positions"] = {"angles_deg": angles or CORNERS_DEG + OTHERS_DEG}
    tree["effects"] = accuracy.pop("effects", {})
    tree["accuracy"] = {"estimate": False, "tangents": False, **accuracy}
    scene = fl.Scene.from_dict(tree)
    if turned:
        found = solve(scene)
        assert isinstance(found, fl.Result)
        return found
    with mock.patch.object(assembly, "forces_turn", return_value=False):
        (found,) = run_once(scene, earlier=Earlier(parts=STRAIGHT))
    return found


@pytest.fixture(scope="module")
def fine() -> fl.Result:
    return solved(**FINE)


@pytest.fixture(scope="module")
def default() -> fl.Result:
    return solved()


def test_positions_are_on_corners(fine: fl.Result) -> None:
    corner = np.asarray(fine.corner_contact).any(axis=1)
    assert corner[: len(CORNERS_DEG)].all()
    assert not corner[len(CORNERS_DEG) :].any()


def test_default_on_corners_is_that_of_twelve_modes(fine: fl.Result, default: fl.Result) -> None:
    """Without the image, the rotation is off by 0.3 % and the share by 0.5 points."""
    largest = fine.rotation_rad.max()
    np.testing.assert_allclose(default.rotation_rad, fine.rotation_rad, rtol=0, atol=PAIR * largest)
    np.testing.assert_allclose(default.load_share, fine.load_share, rtol=0, atol=PAIR)


def test_size_changes_nothing(default: fl.Result) -> None:
    large = solved(size=16.0)
    np.testing.assert_allclose(large.rotation_rad, default.rotation_rad, rtol=1e-6, atol=0)
    np.testing.assert_allclose(large.load_share, default.load_share, rtol=0, atol=1e-6)


def test_lumped_contact_on_corners(default: fl.Result) -> None:
    """A contact that ends in the corner has its image, too: 0.26 % without. Forces turn where the
    gap is least at the corner; where the contact only reaches over it (0.15 to 0.25 %), it does not
    know."""
    lumped = solved(effects={"contact": "lumped"})
    largest = default.rotation_rad.max()
    apart = np.abs(lumped.rotation_rad - default.rotation_rad) / largest
    reaches = np.isin(np.degrees(default.position_rad).round(3), REACHES_DEG)
    assert apart[~reaches].max() < 2.2e-3
    unturned = solved(effects={"contact": "lumped"}, turned=False), solved(turned=False)
    apart = np.abs(unturned[0].rotation_rad - unturned[1].rotation_rad) / largest
    assert apart.max() < 2.2e-3


#: Effect of turning forces on the rotation, by plain elements: forces at nodes 0.0125 mm apart
#: (no modes, no near field, displacements in both directions) on the core's cells, those on a
#: corner and on its mate with their direction, against all with the flank's normal; percent.
TURNED_DEG = [5.0, 5.625, 6.0, 6.328, 16.172, 16.875]
TURNED = np.array([-0.266, -0.574, -0.460, -0.220, -0.147, -0.379])
#: The remaining error of the rotation, in cells, and in lumped contact where the gap is least at
#: the corner.
TURN_LEFT, LUMPED_LEFT = 0.03, 0.08
#: Difference of these changes, of a tenth of them, between the plane and a wide pair.
WIDE_LEFT = 5e-4


@pytest.mark.parametrize("contact", ["pairs", "lumped"])
def test_forces_turn_over_a_sharp_corner_as_on_plain_elements(contact: str) -> None:
    straight = solved(angles=TURNED_DEG, turned=False, effects={"contact": contact})
    turned = solved(angles=TURNED_DEG, effects={"contact": contact})
    change = 100 * (turned.rotation_rad / straight.rotation_rad - 1)
    if contact == "pairs":
        np.testing.assert_allclose(change, TURNED, rtol=0, atol=TURN_LEFT)
        return
    at = ~np.isin(TURNED_DEG, REACHES_DEG)
    np.testing.assert_allclose(change[at], TURNED[at], rtol=0, atol=LUMPED_LEFT)


@pytest.mark.parametrize("contact", ["pairs", "lumped"])
def test_a_wide_pair_turns_as_in_the_plane(contact: str) -> None:
    """Ten modules wide: the ends make it 0.7 % more compliant, whether forces turn or not."""
    wide = {"effects": {"contact": contact, "dimension": 3}, "slices": 7, "width": 140.0}
    angles = TURNED_DEG[1:3]
    changes = []
    for keys in (wide, {"effects": {"contact": contact}}):
        straight = solved(angles=angles, turned=False, **keys)
        changes.append(solved(angles=angles, **keys).rotation_rad / straight.rotation_rad - 1)
    np.testing.assert_allclose(changes[0], changes[1], rtol=0, atol=WIDE_LEFT)


def test_forces_off_corners_do_not_turn() -> None:
    straight = solved(angles=OTHERS_DEG, turned=False)
    found = solved(angles=OTHERS_DEG).rotation_rad
    np.testing.assert_allclose(found, straight.rotation_rad, rtol=ROUND_OFF, atol=0)


#: Effect of friction on the rotation at TURNED_DEG by the same elements with forces along the
#: flank, percent, by friction coefficient; and the remaining error (0.09 and 0.27 without the
#: image of these forces, Eq. (W3)).
RUBBED = {
    0.1: np.array([-0.753, -1.369, -1.847, -1.457, -1.309]),
    0.3: np.array([-2.110, -4.060, -5.570, -4.149, -3.747]),
}
RUBBED_DEG = [5.0, 5.625, 6.328, 16.172, 16.875]
RUBBED_LEFT = {0.1: 0.025, 0.3: 0.05}


@pytest.mark.parametrize("mu", RUBBED)
def test_friction_at_a_corner_has_its_image(mu: float) -> None:
    plain = solved(angles=RUBBED_DEG, turned=False)
    rubbed = solved(angles=RUBBED_DEG, effects={"friction_coefficient": mu}, turned=False)
    change = 100 * (rubbed.rotation_rad / plain.rotation_rad - 1)
    np.testing.assert_allclose(change, RUBBED[mu], rtol=0, atol=RUBBED_LEFT[mu])


def test_tangent_of_lumped_contact_is_its_derivative() -> None:
    """The approach of the image is differentiated like the rest."""
    step = 1e-4
    one, two = (
        solve(
            fl.Scene.from_dict(
                SCENE
                | {
                    "positions": {"angles_deg": CORNERS_DEG},
                    "effects": {"contact": "lumped"},
                    "accuracy": {"estimate": False, "tangents": False},
                    "load": {"torque_Nm": 302.0 * (1 + sign * step)},
                }
            )
        )
        for sign in (-1, 1)
    )
    middle = solved(angles=CORNERS_DEG, effects={"contact": "lumped"})
    by_difference = 2 * step * 302.0 / (two.rotation_rad - one.rotation_rad)
    np.testing.assert_allclose(middle.stiffness_tangent_Nm_per_rad, by_difference, rtol=1e-4)
