"""Angles between flank and end faces, against the surface itself, and their images."""

from __future__ import annotations

import numpy as np
import pytest

from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.prism.flank_surface import edge_angles, end_strength
from flankload.errors import SceneError
from tests.support.ring_bodies import gear

BODY = build_involute_body(gear(), "body_1", flank_element_mm=3.0)


def _twist(helix_deg: float) -> float:
    return float(np.tan(np.radians(helix_deg)) / 36.0)


def _angle_of_the_surface(twist: float) -> float:
    """Interior angle at the high end, degrees, of the surface R(kappa z) P(s) by differences."""

    def place(s: float, z: float) -> np.ndarray:
        x, y = BODY.curve.point([s])[0]
        turn = twist * z
        return np.array(
            [x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), z]
        )

    s, step = 0.5 * sum(BODY.mode_range_mm), 1e-4
    along = place(s + step, 0.0) - place(s - step, 0.0)
    across = place(s, step) - place(s, -step)
    normal = np.cross(along, across)
    if normal[:2] @ BODY.curve.normal([s])[0] < 0:
        normal = -normal
    return 90.0 + float(np.degrees(np.arcsin(normal[2] / np.linalg.norm(normal))))


@pytest.mark.parametrize("helix", [-30.0, -15.0, 0.0, 15.0, 30.0])
def test_edge_is_obtuse_where_the_normal_leans_out_of_the_end(helix: float) -> None:
    low, high = edge_angles(BODY, _twist(helix))
    assert high == pytest.approx(_angle_of_the_surface(_twist(helix)), abs=1e-3)
    assert low + high == pytest.approx(180.0)


def test_strengths_fall_with_the_angle_and_rise_with_poissons_ratio() -> None:
    assert end_strength(90.0, 0.3) == pytest.approx(1.33)
    assert end_strength(66.0, 0.3) == pytest.approx(1.33 * np.exp(0.062 * 24))
    assert end_strength(90.0, 0.0) == pytest.approx(1.33 * 0.94 / 1.30)
    assert end_strength(90.0, 0.25) == pytest.approx(1.33 * (1.13 + 1.30) / 2 / 1.30)


def test_a_sharper_edge_is_refused() -> None:
    edge_angles(BODY, _twist(41.0))
    with pytest.raises(SceneError) as caught:
        edge_angles(BODY, _twist(46.0))
    assert "expected at least 50 degrees between flank and end face, found 4" in str(caught.value)
