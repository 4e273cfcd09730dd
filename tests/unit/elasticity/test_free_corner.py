"""Free corners: their angles, the strength of the mirror images behind them, their projection."""

from __future__ import annotations

import tomllib
from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

import flankload as fl
from flankload.bodies.body import Body
from flankload.bodies.free_corner import corner_angles, image_strength, image_strengths
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.near_field import (
    mode_norms,
    projected_image,
    projected_logarithm,
    projected_near_field,
)
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.cam_scenes import FLAT_FOLLOWER, cam_scene
from tests.support.paths import SCENES
from tests.support.tolerances import ROUND_OFF, SOLVER

SCENE = tomllib.loads((SCENES / "external_gear.toml").read_text("utf-8"))
#: Degrees that elements along a flank leave of an angle between two curves.
ON_ELEMENTS = 0.05
#: The same beside a root fillet, which bends much within an element.
ON_FILLET = 2.0


def body_of(**keys: Any) -> Body:
    tree = deepcopy(SCENE)
    tree["body_1"] |= keys
    return build_bodies(fl.Scene.from_dict(tree)).body_1


@pytest.mark.parametrize(
    ("angle", "psi"),
    [(180.0, 0.0), (150.0, 0.04), (125.0, 0.32), (121.0, 0.41), (115.0, 0.59), (90.0, 2.36)],
)
def test_strength_of_the_image(angle: float, psi: float) -> None:
    assert image_strength(angle) == pytest.approx(psi, abs=0.006)


def test_strength_falls_to_nothing_towards_a_smooth_surface() -> None:
    strengths = [image_strength(angle) for angle in np.linspace(60.0, 200.0, 141)]
    assert (np.diff(strengths) <= 0).all()
    assert strengths[-1] == 0.0
    assert 0.0 < image_strength(174.9) < 2e-4


@pytest.mark.parametrize("angle", [75.0, 90.0, 121.0, 150.0])
def test_strength_is_that_of_a_wedge_in_balance(angle: float) -> None:
    """Radial stress (a cos t + b sin t)/r about the bisector holds a unit force at the apex.

    Its strain moves the flank by the work of the force at the motion of the apex: ln r times
    (a sin w/2 + b cos w/2)/E', which the half-plane's own, 2/(pi E'), is compared with.
    """
    half = 0.5 * np.radians(angle)
    force = np.array([np.sin(half), np.cos(half)])  # normal to the flank: along and across
    balance = np.array(
        [
            [quad(lambda t: np.cos(t) ** 2, -half, half)[0], 0.0],
            [0.0, quad(lambda t: np.sin(t) ** 2, -half, half)[0]],
        ]
    )
    stress = np.linalg.solve(balance, force)
    moved = stress @ force
    assert image_strength(angle) == pytest.approx(0.5 * np.pi * moved - 1.0, rel=1e-12)


@pytest.mark.parametrize(("a", "b"), [(0, 0), (0, 1), (2, 1), (3, 3)])
@pytest.mark.parametrize("at_high_end", [False, True])
def test_projected_image_agrees_with_quadrature(a: int, b: int, *, at_high_end: bool) -> None:
    length = 3.0
    one, two = (np.polynomial.legendre.Legendre.basis(k, [0, length]) for k in (a, b))

    def values(s: float, t: float) -> float:
        away = 2 * length - s - t if at_high_end else s + t
        return float(one(s) * two(t) * np.log(away))

    found, _ = dblquad(values, 0.0, length, 0.0, length, epsabs=1e-7)
    projected = projected_image(5, length, at_high_end=at_high_end)
    assert projected[a, b] == pytest.approx(found, abs=1e-5)
    np.testing.assert_array_equal(projected, projected.T)


def test_unit_of_length_changes_only_the_constant_mode() -> None:
    ratio, length, wedge = 25.4, 2.0, (0.3, 0.5)
    scaled = projected_near_field(5, ratio * length, wedge=wedge) / ratio**2
    expected = projected_near_field(5, length, wedge=wedge)
    expected[0, 0] += (1 + sum(wedge)) * np.log(ratio) * length**2
    np.testing.assert_allclose(scaled, expected, rtol=0, atol=1e-12)


def test_without_corners_the_near_field_is_the_logarithm() -> None:
    np.testing.assert_array_equal(projected_near_field(6, 2.5), projected_logarithm(6, 2.5))


@pytest.mark.parametrize("psi", [0.05, 0.6, 3.0])
def test_images_take_up_work(psi: float) -> None:
    """For loads without a resultant, -ln(d + d') is positive definite with any strength."""
    near = -psi * projected_image(20, 1.0, at_high_end=True)[1:, 1:]
    scale = 1 / np.sqrt(mode_norms((0.0, 1.0), 20)[1:])
    eigenvalues = np.linalg.eigvalsh(near * scale[:, None] * scale[None, :])
    assert eigenvalues.min() > -ROUND_OFF * eigenvalues.max()


@pytest.mark.parametrize("element", [1.0, 0.3])
def test_angle_of_a_sharp_tip_is_that_of_its_profile(element: float) -> None:
    tree = deepcopy(SCENE) | {"accuracy": {"flank_element_mm": element}}
    pair = build_bodies(fl.Scene.from_dict(tree))
    for body in (pair.body_1, pair.body_2):
        end = [body.curve.length_mm]
        place, along = (f(end)[0] for f in (body.curve.point, body.curve.tangent))
        radial = np.degrees(np.arccos(along @ place / np.hypot(*place)))
        low, high = corner_angles(body)
        assert high == pytest.approx(90.0 + radial, abs=ON_ELEMENTS)
        assert low == pytest.approx(180.0, abs=ON_FILLET)
        assert image_strengths(body)[0] == 0.0


@pytest.mark.parametrize("tip", [{"tip_radius_mm": 0.36}, {"tip_chamfer_mm": 0.36}])
def test_a_rounded_or_chamfered_tip_has_no_image(tip: dict[str, float]) -> None:
    assert image_strengths(body_of(**tip)) == (0.0, 0.0)


def test_a_rigid_body_has_no_corner() -> None:
    assert corner_angles(body_of(rigid=True)) == (180.0, 180.0)


def test_edge_of_an_undercut_is_a_corner() -> None:
    keys = {"teeth": 12, "profile_shift": -0.1, "tip_diameter_mm": 62.0, "bore_diameter_mm": 20.0}
    scene = fl.Scene.from_dict(SCENE | {"body_1": SCENE["body_1"] | keys})
    body = build_involute_body(scene.body_1, "body_1", flank_element_mm=0.5)
    low = body.mode_range_mm[0]
    before, behind = (body.curve.tangent([low + step])[0] for step in (-1e-6, 1e-6))
    turned = np.degrees(np.arccos(before @ behind))
    assert 5.0 < turned < 40.0
    assert corner_angles(body)[0] == pytest.approx(180.0 - turned, abs=ON_FILLET)
    assert image_strengths(body)[0] > 0.0


def test_a_flat_ends_in_a_right_angle() -> None:
    body = build_bodies(fl.Scene.from_dict(cam_scene(follower=FLAT_FOLLOWER))).body_1
    low, high = corner_angles(body)
    assert high == pytest.approx(90.0, rel=SOLVER)
    assert low >= 180.0 - 1e-9
