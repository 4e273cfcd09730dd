"""Coast flanks of gears with a width and a helix: symmetries, the plane, equilibrium."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.contact.body_record import records_of
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.compliance.body_compliance import no_compliance
from flankload.elasticity.prism.prism import Prism
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.loaded_bodies import BodyOfPair, field_bodies
from flankload.mechanisms.flank_pair.stages import contact_of
from flankload.pairing.body_pair import BodyPair
from tests.support.body_records import parts_of
from tests.support.pair_scenes import EXTERNAL, solved
from tests.support.ring_bodies import gear_body
from tests.support.solving import solve
from tests.support.three_dimensional import MIRRORED, OTHER_HANDS, SMALL, deviation, tree_of

#: So near that both flanks of a tooth are loaded without torque, mm.
NEARER = {"helical_gear": -0.12, "internal_helical": 0.1}
#: Gaps are those of bodies that have not turned under load yet, by up to 1e-3 rad.
NOT_TURNED = 3e-4
#: Two condensations of one sector.
SECTOR = 1e-12
#: Half-turn about the line of centres: the inclination of the axes changes its sign.
MISALIGNED = {"pair__deviation_um_per_mm": 0.3, "pair__inclination_um_per_mm": 0.2}


def tight(name: str, **changes: Any) -> fl.Scene:
    """A small example with coast flanks that overlap working flanks."""
    keys = {**SMALL, "positions__count": None, "effects__coast_flank": True, **changes}
    tree = tree_of(name, keys)
    tree["pair"]["center_distance_mm"] += NEARER[name]
    return fl.Scene.from_dict(tree)


def result_of(scene: fl.Scene) -> fl.Result:
    found = solve(scene)
    assert isinstance(found, fl.Result)
    return found


def symmetric_position_deg(pair: BodyPair) -> float:
    """Position at which a tooth or a space of body 2 is on the line of centres."""
    two, involute = pair.body_2, pair.body_2.involute
    assert involute is not None
    middle = pair.pairing.turns_at_zero_rad[1] + involute.turn_rad - pi
    half = pi / two.teeth
    return float(np.degrees((middle - round(middle / half) * half) / pair.pairing.ratio))


def over_width(result: fl.Result, *, coast: bool) -> np.ndarray:
    """(J,) Force over the slices, of working or coast flanks."""
    assert result.slices is not None
    assert result.coast is not None
    table = result.coast.pair_tables[0] if coast else result.pairs(0)
    return np.array([table.force_N[np.isclose(table.z_mm, z)].sum() for z in result.slices.z_mm])


# --- compliance -----------------------------------------------------------------------------------


@pytest.mark.parametrize("twist", [0.0, 0.01], ids=["spur", "helical"])
def test_flanks_of_a_prism_are_images_by_half_a_turn(twist: float) -> None:
    """About the middle of a tooth, which exchanges both flanks and both ends; loads on either flank
    are solved alone."""
    body = gear_body(16, 2.5)
    prism = Prism((-5.0, 5.0), twist, degree=5, load_degree=1)
    found = flank_compliance(
        body, JobOptions(n_modes=2, coast_flanks=True, friction=True, prism=prism)
    )
    coast, z = found.coast, len(found.smooth)
    assert coast is not None
    assert found.tangential is not None
    signs, back = found.modes.mirror_signs(found.smooth.shape[1]), -np.arange(z) % z
    for own, blocks in ((found.smooth, coast.normal), (found.tangential, coast.tangential)):
        assert blocks is not None
        for part, image in ((blocks[2 * z :], own), (blocks[z : 2 * z], blocks[:z])):
            wanted = signs[:, None] * image[back] * signs
            assert np.abs(part - wanted).max() < SECTOR * np.abs(own).max()
    # a force pushes the other flank of its tooth out
    assert coast.normal[0, 0, 0] < 0.0 < found.smooth[0, 0, 0]


# --- symmetries of pairs --------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(NEARER))
@pytest.mark.parametrize("contact", ["lumped", "pairs"])
@pytest.mark.parametrize("axes", [{}, MISALIGNED], ids=["parallel", "misaligned"])
def test_half_a_turn_exchanges_working_and_coast_flanks(
    name: str, contact: str, axes: dict[str, float]
) -> None:
    """About the line of centres, without torque: the hand of a helix stays, its ends change places.

    Both sides of the position at which body 2 is symmetric are images of each other.
    """
    keys = {"load__torque_Nm": 0.0, "effects__contact": contact}
    pair = build_bodies(tight(name, **keys, positions__angles_deg=[0.0]))
    middle, other = symmetric_position_deg(pair), dict(axes)
    if axes:
        other["pair__inclination_um_per_mm"] *= -1.0
    here = result_of(tight(name, **keys, **axes, positions__angles_deg=[middle + 1.3]))
    there = result_of(tight(name, **keys, **other, positions__angles_deg=[middle - 1.3]))
    for coast in (False, True):
        one, two = over_width(here, coast=coast), over_width(there, coast=not coast)[::-1]
        assert one.all()
        assert np.abs(one - two).max() < NOT_TURNED * one.max()
        # the loads of one flank are not symmetric by themselves
        assert np.abs(one - one[::-1]).max() > 100 * NOT_TURNED * one.max()


def test_the_mirror_image_of_tight_gears_has_mirrored_loads() -> None:
    keys = {"positions__angles_deg": [2.0], "load__torque_Nm": 60.0}
    one = result_of(tight("helical_gear", **keys))
    two = result_of(tight("helical_gear", **keys, **OTHER_HANDS))
    for coast in (False, True):
        loads = over_width(one, coast=coast)
        assert loads.any()
        assert deviation(loads, over_width(two, coast=coast)[::-1]) < MIRRORED
    assert deviation(one.axial_force_N, -two.axial_force_N) < MIRRORED
    assert deviation(one.rotation_rad, two.rotation_rad) < MIRRORED


# --- the plane ------------------------------------------------------------------------------------


def spur(width_mm: float, dimension: int, torque_Nm: float = 60.0, **effects: Any) -> fl.Result:
    """FZG type C gears with rounded tips, 10 um too near, under a torque per width."""
    bodies = {key: {**EXTERNAL[key], "tip_radius_mm": 0.3} for key in ("body_1", "body_2")}
    sizes = {"flank_element_mm": 3.0, "modes": 3, "estimate": False, "tangents": False}
    if dimension == 3:
        sizes |= {"slices": 6, "load_degree_z": 1, "axial_degree": 5}
        effects |= {"dimension": 3}
    pair = {**EXTERNAL["pair"], "center_distance_mm": 91.49, "face_width_mm": width_mm}
    return solved(
        {**EXTERNAL, **bodies, "pair": pair},
        torque_Nm * width_mm / 14.0,
        count=4,
        effects={"coast_flank": True, "contact": "lumped", **effects},
        accuracy=sizes,
    )


def test_wide_spur_gears_are_those_of_the_plane() -> None:
    """Rotation and forces on both flanks; the difference by free ends falls with the width."""
    plane, apart = spur(14.0, 2), []
    assert plane.coast is not None
    assert (plane.coast.force_N > 0).any(axis=1).all()
    for width_mm in (60.0, 120.0):
        wide = spur(width_mm, 3)
        assert wide.coast is not None
        share = 14.0 / width_mm
        apart.append(
            [
                deviation(wide.rotation_rad, plane.rotation_rad),
                deviation(share * wide.site_force_N, plane.site_force_N),
                deviation(share * wide.coast.force_N, plane.coast.force_N),
                deviation(wide.coast.peak_pressure_MPa, plane.coast.peak_pressure_MPa),
            ]
        )
    assert max(apart[1]) < 0.025
    np.testing.assert_allclose(np.divide(*apart), 2.0, atol=0.35)


def test_backlash_leaves_slices_as_they_are_without_coast_flanks() -> None:
    keys = {**SMALL, "positions__count": 2}
    one, two = (
        result_of(fl.Scene.from_dict(tree_of("helical_gear", {**keys, **more})))
        for more in ({}, {"effects__coast_flank": True})
    )
    assert two.coast is not None
    assert not two.coast.force_N.any()
    for name in ("rotation_rad", "site_force_N", "peak_pressure_MPa"):
        assert deviation(getattr(one, name), getattr(two, name)) < 1e-10


# --- equilibrium ----------------------------------------------------------------------------------


def test_forces_on_both_flanks_balance_the_torque_and_reach_the_nodes() -> None:
    """The pair has friction; its axial force is the difference of those of both flanks."""
    keys = {"positions__angles_deg": [2.0], "load__torque_Nm": 60.0}
    scene = tight("helical_gear", **keys, effects__friction_coefficient=0.1)
    result = result_of(scene)
    body = field_bodies(scene)["body_1"]
    assert isinstance(body, BodyOfPair)
    assert result.coast is not None
    fields = body.at(result, 0)
    total = np.cross(fields.points_mm, fields.force_N).sum(axis=0)[2]
    # pairs are on circles about O1, their forces at the nodes of the flank
    assert total == pytest.approx(-60e3, rel=2e-3)
    assert fields.force_N.sum(axis=0)[2] == pytest.approx(result.axial_force_N[0], rel=1e-3)
    alone = replace(result, coast=None)
    assert abs(np.cross(fields.points_mm, body.at(alone, 0).force_N).sum(axis=0)[2]) > 70e3


def test_errors_of_single_teeth_leave_coast_flanks_where_they_are() -> None:
    keys: dict[str, Any] = {"positions__angles_deg": [0.0], "body_1__lead_crowning_um": 10.0}
    even = _places(tight("helical_gear", **keys))
    teeth = tree_of("helical_gear", {})["body_1"]["teeth"]
    errors = {
        "body_1__pitch_errors_um": [5.0] * teeth,
        "body_1__tooth_helix_slope_um": [10.0] * teeth,
    }
    moved = _places(tight("helical_gear", **keys, **errors))
    for name in ("site_angles", "deviations"):
        (one, coast), (two, also) = (np.split(part[name].ravel(), 2) for part in (even, moved))
        assert (one != two).all()
        np.testing.assert_array_equal(coast, also)
    # crowning is that of both flanks
    assert (np.split(even["deviations"].ravel(), 2)[1] < 0.0).all()


def _places(scene: fl.Scene) -> dict[str, np.ndarray]:
    """Parts of the record of body 1."""
    pair = build_bodies(scene)
    rigid = no_compliance(pair.body_1), no_compliance(pair.body_2)
    return parts_of(records_of(contact_of(scene, pair, rigid))[1])
