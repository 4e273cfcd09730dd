"""Metal removed from a flank as a function of its height and width: twist, measured topography.

Each point is rotated about the axis by the metal removed there over the base radius. The modified
flank then deviates by that amount along the base tangent, as in a profile diagram, and tip and root
circles are unchanged.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.files import path_of
from flankload.base.number_text import number_of
from flankload.errors import SceneError
from flankload.flank import FlankCurve, Spline, interpolating_spline, turned_along
from flankload.scene.refusal import refuse
from flankload.scene.table import LARGEST_DEVIATION, USUAL_MODIFICATION
from flankload.scene.usual import Usual, question

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.scene.axial import AxialKeys

#: Largest distance of the end of a grid from that of the flank, mm, for rounded numbers in files.
GRID_TOLERANCE_MM = 1e-3
#: Number of points on the flank from which arc lengths at diameters are interpolated.
SAMPLES = 4001
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
        """Metal removed (n, m) at all rows, in sections at distances z (n,) from that end, mm."""
        z = np.clip(z_mm, self.z_mm[0], self.z_mm[-1])
        k = np.clip(np.searchsorted(self.z_mm, z) - 1, 0, self.z_mm.size - 2)
        part = (z - self.z_mm[k]) / (self.z_mm[k + 1] - self.z_mm[k])
        values = self.removed_mm.T
        return np.asarray(values[k] + part[:, None] * (values[k + 1] - values[k]))


@dataclass(frozen=True)
class FlankSurface:
    """Metal removed as a function of the place on a flank, in the direction of the base tangent.

    Attributes
    ----------
    range_mm : (float, float)
        Arc lengths at the ends of the active flank.
    twist_mm : float
        Half of it is removed at the root at the end of smaller z and at the tip at the other end,
        half is added at the two other corners.
    topography : Topography or None
        Measured deviations.
    """

    range_mm: tuple[float, float]
    twist_mm: float = 0.0
    topography: Topography | None = None

    @property
    def places_mm(self) -> Floats:
        """(m,) Arc lengths of the known metal removed, ascending; a spline interpolates it."""
        return np.array(self.range_mm) if self.topography is None else self.topography.s_mm

    def at(self, zeta: Floats, width_mm: float) -> Floats:
        """Metal removed (n, m) at all places of n sections, mm; negative where metal is added.

        `zeta` (n,): relative axial positions, 0 at the end of smaller z, 1 at the other.
        """
        low, high = self.range_mm
        xi = (self.places_mm - low) / (high - low)
        removed = 0.5 * self.twist_mm * np.multiply.outer(2.0 * zeta - 1.0, 2.0 * xi - 1.0)
        if self.topography is not None:
            removed += self.topography.at(zeta * width_mm)
        return np.asarray(removed)

    @property
    def notes(self) -> tuple[str, ...]:
        """A question about a topography of unusual size."""
        if self.topography is None:
            return ()
        most_um = 1000.0 * float(np.abs(self.topography.removed_mm).max())
        asked = question(float(f"{most_um:.12g}"), Usual(*USUAL_MODIFICATION, "um"))
        return () if asked is None else (f"topography_file: at most {most_um:g} um, {asked}",)

    @property
    def most_added_mm(self) -> float:
        """Upper bound of the metal added, mm."""
        most = 0.5 * abs(self.twist_mm)
        if self.topography is not None:
            most += max(0.0, -float(self.topography.removed_mm.min()))
        return most


def flank_surface(
    keys: AxialKeys, key: str, body: Body, *, folder: Path, width_mm: float
) -> FlankSurface | None:
    """Twist and topography from the keys of a body; None without these keys.

    Paths are relative to the folder; the width is that of the body.

    Raises
    ------
    SceneError
        If the file is missing or faulty, or does not cover the flank.
    """
    if not keys.profile_twist_um and keys.topography_file is None:
        return None
    grid = None
    if keys.topography_file is not None:
        path, name = folder / path_of(keys.topography_file), f"{key}.topography_file"
        grid = read_topography(path, name, body.curve, body.mode_range_mm, width_mm)
    return FlankSurface(body.mode_range_mm, (keys.profile_twist_um or 0.0) / 1000.0, grid)


def section_curves(body: Body, removed_mm: Floats) -> list[FlankCurve]:
    """Flanks of a body in n sections, with the same breaks; `removed_mm`: metal removed (n, m)."""
    surface = body.axial.surface
    assert surface is not None
    radius = body.base_radius_mm or abs(body.normal_lever_mm)
    ends = (body.curve.breaks[0], *surface.range_mm, body.curve.length_mm)
    turns = -body.outward * removed_mm / radius
    splines = [interpolating_spline(surface.places_mm, turn[:, None]) for turn in turns]
    knots = np.append(surface.places_mm, surface.range_mm)
    return [turned_along(body.curve, partial(_faded, spline, ends), knots) for spline in splines]


def _faded(
    spline: Spline, ends: tuple[float, float, float, float], s: Floats
) -> tuple[Floats, Floats, Floats]:
    """Values of a spline and two derivatives, continued beyond the active flank.

    Over root fillet and tip rounding, a quintic reduces the slope to 0 without a jump of the
    curvature.
    """
    low, high = ends[1], ends[2]
    inside = np.clip(s, low, high)
    value, first, second = (f[:, 0] for f in spline.derivatives(inside))
    for end, far, side in ((low, ends[0], s < low), (high, ends[3], s > high)):
        if not side.any():
            continue
        h = far - end
        x = (s[side] - end) / h
        at_end, slope, bend = (float(f[0, 0]) for f in spline.derivatives(np.array([end])))
        slope, bend = h * slope, h**2 * bend
        # value, slope and bend of the spline at x = 0; the same value and no slope at x = 1
        c = np.array([0.0, slope, 0.5 * bend, *_fading(slope, bend)])
        polynomial = np.polynomial.Polynomial(c)
        value[side] = at_end + polynomial(x)
        first[side] = polynomial.deriv(1)(x) / h
        second[side] = polynomial.deriv(2)(x) / h**2
    return value, first, second


def _fading(slope: float, bend: float) -> tuple[float, float, float]:
    """Coefficients of x^3 to x^5: slope x + bend x^2/2 + ... is 0 at 1, with two derivatives."""
    return -6.0 * slope - 1.5 * bend, 8.0 * slope + 1.5 * bend, -3.0 * slope - 0.5 * bend


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
    s = np.linspace(*range_mm, SAMPLES)
    at = 2.0 * np.hypot(*curve.point(s).T)
    _check_cover(diameters, (at.min(), at.max()), key, path.name, ON_FLANK)
    _check_cover(z, (0.0, width_mm), key, path.name, ON_WIDTH)
    if at[0] > at[-1]:
        # teeth that point inwards: diameters descend from root to tip
        at, diameters, removed_um = -at, -diameters[::-1], removed_um[::-1]
    # rows beyond the active flank only affect the spline: their distance is extrapolated
    beyond = np.clip(diameters, at[0], at[-1]) - diameters
    rate = np.gradient(at, s)
    places = np.interp(diameters, at, s)
    places -= np.where(beyond > 0.0, beyond / rate[0], beyond / rate[-1])
    return Topography(places, z, removed_um / 1000.0)


def _check_cover(
    values: Floats, ends: tuple[float, float], key: str, name: str, wanted: str
) -> None:
    """Refuse a grid that ends inside the flank."""
    if values[0] > ends[0] + GRID_TOLERANCE_MM or values[-1] < ends[1] - GRID_TOLERANCE_MM:
        refuse(key, wanted.format(*ends), f"{values[0]:g} to {values[-1]:g} in {name}")


def _read_grid(path: Path, key: str) -> tuple[Floats, Floats, Floats]:
    """Diameters (m,), distances along z (k,) and metal removed (m, k) in um."""
    from flankload.meshes.io.named_arrays import csv_rows

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
        row = [number_of(cell) for cell in cells]
    except ValueError:
        return None
    return row if all(abs(value) <= LARGEST_DEVIATION for value in row) else None
