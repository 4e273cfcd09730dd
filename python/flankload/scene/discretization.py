"""How fine the elements, pressure modes and contact cells of a scene are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flankload.scene import Scene


@dataclass(frozen=True)
class Grid:
    """How fine the cells of the contact are.

    Attributes
    ----------
    strips_per_half_width : float
        Cells on the Hertz half-width of each contact.
    corner_strips_per_half_width : float
        The same where a sharp corner lies inside the contact's cells.
    zone_half_widths : float
        Half-width of the cells' zone in Hertz half-widths; widened by the core where needed.
    """

    strips_per_half_width: float = 10.0
    corner_strips_per_half_width: float = 30.0
    zone_half_widths: float = 2.5

    def coarser(self) -> Grid:
        """Half as many cells on the half-width."""
        return replace(
            self,
            strips_per_half_width=self.strips_per_half_width / 2,
            corner_strips_per_half_width=self.corner_strips_per_half_width / 2,
        )


@dataclass(frozen=True)
class Discretization:
    """How fine a run is.

    Attributes
    ----------
    flank_element_parts : float
        Length of the flank elements in modules (parametric bodies).
    modes : int
        Pressure modes of a flank.
    grid : Grid
        Cells of the contact.
    """

    flank_element_parts: float
    modes: int
    grid: Grid


#: The knobs of a scene that names none. Measured on the FZG type C pair (module 4.5) against 0.2
#: mm, 9 modes, 40 and 120 strips; largest error of the rotation at interior / tip-corner positions,
#: of the load share there, of the peak pressure: 0.03 / 0.22 %, 0.25 points, 0.10 %.
DEFAULT = Discretization(1.0 / 4.5, 5, Grid())

#: Part of the scene's tolerance that positions may use up: solving a few more costs little.
POSITIONS_PART = 0.3


def choose_discretization(scene: Scene) -> Discretization:
    """Knobs for a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Discretization
        What [accuracy] names; the rest by default.
    """
    accuracy, grid = scene.accuracy, DEFAULT.grid
    return Discretization(
        flank_element_parts=DEFAULT.flank_element_parts,
        modes=accuracy.modes or DEFAULT.modes,
        grid=Grid(
            accuracy.strips_per_half_width or grid.strips_per_half_width,
            accuracy.corner_strips_per_half_width or grid.corner_strips_per_half_width,
            accuracy.zone_half_widths or grid.zone_half_widths,
        ),
    )


def elements_for_modes(modes: int) -> int:
    """Elements along a flank that bear so many pressure modes.

    Polynomials of degree n change within 1/n² of the flank at its ends. Measured on a spline
    whose tips are rounded: so many leave 1 to 2.3 % of the peak pressure with 5 to 12 modes; with
    12 modes as many as twice the degree leave 11 %, and 11 elements 38 %.

    Parameters
    ----------
    modes : int

    Returns
    -------
    int
    """
    degree = modes - 1
    return max(2 * degree, degree**2 // 2)


def position_tolerance(scene: Scene) -> float:
    """What adaptive positions may leave in doubt of harmonics and peak to peak, as part of them."""
    return scene.positions.tolerance or POSITIONS_PART * scene.accuracy.tolerance
