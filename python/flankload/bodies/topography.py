"""Measured topography of a flank: a file with the metal removed over diameter and face width."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError
from flankload.meshes.io.named_arrays import csv_rows
from flankload.scene.refusal import refuse
from flankload.scene.table import LARGEST_DEVIATION

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.base.arrays import Floats
    from flankload.flank import FlankCurve


#: Files round: the grid may end by so much inside the flank, mm.
ROUNDED = 1e-3
#: Places on the flank from which arc lengths of diameters are interpolated.
PLACES = 4001
ON_FLANK = "diameters from {:.3f} or less to {:.3f} or more, those of the active flank"
ON_WIDTH = "distances z from {:g} or less to {:g} or more, the face width of the body"
WANTED = (
    "a .csv file: first row distances from the end of smaller z in mm, then rows of a diameter in "
    "mm and the metal removed in um"
)


@dataclass(frozen=True)
class Topography:
    """Metal removed from a flank at the points of a grid.

    Attributes
    ----------
    s_mm : (m,) array
        Arc lengths of the rows, ascending.
    z_mm : (k,) array
        Distances of the columns from the end of smaller z, ascending.
    removed_mm : (m, k) array
        Along the base tangent; negative where metal is added.
    """

    s_mm: Floats
    z_mm: Floats
    removed_mm: Floats

    def at(self, z_mm: Floats) -> Floats:
        """Metal removed (n, m) at all rows of sections at distances (n,) from that end, mm."""
        z = np.clip(z_mm, self.z_mm[0], self.z_mm[-1])
        k = np.clip(np.searchsorted(self.z_mm, z) - 1, 0, self.z_mm.size - 2)
        part = (z - self.z_mm[k]) / (self.z_mm[k + 1] - self.z_mm[k])
        values = self.removed_mm.T
        return np.asarray(values[k] + part[:, None] * (values[k + 1] - values[k]))


def read_topography(
    path: Path, key: str, curve: FlankCurve, range_mm: tuple[float, float], width_mm: float
) -> Topography:
    """Read a topography that covers the active flank, between two arc lengths, and the face width.

    Raises
    ------
    SceneError
        If the file is missing or faulty, or the grid ends inside the flank.
    """
    diameters, z, removed_um = _read_grid(path, key)
    s = np.linspace(*range_mm, PLACES)
    at = 2.0 * np.hypot(*curve.point(s).T)
    _check_cover(diameters, (at[0], at[-1]), key, path.name, ON_FLANK)
    _check_cover(z, (0.0, width_mm), key, path.name, ON_WIDTH)
    # rows beyond the active flank only shape the spline: they keep their distance
    beyond = np.clip(diameters, at[0], at[-1]) - diameters
    rate = np.gradient(at, s)
    places = np.interp(diameters, at, s)
    places -= np.where(beyond > 0.0, beyond / rate[0], beyond / rate[-1])
    return Topography(places, z, removed_um / 1000.0)


def _check_cover(
    values: Floats, ends: tuple[float, float], key: str, name: str, wanted: str
) -> None:
    """Refuse a grid that ends inside the flank."""
    if values[0] > ends[0] + ROUNDED or values[-1] < ends[1] - ROUNDED:
        refuse(key, wanted.format(*ends), f"{values[0]:g} to {values[-1]:g} in {name}")


def _read_grid(path: Path, key: str) -> tuple[Floats, Floats, Floats]:
    """Diameters (m,), distances along z (k,) and metal removed (m, k) in um."""
    rows: list[list[float]] = []
    for line in csv_rows(path, key, WANTED):
        # the first cell of the first row names the first column
        row = _numbers(line.cells[1:] if not rows else line.cells)
        length = len(rows[0]) + 1 if rows else max(2, len(line.cells) - 1)
        if row is None or len(row) != length:
            what = f"a diameter and {length - 1} values" if rows else "a name, then numbers (z)"
            line.refuse(f"{what}, separated by commas")
        rows.append(row)
    if len(rows) < 3:
        raise SceneError(key=key, expected=WANTED, found=f"{len(rows)} rows in {path.name}")
    table = np.array(rows[1:])
    z, diameters, removed = np.array(rows[0]), table[:, 0], table[:, 1:]
    for values, name in ((z, "distances z in the first row"), (diameters, "diameters")):
        k = int(np.argmin(np.diff(values)))
        if values[k + 1] <= values[k]:
            found = f"{values[k + 1]:g} behind {values[k]:g} in {path.name}"
            raise SceneError(key=key, expected=f"ascending {name}", found=found)
    return diameters, z, removed


def _numbers(cells: list[str]) -> list[float] | None:
    """Numbers in the cells of a line; None unless all are finite and not too large."""
    try:
        row = [float(cell) for cell in cells]
    except ValueError:
        return None
    return row if all(abs(value) <= LARGEST_DEVIATION for value in row) else None
