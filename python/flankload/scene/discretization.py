"""The discretization of a scene: finite elements, pressure modes and contact cells."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flankload.scene.axial import three_dimensional_key
from flankload.scene.steps import REDUCED_CELLS

if TYPE_CHECKING:
    from flankload.scene import Scene


@dataclass(frozen=True)
class Grid:
    """Discretization of the contact zones into cells.

    Attributes
    ----------
    strips_per_half_width : float
        Cells per Hertz half-width of each contact.
    corner_strips_per_half_width : float
        The same for a contact zone that contains a sharp corner.
    zone_half_widths : float
        Half-width of the zone of cells, in Hertz half-widths; the core widens it where needed.
    """

    strips_per_half_width: float = 10.0
    corner_strips_per_half_width: float = 30.0
    zone_half_widths: float = 2.5

    def coarser(self) -> Grid:
        """Cells of the reduced sweeps of an error estimate."""
        return replace(
            self,
            strips_per_half_width=REDUCED_CELLS * self.strips_per_half_width,
            corner_strips_per_half_width=REDUCED_CELLS * self.corner_strips_per_half_width,
        )


@dataclass(frozen=True)
class Discretization:
    """Discretization of a run.

    Attributes
    ----------
    flank_element_parts : float
        Length of the flank elements in modules (parametric bodies).
    modes : int
        Pressure modes per flank.
    grid : Grid
        Cells of the contact zones.
    """

    flank_element_parts: float
    modes: int
    grid: Grid


#: Default discretization. Largest errors on the FZG type C pair (module 4.5 mm), against 0.2 mm, 9
#: modes, 40 and 120 cells: rotation 0.03 % at interior and 0.22 % at tip-corner positions, load
#: share 0.25 percentage points there, peak pressure 0.10 %.
DEFAULT = Discretization(1.0 / 4.5, 5, Grid())

#: Cells in slices (three dimensions). The zones are short, since lumped contact gives the forces of
#: all slices in advance; the core adds three cells to each half-width at least. With 10 cells, or
#: with 18 at sharp corners, the rotation of a spur and of a helical pair changes by 0.004 %.
IN_SLICES = Grid(6.0, 9.0, 1.5)

#: Default tolerance of adaptive positions over that of the scene; more positions cost little.
POSITION_TOLERANCE_FACTOR = 0.3


def choose_discretization(scene: Scene) -> Discretization:
    """Discretization of a scene: values of [accuracy], or their defaults."""
    accuracy, grid = scene.accuracy, default_grid(scene)
    return Discretization(
        flank_element_parts=DEFAULT.flank_element_parts,
        modes=accuracy.modes or DEFAULT.modes,
        grid=Grid(
            accuracy.strips_per_half_width or grid.strips_per_half_width,
            accuracy.corner_strips_per_half_width or grid.corner_strips_per_half_width,
            accuracy.zone_half_widths or grid.zone_half_widths,
        ),
    )


def default_grid(scene: Scene) -> Grid:
    """Default cells of a scene: fewer in slices."""
    return DEFAULT.grid if three_dimensional_key(scene) is None else IN_SLICES


def elements_for_modes(modes: int) -> int:
    """Number of elements along a flank that resolve a number of pressure modes.

    Polynomials of degree n vary within 1/n² of the flank at its ends. On a spline with rounded
    tips, the error of the peak pressure is 1 to 2.3 % for 5 to 12 modes; with 12 modes it is 11 %
    for twice the degree, and 38 % for 11 elements.
    """
    degree = modes - 1
    return max(2 * degree, degree**2 // 2)


def position_tolerance(scene: Scene) -> float:
    """Relative sampling error of harmonics and peak to peak allowed for adaptive positions."""
    return scene.positions.tolerance or POSITION_TOLERANCE_FACTOR * scene.accuracy.tolerance
