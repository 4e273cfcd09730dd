"""What multibody programs take from a table: rotation and stiffness over angle and torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.result.stiffness_table import StiffnessTable

    Floats = NDArray[np.float64]

#: Names of the tables for Modelica.
TABLES = ("rotation_rad", "transmission_error_um", "stiffness_Nm_per_rad")


@dataclass(frozen=True, eq=False)
class Table:
    """Rotation and tangent stiffness over N angles and T ascending torques, all finite.

    Attributes
    ----------
    name : str
    angle_rad : (N,) array
        Ascending; the last one is the first one a period later.
    torque_Nm : (T,) array
    rotation_rad, stiffness_Nm_per_rad : (N, T) arrays
    period_rad, reference_radius_mm : float
    """

    name: str
    angle_rad: Floats
    torque_Nm: Floats
    rotation_rad: Floats
    stiffness_Nm_per_rad: Floats
    period_rad: float
    reference_radius_mm: float

    @property
    def transmission_error_um(self) -> Floats:
        """(N, T) Rotation times reference radius."""
        return 1000.0 * self.rotation_rad * self.reference_radius_mm


def checked_table(table: StiffnessTable) -> Table:
    """The table as a periodic function of the angle and a function of the torque.

    Parameters
    ----------
    table : StiffnessTable

    Returns
    -------
    Table

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
    return Table(
        name=" ".join(table.name.split()),
        angle_rad=table.angle_rad,
        torque_Nm=torque,
        rotation_rad=table.values["transmission_error_um"][:, order]
        / (1000.0 * table.reference_radius_mm),
        stiffness_Nm_per_rad=stiffness,
        period_rad=table.period_rad,
        reference_radius_mm=table.reference_radius_mm,
    )


def modelica_text(table: Table) -> str:
    """Text file for the tables of the Modelica Standard Library.

    Parameters
    ----------
    table : Table

    Returns
    -------
    str
        For each quantity `NAME`, angles in rows, (N + 1, T + 1) with the torques in the first row,
        for CombiTable2Ds; and `NAME_1d`, (N, T + 1) with a column per torque, for CombiTable1Ds.
        The first column is the angle of body 1 in rad.
    """
    torques = ", ".join(f"{torque:.12g}" for torque in table.torque_Nm)
    lines = [
        "#1",
        f"# {table.name}",
        f"# first column: angle of body 1, rad; it repeats after {table.period_rad!r} rad",
        f"# torques on body 1, N m: {torques}",
        f"# reference_radius_mm {table.reference_radius_mm!r}",
    ]
    for name in TABLES:
        values = np.column_stack([table.angle_rad, getattr(table, name)])
        head = np.append(0.0, table.torque_Nm)
        for title, rows in ((name, np.vstack([head, values])), (f"{name}_1d", values)):
            lines.append(f"double {title}({rows.shape[0]},{rows.shape[1]})")
            lines += [" ".join(map(repr, row)) for row in rows.tolist()]
    return "\n".join(lines) + "\n"
