"""Stiffness tables as functions of angle and torque, for multibody programs."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.result.stiffness_table import StiffnessTable


def checked_table(table: StiffnessTable) -> StiffnessTable:
    """The table with ascending torques, as a function that is periodic in the angle and finite.

    Raises
    ------
    SceneError
        If the angles do not cover a period, a torque occurs twice, or has no stiffness.
    """
    if not table.closed:
        covered = f"{np.ptp(table.angle_rad):.6g} of {table.period_rad:.6g} rad"
        raise SceneError(
            key="positions",
            expected="angles over a whole period, since the table repeats after it",
            found=covered,
        )
    order = np.argsort(table.torques_Nm, kind="stable")
    torque = table.torques_Nm[order]
    if (np.diff(torque) <= 0).any():
        raise SceneError(key="load.torque_Nm", expected="different torques", found=torque.tolist())
    stiffness = table.values["stiffness_tangent_Nm_per_rad"][:, order]
    usable = (stiffness > 0).all(axis=0) & np.isfinite(stiffness).all(axis=0)
    if not usable.all():
        raise SceneError(
            key="load.torque_Nm",
            expected="torques with a tangent stiffness at every position",
            found=f"{torque[~usable][0]:g}, which has none (accuracy.tangents computes them)",
        )
    values = {key: numbers[:, order] for key, numbers in table.values.items()}
    return replace(table, name=" ".join(table.name.split()), torques_Nm=torque, values=values)


def modelica_text(table: StiffnessTable) -> str:
    """Text file for the tables of the Modelica Standard Library, of a checked table.

    For each quantity `NAME`, angles in rows, (N + 1, T + 1) with the torques in the first row, for
    CombiTable2Ds; and `NAME_1d`, (N, T + 1) with a column per torque, for CombiTable1Ds. The first
    column is the angle of body 1 in rad.
    """
    torques = ", ".join(f"{torque:.12g}" for torque in table.torques_Nm)
    lines = [
        "#1",
        f"# {table.name}",
        f"# first column: angle of body 1, rad; it repeats after {table.period_rad!r} rad",
        f"# torques on body 1, N m: {torques}",
        f"# reference_radius_mm {table.reference_radius_mm!r}",
    ]
    for name, quantity in {
        "rotation_rad": table.rotation_rad,
        "transmission_error_um": table.values["transmission_error_um"],
        "stiffness_Nm_per_rad": table.values["stiffness_tangent_Nm_per_rad"],
    }.items():
        values = np.column_stack([table.angle_rad, quantity])
        head = np.append(0.0, table.torques_Nm)
        for title, rows in ((name, np.vstack([head, values])), (f"{name}_1d", values)):
            lines.append(f"double {title}({rows.shape[0]},{rows.shape[1]})")
            lines += [" ".join(map(repr, row)) for row in rows.tolist()]
    return "\n".join(lines) + "\n"
