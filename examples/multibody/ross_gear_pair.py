"""Natural frequencies of two geared rotors in ROSS, with the stiffness of the teeth from flankload.

ROSS couples two rotors by one stiffness along the line of action. The mean stiffness over the
period gives mean frequencies; the least and the largest one bound the frequencies that occur.

    pip install ross-rotordynamics "plotly<6"  # run with 2.3
    python ross_gear_pair.py
"""

import numpy as np
import ross as rs
from pair_table import TORQUES_NM, solved_table

TORQUE_NM = 302.0
FREQUENCIES = 16
#: Frequencies that are printed.
SHOWN = 3


def rotors(stiffness_N_per_m: float) -> rs.MultiRotor:
    """Two steel shafts of 30 and 40 mm on two bearings each, a gear in the middle of each."""
    found = []
    for teeth, shaft_m, base_m in ((16, 0.030, 0.06766), (24, 0.040, 0.10149)):
        shaft = [rs.ShaftElement(L=0.05, idl=0.0, odl=shaft_m, material=rs.steel) for _ in range(4)]
        mass = 7810 * 0.014 * np.pi / 4 * (base_m**2 - shaft_m**2)
        polar = mass / 8 * (base_m**2 + shaft_m**2)
        gear = rs.GearElement(
            n=2, m=mass, Id=polar / 2, Ip=polar, n_teeth=teeth, base_diameter=base_m,
            pr_angle=rs.Q_(20, "deg"),
        )  # fmt: skip
        bearings = [rs.BearingElement(n=n, kxx=2e8, kyy=2e8, cxx=1e3) for n in (0, 4)]
        found.append(rs.Rotor(shaft, [gear], bearings))
    return rs.MultiRotor(*found, coupled_nodes=(2, 2), gear_mesh_stiffness=stiffness_N_per_m)


def frequencies_Hz(stiffness_N_per_m: float) -> np.ndarray:
    """Natural frequencies at rest, ascending, without those of rigid motion."""
    modes = rotors(stiffness_N_per_m).run_modal(speed=0, num_modes=4 * FREQUENCIES)
    found = np.sort(modes.wn) / (2 * np.pi)
    return found[found > 1.0]


def main() -> None:
    """Print the frequencies that depend most on the stiffness of the teeth."""
    table = solved_table()
    column = TORQUES_NM.index(TORQUE_NM)
    stiffness = 1e6 * table.values["stiffness_tangent_N_per_um"][:-1, column]
    values = {"least": stiffness.min(), "mean": stiffness.mean(), "largest": stiffness.max()}
    found = {name: frequencies_Hz(value) for name, value in values.items()}
    change = found["largest"] / found["least"] - 1.0
    most = np.sort(np.argsort(change)[-SHOWN:])
    for name, value in values.items():
        text = " ".join(f"{frequency:8.1f}" for frequency in found[name][most])
        print(f"{name:8} {value / 1e6:6.1f} N/um  {text} Hz")


if __name__ == "__main__":
    main()
