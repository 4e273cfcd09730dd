"""Write gear_pair.inc: the stiffness of the teeth over a period, for mbdyn_gear_pair.mbd.

python mbdyn_table.py
mbdyn -f mbdyn_gear_pair.mbd
"""

from pathlib import Path

import numpy as np
from pair_table import TORQUES_NM, solved_table

TORQUE_NM = 302.0
#: Moment of inertia of both gears about axis 1, kg m²: J1 J2/(J2 + J1 (z2/z1)²).
INERTIA = 0.19e-3
SPEED_RAD_PER_S = 1.0
DAMPING = 0.1  # of the critical damping


def include_text() -> str:
    """Content of gear_pair.inc."""
    table = solved_table()
    stiffness = table.values["stiffness_secant_Nm_per_rad"][:, TORQUES_NM.index(TORQUE_NM)]
    damping = 2 * DAMPING * np.sqrt(stiffness.mean() * INERTIA)
    rows = [
        f"    {angle / SPEED_RAD_PER_S!r}, {value!r}"
        for angle, value in zip(table.angle_rad.tolist(), stiffness.tolist(), strict=True)
    ]
    return (
        f"set: const real TORQUE = {TORQUE_NM!r};\n"
        f"set: const real PERIOD = {float(table.period_rad) / SPEED_RAD_PER_S!r};\n"
        f"set: const real INERTIA = {INERTIA!r};\n"
        f"set: const real DAMPING = {float(damping)!r};\n"
        f"drive caller: 1, piecewise linear, {len(rows)},\n" + ",\n".join(rows) + ";\n"
    )


if __name__ == "__main__":
    Path(__file__).with_name("gear_pair.inc").write_text(include_text(), encoding="utf-8")
