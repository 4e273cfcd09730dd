"""Vibration of two shafts in ROSS, with the mesh stiffness of flankload in place of a square wave.

flankload run examples/scenes/external_gear.toml --stiffness-csv table.csv
python ross_mesh_stiffness.py table.csv

Needs ross-rotordynamics, in any environment. Prints the dynamic part of the mesh force for a
constant stiffness, a square wave of the same mean and contact ratio, and the table.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import ross as rs

TEETH = (16, 24)
MODULE_M, PRESSURE_ANGLE_DEG, CONTACT_RATIO = 4.5e-3, 20.0, 1.438
SPEED_RAD_PER_S, TORQUE_NM = 150.0, 302.0
#: Largest difference of the mean force from that of statics, relative: its last part is vibration.
BALANCE = 0.01
PERIODS, STEPS_OF_A_PERIOD = 40, 60


def read_table(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Angles of body 1, rad, and the tangent stiffness along the line of action, N/m."""
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    [name] = [name for name in rows[0] if name.startswith("stiffness_tangent_N_per_um@")]
    return (
        np.array([float(row["angle_rad"]) for row in rows]),
        np.array([1e6 * float(row[name]) for row in rows]),
    )


def shaft_with_gear(teeth: int) -> rs.Rotor:
    """A steel shaft on two bearings with the gear in the middle."""
    diameter = teeth * MODULE_M
    mass = 7850.0 * np.pi / 4.0 * diameter**2 * 0.014
    gear = rs.GearElement(
        n=2,
        m=mass,
        Id=mass * diameter**2 / 16.0,
        Ip=mass * diameter**2 / 8.0,
        n_teeth=teeth,
        pitch_diameter=diameter,
        pr_angle=np.radians(PRESSURE_ANGLE_DEG),
    )
    parts = [rs.ShaftElement(L=0.05, idl=0.0, odl=0.03, material=rs.steel) for _ in range(4)]
    bearings = [rs.BearingElement(n=n, kxx=1e8, kyy=1e8, cxx=1e3, cyy=1e3) for n in (0, 4)]
    return rs.Rotor(parts, [gear], bearings)


def mesh_force(stiffness: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Force along the line of action, N, once the start has decayed."""
    mean = float(np.mean(stiffness(np.linspace(0.0, 2.0 * np.pi / TEETH[0], 400))))
    rotors = [shaft_with_gear(teeth) for teeth in TEETH]
    pair = rs.MultiRotor(
        *rotors, coupled_nodes=(2, 2), gear_mesh_stiffness=mean, update_mesh_stiffness=True
    )
    pair.mesh.interpolate_stiffness = stiffness
    period = 2.0 * np.pi / TEETH[0] / SPEED_RAD_PER_S
    time = np.linspace(0.0, PERIODS * period, PERIODS * STEPS_OF_A_PERIOD)
    load = np.zeros((len(time), pair.ndof))
    ramp = np.clip(4.0 * time / time[-1], 0.0, 1.0)
    driving, driven = (
        list(gear.dof_global_index.values())
        for gear in (pair.mesh.driving_gear, pair.mesh.driven_gear)
    )
    # the last degree of freedom of a node is its rotation; the torques are in balance
    load[:, driving[5]] = TORQUE_NM * ramp
    load[:, driven[5]] = -TORQUE_NM * TEETH[1] / TEETH[0] * ramp
    found = pair.run_time_response(SPEED_RAD_PER_S, load, time)
    dofs = [*driving, *driven]
    coupling = pair.coupling_matrix()
    # the coupling matrix is c c^T with the direction c of the line of action
    direction = coupling[:, 5] / np.sqrt(coupling[5, 5])
    force = stiffness(SPEED_RAD_PER_S * time) * (found.yout[:, dofs] @ direction)
    return force[len(force) // 2 :]


def main(path: Path) -> None:
    """A line for each stiffness."""
    angle, table = read_table(path)
    period = 2.0 * np.pi / TEETH[0]
    mean = np.trapezoid(table, angle) / (angle[-1] - angle[0])
    low = float(table.min())
    high = low + (mean - low) / (CONTACT_RATIO - 1.0)
    laws = {
        "constant": lambda at: np.full_like(np.asarray(at, dtype=float), mean),
        "square wave": lambda at: np.where(
            np.mod(at, period) < (CONTACT_RATIO - 1.0) * period, high, low
        ),
        "flankload": lambda at: np.interp(np.mod(at, period), angle, table),
    }
    for name, law in laws.items():
        force = mesh_force(law)
        part = (force.max() - force.min()) / force.mean()
        base_radius_m = 0.5 * MODULE_M * TEETH[0] * np.cos(np.radians(PRESSURE_ANGLE_DEG))
        if abs(force.mean() * base_radius_m / TORQUE_NM - 1.0) > BALANCE:
            raise SystemExit(f"{name}: mean force {force.mean():.0f} N does not carry the torque")
        print(f"{name:12} mean force {force.mean():9.1f} N, peak to peak {100 * part:6.2f} % of it")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
