"""Slices of the common face width: angles of the teeth and metal removed in each of them."""

from __future__ import annotations

from math import pi, radians, tan

import numpy as np
import pytest

import flankload as fl
from flankload.bodies.axial_shape import AxialShape, LeadModifications
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.expansion import expanded_slices
from flankload.pairing.slices import gap_by_misalignment, slices_of
from tests.support.gear_scenes import changed
from tests.support.tolerances import ROUND_OFF

WIDE = {"module_mm": 3, "helix_angle_deg": 20, "bore_diameter_mm": 30, "kind": "gear"}
PAIR = {
    "name": "helical",
    "body_1": {**WIDE, "teeth": 25, "hand": "right", "tip_diameter_mm": 85.5},
    "body_2": {**WIDE, "teeth": 60, "hand": "left", "tip_diameter_mm": 197.0},
    "pair": {"center_distance_mm": 136.0, "face_width_mm": 60},
    "load": {"torque_Nm": 250},
}


@pytest.mark.parametrize(
    ("lead", "expected"),
    [
        (LeadModifications(crowning_mm=0.008), [0.008, 0.0, 0.008]),
        (LeadModifications(slope_mm=0.01), [0.0, 0.005, 0.01]),
        (LeadModifications(slope_mm=-0.01), [0.01, 0.005, 0.0]),
        (
            LeadModifications(end_relief_mm=(0.02, 0.01), end_relief_length_mm=(8.0, 4.0)),
            [0.02, 0.0, 0.01],
        ),
        (
            LeadModifications(
                end_relief_mm=(0.02, 0.0), end_relief_length_mm=(20.0, 4.0), end_relief_exponent=2
            ),
            [0.02, 0.005, 0.0],
        ),
    ],
)
def test_metal_is_missing_where_the_key_says(
    lead: LeadModifications, expected: list[float]
) -> None:
    shape = AxialShape((-5.0, 15.0), lead=lead)
    np.testing.assert_allclose(shape.gap_mm(np.array([-5.0, 5.0, 15.0])), expected, atol=1e-15)


def test_slices_cover_the_common_width() -> None:
    one, two = AxialShape((-7.0, 7.0), 0.01), AxialShape((-5.0, 9.0), -0.004)
    slices = slices_of((one, two), 6)
    assert slices.width_mm.sum() == pytest.approx(12.0)
    assert slices.z_mm[[0, -1]] == pytest.approx([-4.0, 6.0])
    np.testing.assert_allclose(slices.turns_rad[0], 0.01 * slices.z_mm)
    np.testing.assert_allclose(slices.turns_rad[1], -0.004 * slices.z_mm)
    angles = slices.site_angles(np.array([0.5, 1.5]), 0)
    np.testing.assert_allclose(
        angles.reshape(2, -1), [[a + 0.01 * z for z in slices.z_mm] for a in (0.5, 1.5)]
    )


def test_slices_are_compared_with_their_halves_or_with_pairs_of_them() -> None:
    """Crownings are parabolas, so that the mean of both halves is that of the whole slice."""
    one = AxialShape((-7.0, 7.0), 0.01, LeadModifications(crowning_mm=0.008))
    two = AxialShape((-5.0, 9.0), -0.004, LeadModifications(slope_mm=0.01))
    few, many = (slices_of((one, two), count, (0.002, 0.002)) for count in (4, 57))
    halves, pairs = few.compared(), many.compared()
    np.testing.assert_array_equal(halves.edges_mm[::2], few.edges_mm)
    np.testing.assert_array_equal(pairs.edges_mm, many.edges_mm[[*range(0, 57, 2), 57]])
    for fine, wide in ((halves, few), (many, pairs)):
        for name in ("removed_mm", "turns_rad"):
            for values, mean in zip(getattr(fine, name), getattr(wide, name), strict=True):
                both = values[: values.size // 2 * 2].reshape(-1, 2).mean(axis=1)
                np.testing.assert_allclose(both, mean[: both.size], rtol=0, atol=ROUND_OFF)
    pair = build_bodies(fl.Scene.from_dict(PAIR))
    expanded = expanded_slices(pair.slices, pair.bodies, (1e-3, 2e-3))
    for values, mean in zip(expanded.compared().turns_rad, expanded.turns_rad, strict=True):
        np.testing.assert_allclose(values.reshape(-1, 2).mean(axis=1), mean, rtol=0, atol=ROUND_OFF)


def test_misalignment_opens_the_gap_along_the_axis() -> None:
    angle = radians(20)
    per_mm = gap_by_misalignment(2.0, 0.0, angle)
    assert per_mm == pytest.approx(0.002 * np.sin(angle))
    assert gap_by_misalignment(0.0, 2.0, angle) == pytest.approx(0.002 * np.cos(angle))
    shape = AxialShape((-7.0, 7.0))
    removed = slices_of((shape, shape), 4, (per_mm, per_mm)).removed_mm
    assert not removed[0].any()
    assert (np.diff(removed[1]) > 0).all()


def test_twist_of_both_bodies_keeps_the_flanks_conjugate() -> None:
    """A slice of a helical pair is the plane pair at another position."""
    pair = build_bodies(fl.Scene.from_dict(PAIR))
    one, two = pair.slices.turns_rad
    np.testing.assert_allclose(two, -one * pair.pairing.ratio, rtol=1e-12)
    twist = tan(radians(20)) / (0.5 * 25 * 3 / np.cos(radians(20)))
    assert pair.body_1.axial.twist_rad_per_mm == pytest.approx(twist)
    assert one[-1] > 0 > two[-1]


def test_sites_include_all_pairs_of_all_slices() -> None:
    """60 mm at 20 degrees: an overlap of more than two pitches."""
    helical = build_bodies(fl.Scene.from_dict(PAIR)).pairing.sites
    plane = {**PAIR, "effects": {"dimension": 3}}
    for body in ("body_1", "body_2"):
        plane[body] = {**PAIR[body], "helix_angle_deg": 0}  # type: ignore[dict-item]
        del plane[body]["hand"]  # type: ignore[attr-defined]
    plane["pair"] = {"center_distance_mm": 128.0, "face_width_mm": 60}
    plane["body_1"]["tip_diameter_mm"] = 81.0  # type: ignore[index]
    plane["body_2"]["tip_diameter_mm"] = 186.0  # type: ignore[index]
    spur = build_bodies(fl.Scene.from_dict(plane)).pairing.sites
    overlap = 60 * np.sin(radians(20)) / (pi * 3)
    assert helical.size - spur.size >= int(overlap)
    assert helical[0] < spur[0]
    assert helical[-1] > spur[-1]


def test_a_plane_scene_is_one_slice_of_the_face_width() -> None:
    pair = build_bodies(fl.Scene.from_dict(changed()))
    assert pair.slices.plane
    assert pair.slices.z_mm.tolist() == [0.0]
    assert pair.face_width_mm == pair.slices.compliance_width_mm == 14.0
    assert pair.body_1.axial.plane
