"""The table used by these examples: FZG type C pair, three torques."""

from pathlib import Path

import flankload as fl
from flankload.result import StiffnessTable

SCENE = Path(__file__).parents[1] / "scenes" / "external_gear.toml"
TORQUES_NM = [150.0, 302.0, 450.0]


def solved_table() -> StiffnessTable:
    """Transmission error and stiffness over angle and torque."""
    scene = fl.read_scene(SCENE).replace({"load.torque_Nm": TORQUES_NM})
    return fl.solve(scene).stiffness_table()
