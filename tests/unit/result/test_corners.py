"""Sharp corners in contact: the warning names the corner, the body and the remedy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.gear_pair import ONE, TWO
from tests.support.gear_scenes import changed
from tests.support.helical_pairs import helical_pair, solved_helical
from tests.support.paths import SCENES
from tests.support.solving import solve

COARSE = {"flank_element_mm": 2.0, "estimate": False, "tangents": False}
ROUND = {"tip_radius_mm": 0.5}
RELIEF = {"tip_relief_um": 20, "tip_relief_start_diameter_mm": 80.0, **ROUND}
CHAMFER = {"tip_chamfer_mm": 0.3}


def corners(one: dict[str, Any], two: dict[str, Any], **effects: Any) -> list[str]:
    """Warnings of corners of the FZG type C pair, of which both are without undercut."""
    found = solve(
        fl.Scene.from_dict(
            {
                "body_1": {**ONE, **one},
                "body_2": {**TWO, **two},
                "pair": {"center_distance_mm": 91.5, "face_width_mm": 14},
                "load": {"torque_Nm": 302},
                "accuracy": COARSE,
                "effects": effects,
            }
        )
    )
    assert isinstance(found, fl.Result)
    said = [line for line in found.warnings if "no finite peak pressure exists" in line]
    assert bool(said) == bool(found.corner_contact.any())
    return said


@pytest.mark.parametrize("contact", ["pairs", "lumped"])
def test_with_a_rounded_tip_the_kink_of_the_relief_is_the_corner(contact: str) -> None:
    """Regression: the warning named a sharp tip corner and recommended a tip radius."""
    (said,) = corners(RELIEF, ROUND, contact=contact)
    assert "body_1 touches with the kink where its tip relief begins" in said
    assert said.endswith('body_1.tip_relief_shape = "parabolic" avoids it')
    assert corners({**RELIEF, "tip_relief_shape": "parabolic"}, ROUND, contact=contact) == []


def test_each_body_and_kind_of_corner_is_said_once() -> None:
    one, two = corners({}, CHAMFER)
    assert "body_1 touches with its sharp tip corner" in one
    assert one.endswith("body_1.tip_radius_mm rounds it")
    assert "body_2 touches with the edge between flank and chamfer" in two
    assert two.endswith("body_2.tip_radius_mm instead of body_2.tip_chamfer_mm avoids it")
    assert corners(ROUND, ROUND) == []


def test_undercut_is_named() -> None:
    """16 teeth without profile shift are undercut."""
    found = solve(
        fl.Scene.from_dict(
            changed(body_1__tip_radius_mm=0.5, body_2__tip_radius_mm=0.5, accuracy=COARSE)
        )
    )
    assert isinstance(found, fl.Result)
    (one, two) = [line for line in found.warnings if "undercut" in line]
    assert one.endswith("a larger body_1.profile_shift avoids undercut")
    assert two.endswith("a larger body_2.profile_shift avoids undercut")


def test_meshes_name_no_key_that_they_do_not_have() -> None:
    found = solve(fl.read_scene(SCENES / "external_gear_mesh.toml"))
    assert isinstance(found, fl.Result)
    said = [line for line in found.warnings if "no finite peak pressure exists" in line]
    assert len(said) == 2
    assert all("touches with a sharp corner of its flank" in line for line in said)
    assert all(line.endswith("a rounding there avoids it") for line in said)


def test_each_slice_names_its_corner() -> None:
    """Regression: a flank with a kink in one slice and a tip in another named the one of the
    slice with the larger pressure."""
    keys: dict[str, Any] = {"shapes": ("kinks", "kinks"), "contact": "lumped"}
    found = solved_helical("ring", 40.0, **keys)
    curve = build_bodies(helical_pair("ring", 40.0, **keys)).body_2.curve
    at = curve.breaks[curve.labels.index("relief")]
    kinked = sum(
        bool(
            (np.abs(table.arc_length_2_mm - at) < 0.4 * table.cell_mm * 4 / np.pi)[
                table.force_N > 0
            ].any()
        )
        for table in found.pair_tables
    )
    assert kinked == 7
    said = [line for line in found.warnings if "body_2 touches with the kink" in line]
    assert said
    assert said[0].startswith("at 7 of 8 positions")
