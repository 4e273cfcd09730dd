"""Scenes of helical and spur planetary stages with coarse bodies in three dimensions."""

from math import cos, radians
from typing import Any

import flankload as fl
from tests.support.planetary_stages import four
from tests.support.solving import solve

#: A position at which all contact lines end within involutes: statics are exact.
EXACT = {"angles_deg": [5.4]}
HANDS = {1: ("right", "left"), -1: ("left", "right")}


def wide(helix_deg: float = 15.0, hand: int = 1, **changes: Any) -> dict[str, Any]:
    """Keys of three planets in turn, without contact on tips; other tables by name."""
    module = 3.0 / cos(radians(helix_deg))
    of_sun, of_mates = (
        {"helix_angle_deg": helix_deg, "hand": name} if helix_deg else {} for name in HANDS[hand]
    )
    outside = {"root_diameter_mm": 7.5, "outer_diameter_mm": 27.0}
    scene = four(
        body_1={"tip_diameter_mm": 25 * module + 5.4, **of_sun},
        planet={"tip_diameter_mm": 17 * module + 5.4, **of_mates},
        body_2={
            "tip_diameter_mm": 59 * module - 4.2,
            **{name: 59 * module + more for name, more in outside.items()},
            **of_mates,
        },
        stage={"planets": 3},
        pair={"center_distance_mm": 21 * module},
        load={"torque_Nm": 450},
        positions={"count": None, **EXACT},
        effects={"dimension": 3, "tip_contact": False},
        accuracy={
            "slices": 5,
            "axial_degree": 6,
            "load_degree_z": 2,
            "modes": 3,
            "flank_element_mm": 2.0,
        },
    )
    return {
        name: {**keys, **changes.pop(name, {})} if isinstance(keys, dict) else keys
        for name, keys in scene.items()
    } | changes


def stage(*arguments: Any, **changes: Any) -> Any:
    """Result of such a scene."""
    return solve(fl.Scene.from_dict(wide(*arguments, **changes)))
