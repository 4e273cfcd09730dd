"""Phases of planetary stages from tooth numbers and angles."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from flankload.mechanisms.scene_bodies import bodies_of
from flankload.pairing.stage import orbit_orders, stage_pairing, surviving_order
from flankload.scene.discretization import DEFAULT
from tests.support.planetary_stages import scene_of
from tests.support.stage_paths import StagePaths
from tests.support.tolerances import ROUND_OFF

NAMES = ("body_1", "planet", "body_2")
POSITIONS = np.linspace(0.0, 2 * pi / 25, 6, endpoint=False)


@pytest.fixture(scope="module")
def bodies():
    return bodies_of(scene_of(), DEFAULT, NAMES)


def pairing(bodies, places, first=0.0):
    return stage_pairing(bodies, places, first, 63.0, POSITIONS)


def apart(one, two):
    """Largest difference of angles modulo a turn."""
    return np.abs((np.asarray(one) - two + pi) % (2 * pi) - pi).max()


def test_levers_are_those_of_the_lines_of_action(bodies):
    stage = pairing(bodies, (0, 20, 42, 65), first=0.3)
    ends = stage.meshes[0], stage.meshes[-1]
    alpha = tuple(mesh.pairing.gear_geometry.pressure_angle_rad for mesh in ends)
    radii = tuple(body.base_radius_mm for body in bodies)
    paths = StagePaths(stage.angles_rad, alpha, radii)
    rows = stage.rows(radii)[:, :, [2, 0, 1]]
    scale = 1e3 * ROUND_OFF
    np.testing.assert_allclose(rows[:, 0], paths.sun_rows, rtol=0, atol=scale)
    np.testing.assert_allclose(rows[:, -1], paths.ring_rows, rtol=0, atol=scale)
    # planets turn clockwise there
    clockwise = rows[:, 1:-1] * [-1.0, 1.0, 1.0]
    np.testing.assert_allclose(clockwise, paths.planet_rows, rtol=0, atol=scale)


@pytest.mark.parametrize("places", [(0, 21, 42, 63), (0, 28, 56), (0, 20, 42, 65), (0, 1, 2)])
def test_all_meshes_have_the_same_bodies(bodies, places):
    """Frame of sun and ring from every planet, of each planet from both its meshes."""
    stage = pairing(bodies, places, first=0.3)
    angles = stage.body_angles(POSITIONS)
    sun, planets, ring = angles[:, 0], angles[:, 1:-1], angles[:, -1]
    for mesh in stage.meshes:
        turns, sites = mesh.turns(POSITIONS), mesh.pairing
        for z, name in enumerate(mesh.names):
            teeth = bodies[NAMES.index(name)].teeth
            middle = 0.0
            if mesh.sense < 0:
                middle = bodies[NAMES.index(name)].involute.turn_rad
            flank = turns[:, z, None] + sites.site_angles_rad[z] + 2 * middle
            tooth = mesh.frame_rad + mesh.sense * flank - 2 * pi * sites.site_teeth[z] / teeth
            whole = {"body_1": sun, "body_2": ring}.get(name, planets[:, mesh.planet])
            # a mirrored flank is that of the same tooth
            offset = 0.0 if mesh.sense > 0 else 2 * middle - 2 * middle
            assert apart(tooth + offset, whole[:, None]) < ROUND_OFF * 100


def test_phases_follow_from_tooth_numbers(bodies):
    stage = pairing(bodies, (0, 21, 42, 63))
    np.testing.assert_array_equal(stage.sun_phases, [0.0, -0.25, 0.5, 0.25])
    shifted = (stage.ring_phases - stage.ring_phases[0] - stage.sun_phases + 0.5) % 1.0 - 0.5
    np.testing.assert_allclose(shifted, 0.0, atol=ROUND_OFF)
    assert stage.equally_spaced
    assert not pairing(bodies, (0, 20, 42, 62)).equally_spaced


def test_surviving_orders():
    assert [surviving_order(n, 25) for n in (3, 4, 5, 6)] == [3, 4, 1, 6]
    assert surviving_order(4, 18) == 2
    assert orbit_orders(4, 25, 7) == (1, -3, 5, -7)
    assert orbit_orders(5, 25, 9) == ()
    assert orbit_orders(3, 20, 5) == (-1, 2, -4, 5)


def test_pitch_errors_belong_to_the_teeth_of_the_whole_body(bodies):
    """The tooth of the sun that meets planet 1 at a position has met planet 2 before."""
    errors = tuple(float(k) for k in range(25))
    sun = replace(bodies[0], pitch_errors_um=errors)
    stage = pairing((sun, *bodies[1:]), (0, 28, 56))
    plain = pairing(bodies, (0, 28, 56))
    for mesh, even in zip(stage.meshes[:3], plain.meshes[:3], strict=True):
        turned = mesh.pairing.site_angles_rad[0] - even.pairing.site_angles_rad[0]
        expected = np.array(errors)[-mesh.pairing.site_teeth[0] % 25] / 1000.0
        np.testing.assert_allclose(turned * sun.base_radius_mm, expected, atol=1e-12)
