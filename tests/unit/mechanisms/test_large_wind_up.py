"""Bodies that deform too far for a theory of small deformations: the result says so."""

from __future__ import annotations

import re

import pytest

import flankload as fl
from flankload.mechanisms.flank_pair.notes import SMALL_WIND_UP
from tests.support.cam_scenes import cam_scene
from tests.support.gear_scenes import changed

#: Torque over tangent stiffness is a lower bound of the wind-up: contacts get stiffer as the torque
#: grows, and more pairs carry.
STIFFENING = 0.25
COARSE = {"flank_element_mm": 2.0, "estimate": False, "tangents": False}


def gears(softer: float, torque_Nm: float) -> fl.Result:
    bodies = {f"body_{z}__young_modulus_MPa": 206000.0 / softer for z in (1, 2)}
    return one_result(
        changed(**bodies, load__torque_Nm=torque_Nm, positions__count=4, accuracy=COARSE)
    )


def one_result(tables: dict) -> fl.Result:
    """Also far beyond the limit at which scenes are refused (test_premises.py)."""
    found = fl.solve(fl.Scene.from_dict({**tables, "effects": {"beyond_limits": True}}))
    assert isinstance(found, fl.Result)
    return found


def part_said(result: fl.Result) -> float | None:
    """Part of a pitch, or of a radian, that the warning names."""
    said = [note for note in result.warnings if note.startswith("the torque turns body 1 by")]
    if not said:
        return None
    assert f"expected at most {SMALL_WIND_UP:g}: " in said[0]
    assert "reduce the torque, or use stiffer bodies" in said[0]
    found = re.match(r"the torque turns body 1 by at least ([\d.]+) of a (pitch|radian)", said[0])
    assert found is not None
    return float(found[1])


@pytest.mark.parametrize("softer", [1.0, 3.0, 20.0])
def test_gears_that_turn_too_far_say_so(softer: float) -> None:
    result, unloaded = gears(softer, 302.0), gears(softer, 0.0)
    part = float((result.rotation_rad - unloaded.rotation_rad).max()) / result.pitch_rad
    said = part_said(result)
    assert (said is not None) == (part > SMALL_WIND_UP)
    if said is not None:
        assert (1 - STIFFENING) * part < said <= part
    assert part_said(unloaded) is None


def test_a_follower_turns_by_parts_of_a_radian() -> None:
    """Its pitch is a turn of the cam, of which no arm can bend by a part."""
    tables = cam_scene(accuracy=COARSE)
    assert part_said(one_result(tables)) is None
    tables["body_1"]["young_modulus_MPa"] = 1000.0
    result = one_result(tables)
    said = part_said(result)
    assert said is not None
    assert said <= float(result.rotation_rad.max())
