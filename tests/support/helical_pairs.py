"""The FZG type C section as coarse pairs of any helix angle, with kinks or roundings."""

from __future__ import annotations

import json
from functools import cache
from math import atan, cos, degrees, radians, tan
from typing import Any

import flankload as fl
from tests.support.gear_pair import ONE, TWO
from tests.support.solving import solve

COARSE = {
    "flank_element_mm": 3.0,
    "modes": 3,
    "axial_degree": 5,
    "load_degree_z": 1,
    "slices": 7,
    "estimate": False,
    "tangents": False,
}
FEW_CELLS = {"strips_per_half_width": 3, "corner_strips_per_half_width": 4}
RING = {
    "kind": "ring",
    "teeth": 50,
    "module_mm": 4.5,
    "profile_shift": 0.2,
    "tip_diameter_mm": 219.15,
    "root_diameter_mm": 238.05,
    "outer_diameter_mm": 270.0,
}
#: Start of linear reliefs.
KINK_DIAMETERS_MM = {"pinion": 78.0, "gear": 115.0, "ring": 222.0}


def helical(body: dict[str, Any], angle_deg: float, hand: str) -> dict[str, Any]:
    """The same transverse section with a helix."""
    part = cos(radians(angle_deg))
    turned = {
        "module_mm": body["module_mm"] * part,
        "pressure_angle_deg": degrees(atan(tan(radians(20.0)) * part)),
        "profile_shift": body["profile_shift"] / part,
        "helix_angle_deg": angle_deg,
        "hand": hand,
    }
    if body["kind"] == "gear":
        turned["dedendum_factor"] = 1.25 / part
    return {**body, **turned}


def _shape(name: str, member: str) -> dict[str, float]:
    """Keys of a shape: "kinks" has a linear relief and a sharp tip, "round" a rounded tip."""
    if name == "round":
        return {"tip_radius_mm": 0.5}
    return {"tip_relief_um": 30.0, "tip_relief_start_diameter_mm": KINK_DIAMETERS_MM[member]}


def helical_pair(
    mate: str, angle_deg: float, *, shapes: tuple[str, str], contact: str, **effects: Any
) -> fl.Scene:
    """The pinion with a "gear" or a "ring", each of a shape, at eight positions."""
    inside = mate == "ring"
    one = {**ONE, "profile_shift": 0.2, "tip_diameter_mm": 81.0} if inside else ONE
    one, two = (
        one | _shape(shapes[0], "pinion"),
        (RING if inside else TWO) | _shape(shapes[1], mate),
    )
    return fl.Scene.from_dict(
        {
            "body_1": helical(one, angle_deg, "right"),
            "body_2": helical(two, angle_deg, "right" if inside else "left"),
            "pair": {"center_distance_mm": 76.41 if inside else 91.5, "face_width_mm": 14},
            "load": {"torque_Nm": 302},
            "positions": {"count": 8},
            "effects": {"contact": contact, **effects},
            "accuracy": COARSE | (FEW_CELLS if contact == "pairs" else {}),
        }
    )


def solved_helical(mate: str, angle_deg: float, **keys: Any) -> fl.Result:
    """Its result, solved once."""
    return _solved(mate, angle_deg, json.dumps(keys, sort_keys=True))


@cache
def _solved(mate: str, angle_deg: float, keys: str) -> fl.Result:
    found = solve(helical_pair(mate, angle_deg, **json.loads(keys)))
    assert isinstance(found, fl.Result)
    return found
