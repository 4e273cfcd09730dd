"""Compliance of a prism: symmetry, mirror images, limits, refused bodies, fewer modes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.compliance import BodyCompliance, JobOptions, flank_compliance
from flankload.elasticity.near_field import logarithm_strength, mode_values
from flankload.elasticity.prism import Prism, flank_surface
from flankload.errors import SceneError
from tests.support.plane_sectors import STEEL
from tests.support.ring_bodies import gear, ring
from tests.support.tolerances import ROUND_OFF, SOLVER

BODY = build_involute_body(gear(), "body_1", flank_element_mm=3.0)
COARSE = Prism((-7.0, 7.0), degree=6, load_degree=2, cut_degree=3)
TWIST = float(np.tan(np.radians(15.0)) / 36.0)

#: Of the projected near field on a helix, whose points depend on the number of modes.
QUADRATURE = 1e-5


@cache
def _found(prism: Prism = COARSE, **keys) -> BodyCompliance:
    return flank_compliance(BODY, JobOptions(n_modes=3, prism=replace(prism, **keys)))


def _close(one: np.ndarray, two: np.ndarray, part: float) -> None:
    np.testing.assert_allclose(one, two, rtol=0, atol=part * np.abs(two).max())


@pytest.mark.parametrize("twist", [0.0, TWIST])
def test_it_is_symmetric(twist: float) -> None:
    found = _found(twist=twist)
    assert found.job.asymmetry < ROUND_OFF
    smooth, teeth = found.smooth, BODY.teeth
    _close(smooth, smooth[-np.arange(teeth) % teeth].transpose(0, 2, 1), 1e-15)
    assert smooth.shape == (16, 9, 9)
    assert found.near.kernel == logarithm_strength(STEEL, "strain")
    assert found.modes.axial is not None
    assert (found.modes.axial.range_mm, found.modes.axial.degree, found.modes.axial.count) == (
        (-7.0, 7.0),
        2,
        3,
    )
    assert found.job.counters["fe_factorisations"] == (1 if twist else 2)
    assert found.job.degrees_of_freedom > 3000


def test_spur_flanks_do_not_couple_even_and_odd_modes() -> None:
    found = _found().smooth.reshape(16, 3, 3, 3, 3)
    assert np.abs(found[:, :, 0, :, 1]).max() < ROUND_OFF * np.abs(found).max()
    assert np.abs(_found(twist=TWIST).smooth.reshape(found.shape)[:, :, 0, :, 1]).max() > 0


def test_a_twist_that_vanishes_is_none() -> None:
    straight, hardly = _found(), _found(twist=1e-13)
    _close(hardly.smooth, straight.smooth, SOLVER)
    assert hardly.modes.axial.end == pytest.approx(straight.modes.axial.end)


def test_the_other_hand_is_the_mirror_image() -> None:
    right, left = _found(twist=TWIST), _found(twist=-TWIST)
    parity = np.tile((-1.0) ** np.arange(3), 3)
    _close(left.smooth, right.smooth * np.outer(parity, parity), 1e-12)
    assert left.modes.axial.end == pytest.approx(right.modes.axial.end[::-1])
    # a right hand's working flank leans out of the end at low z
    assert right.modes.axial.end[0] < right.modes.axial.end[1]


@pytest.mark.parametrize("twist", [TWIST, -TWIST])
def test_places_lie_as_far_apart_as_on_the_helicoid(twist: float) -> None:
    surface = flank_surface(BODY, replace(COARSE, twist=twist))
    surface = replace(surface, end=(0.0, 0.0), wedge=(0.0, 0.0))
    generator = np.random.default_rng(11)
    low, high = BODY.mode_range_mm
    s = generator.uniform(low + 0.2, high - 0.2, 20)
    z = generator.uniform(-6.0, 6.0, 20)
    s_near, z_near = (part + generator.uniform(-0.2, 0.2, 20) for part in (s, z))

    def place(s: np.ndarray, z: np.ndarray) -> np.ndarray:
        (x, y), turn = BODY.curve.point(s).T, twist * z
        return np.array(
            [x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), z]
        )

    apart = np.linalg.norm(place(s, z) - place(s_near, z_near), axis=0)
    np.testing.assert_allclose(1 / surface.potential(s, z, s_near, z_near), apart, rtol=1e-4)


def test_its_place_on_the_axis_changes_nothing() -> None:
    _close(_found(range_mm=(3.0, 17.0), twist=TWIST).smooth, _found(twist=TWIST).smooth, 1e-11)


def test_modes_in_z_that_the_elements_cannot_carry_are_refused() -> None:
    with pytest.raises(SceneError) as caught:
        _found(degree=6, load_degree=3)
    assert str(caught.value) == ("load_degree_z: expected 0 to 2 (axial_degree 6 minus 4), found 3")
    with pytest.raises(SceneError, match="face_width_mm: expected above 0, found -2"):
        _found(range_mm=(1.0, -1.0))


ROUNDED = build_involute_body(gear(tip_radius_mm=0.3), "body_1", flank_element_mm=3.0)


@pytest.mark.parametrize("twist", [0.0, TWIST])
def test_a_rounded_tip_has_two_modes_of_its_own(twist: float) -> None:
    right = flank_compliance(ROUNDED, JobOptions(n_modes=3, prism=replace(COARSE, twist=twist)))
    left = flank_compliance(ROUNDED, JobOptions(n_modes=3, prism=replace(COARSE, twist=-twist)))
    assert right.modes.tip == ROUNDED.tip
    assert right.job.asymmetry < ROUND_OFF
    assert right.smooth.shape == (16, 15, 15)
    assert right.flank_modes == 3
    parity = np.tile((-1.0) ** np.arange(3), 5)
    # tables of the directions on the tip
    _close(left.smooth, right.smooth * np.outer(parity, parity), 1e-9)
    # well before the tip the flank is as compliant as a sharp one
    sharp = _found(twist=twist)
    place = 0.5 * sum(BODY.mode_range_mm)
    own = [
        np.einsum("a,ab,b", values, found.smooth[1, ::3, ::3], values)
        for found in (sharp, right)
        for values in mode_values(
            np.array([place]), found.modes.range_mm, found.smooth.shape[1] // 3, tip=found.modes.tip
        )
    ]
    assert own[1] == pytest.approx(own[0], rel=0.01)


def test_fewer_modes_beside_a_tip_keep_those_along_the_axis() -> None:
    found = flank_compliance(ROUNDED, JobOptions(n_modes=3, prism=COARSE))
    fewer = found.fewer_modes()
    assert fewer.smooth.shape == (16, 12, 12)
    by_degree = fewer.smooth.reshape(16, 4, 3, 4, 3)
    assert np.abs(by_degree[:, :, 0, :, 1]).max() < ROUND_OFF * np.abs(by_degree).max()
    assert fewer.fewer_axial_modes().smooth.shape == (16, 4, 4)


def test_a_rigid_body_has_no_compliance() -> None:
    found = flank_compliance(replace(BODY, rigid=True), JobOptions(n_modes=3, prism=COARSE))
    assert found.is_rigid


def test_internal_teeth_are_elastic_as_well() -> None:
    body = build_involute_body(ring(), "body_2", flank_element_mm=1.5)
    found = flank_compliance(body, JobOptions(n_modes=3, prism=Prism((0.0, 20.0), 0.002, 6, 2, 3)))
    assert found.job.asymmetry < ROUND_OFF
    other = flank_compliance(body, JobOptions(n_modes=3, prism=Prism((0.0, 20.0), -0.002, 6, 2, 3)))
    parity = np.tile((-1.0) ** np.arange(3), 3)
    _close(other.smooth, found.smooth * np.outer(parity, parity), 1e-12)


def test_fewer_modes_are_those_of_a_coarser_job() -> None:
    found = _found(twist=TWIST)
    in_s = flank_compliance(BODY, JobOptions(n_modes=2, prism=replace(COARSE, twist=TWIST)))
    _close(found.fewer_modes().smooth, in_s.smooth, QUADRATURE)
    in_z = _found(twist=TWIST, load_degree=0)
    fewer = found.fewer_axial_modes(2)
    _close(fewer.smooth, in_z.smooth, QUADRATURE)
    assert fewer.modes.axial == in_z.modes.axial
    assert in_z.fewer_axial_modes(1) is in_z
