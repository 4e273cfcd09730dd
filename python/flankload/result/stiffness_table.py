"""Mesh stiffness over the period and the torque: a table for multibody programs."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.card import Card
from flankload.base.files import write_atomically
from flankload.errors import SceneError
from flankload.result.export import CsvForm
from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flankload.base.arrays import Floats
    from flankload.result.result import Result

#: Quantities of the table for each torque.
QUANTITIES = (
    "transmission_error_um",
    "stiffness_tangent_Nm_per_rad",
    "stiffness_secant_Nm_per_rad",
    "stiffness_tangent_N_per_um",
    "stiffness_secant_N_per_um",
)


@dataclass(frozen=True, eq=False, repr=False)
class StiffnessTable(Card):
    """Transmission error and stiffness over N angles of body 1 and T torques.

    Attributes
    ----------
    name : str
        Name of the scene.
    angle_rad : (N,) array
        Angle of body 1 from position zero, ascending; in a closed table the last one is the first
        one a period later.
    torques_Nm : (T,) array
    reference_radius_mm, period_rad : float
    closed : bool
        Whether the angles cover a period, after which everything repeats.
    values : dict of (N, T) arrays
        By the names in `QUANTITIES`; NaN if undefined (at torque 0).
    """

    name: str
    angle_rad: Floats
    torques_Nm: Floats
    reference_radius_mm: float
    period_rad: float
    closed: bool
    values: dict[str, Floats]

    @property
    def rotation_rad(self) -> Floats:
        """(N, T) Rotation of body 1 beyond ideal, rigid flanks."""
        return self.values["transmission_error_um"] / (1000.0 * self.reference_radius_mm)

    def to_csv(self, path: str | Path | None = None, form: CsvForm | None = None) -> str:
        """Return the table as CSV; write it to `path`.

        Lines that begin with # describe the table; then follow one line of names and one per angle.
        Columns are `angle_rad`, `angle_deg` and, torque by torque, the quantities with the torque
        in N m after an @. An empty cell is not a number.

        Parameters
        ----------
        path : path, optional
        form : CsvForm, optional
            Separator and decimal sign; angles are in both units in any case.

        Returns
        -------
        str
        """
        form = CsvForm() if form is None else form
        covers = "closed, the last line is the first one a period later" if self.closed else "open"
        name = re.sub(r'[\s,;"]+', " ", self.name)  # else it would begin cells of its own
        head = (
            f"# {name.strip()}\n"
            f"# period_rad {self.period_rad!r} ({covers}), reference_radius_mm "
            f"{self.reference_radius_mm!r}\n"
            "# angle of body 1; per torque on body 1 (N m, after the @): quantity_unit\n"
        )
        names = [f"{key}@{torque:.12g}" for torque in self.torques_Nm for key in QUANTITIES]
        by_torque = np.stack([self.values[key] for key in QUANTITIES], axis=2)
        angles = np.column_stack([self.angle_rad, np.degrees(self.angle_rad)])
        numbers = np.hstack([angles, by_torque.reshape(len(angles), -1)]).tolist()
        rows = [["angle_rad", "angle_deg", *names]]
        rows += [[form.cell(x) for x in row] for row in numbers]
        text = head + form.lines(rows)
        if path is not None:
            write_atomically(path, text)
        return text

    def to_modelica(self, path: str | Path | None = None) -> str:
        """Return the table as `modelica_text`; write it to `path`.

        Raises
        ------
        SceneError
            If the angles do not cover a period, a torque occurs twice, or has no stiffness.
        """
        text = modelica_text(checked_table(self))
        if path is not None:
            write_atomically(path, text)
        return text

    def to_fmu(self, path: str | Path, *, binary: bool | None = None) -> bool:
        """Write the table as a co-simulation FMU (FMI 2.0), which needs no Python.

        Parameters
        ----------
        path : path
        binary : bool, optional
            Whether it contains a compiled library for linux64 beside the C sources; by default if
            this is such a machine with a C compiler.

        Returns
        -------
        bool
            Whether it contains a library.

        Raises
        ------
        SceneError
            As `to_modelica`.
        InputError
            If a library is requested and cannot be compiled.
        """
        from flankload.result.fmu import fmu_of  # imports much

        content, compiled = fmu_of(checked_table(self), binary=binary)
        write_atomically(path, content)
        return compiled


def stiffness_table(results: Sequence[Result]) -> StiffnessTable:
    """Stiffness of one or several torques over the period.

    Parameters
    ----------
    results : sequence of Result
        Results of one scene, at the same positions.

    Returns
    -------
    StiffnessTable

    Raises
    ------
    ValueError
        If the results have different positions.
    """
    first = results[0]
    if any(not np.array_equal(first.position_rad, other.position_rad) for other in results):
        raise ValueError("results at different positions make no table of angle and torque")
    over = over_positions(first)
    closed = over.covers_period or first.stands_alike
    if closed:
        order = np.append(over.index, over.index[0])
        angle = np.append(over.position_rad, over.position_rad[0] + first.period_rad)
    else:
        order = np.argsort(first.position_rad, kind="stable")
        angle = first.position_rad[order]
    return StiffnessTable(
        name=first.name,
        angle_rad=angle,
        torques_Nm=np.array([result.torque_Nm for result in results]),
        reference_radius_mm=first.reference_radius_mm,
        period_rad=first.period_rad,
        closed=closed,
        values={
            key: np.stack([getattr(result, key)[order] for result in results], axis=1)
            for key in QUANTITIES
        },
    )


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
