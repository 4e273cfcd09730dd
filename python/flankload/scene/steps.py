"""Steps of the discretization, from coarse to fine: the one table of all coarser and finer runs.

The plan of a run, the choice of effects, the first run of tolerance control, its refinements, the
steps of an accuracy study and the reduced sweeps of an error estimate take their values from here.
"""

from __future__ import annotations

from dataclasses import dataclass

#: Parameters by the names of `NamedDiscretization`.
ELEMENTS, MODES, STRIPS, ZONE = (
    *("flank_element_mm", "modes"),
    *("strips_per_half_width", "zone_half_widths"),
)
#: The same in three dimensions: degrees along the axis of the pressure modes and of the
#: displacements, which follows from it, and slices.
LOAD_DEGREE, DEGREE, SLICES = "load_degree_z", "axial_degree", "slices"
#: Positions per pitch.
COUNT = "count"


@dataclass(frozen=True)
class Steps:
    """Steps of a parameter; lengths of elements and numbers of positions relative to the default.

    Attributes
    ----------
    coarse : float
        Value of the coarse discretization.
    study : tuple of float
        Steps of an accuracy study, coarse first.
    refined : tuple of float
        Steps of tolerance control, coarse first; it begins with the first one.
    order : float
        Order of the error in the parameter; 0 if it is not refined by itself.
    """

    coarse: float
    study: tuple[float, ...]
    refined: tuple[float, ...] = ()
    order: float = 0.0


def _halved(most: float, least: float, per_half: int) -> tuple[float, ...]:
    """Values from `most` to `least`, in equal ratios, with a number of steps to a half."""
    found = [most]
    while found[-1] > least * 2.0 ** (0.5 / per_half):
        found.append(most * 2.0 ** (-len(found) / per_half))
    return tuple(found)


#: Largest changes of the sizes of effects by the coarse values, beside runs at the default: 3 % of
#: the size of the ten effects of `test_plan.py`; 0.6 % of the rotation of three-dimensional gears.
#: Error orders. Elements: second order in displacements. Modes: energy of loads beside a tip, where
#: the compliance increases logarithmically. Cells: pressure is linear on each; even numbers, since
#: cells of odd ones change places beside the middle of a contact in a comparison with half as many.
STEPS = {
    ELEMENTS: Steps(8.0, _halved(2.0, 0.125, 1), _halved(2.0, 0.125, 4), 2.0),
    MODES: Steps(3, (3, 4, 5, 6, 8, 12), tuple(range(3, 13)), -3.0),
    STRIPS: Steps(2.5, (2.5, 5, 10, 20, 40), (8, 10, 14, 20, 28, 40, 56, 80), -2.0),
    ZONE: Steps(2.5, (1.2, 1.5, 2.0, 2.5, 3.0, 4.0)),
    LOAD_DEGREE: Steps(2, (0, 2, 4, 6, 8), (5, 6, 8, 10, 12), -2.0),
    DEGREE: Steps(6, (4, 6, 8, 10, 12)),
    SLICES: Steps(14, (7, 14, 28, 56), (40, 56, 80, 112, 160), -1.5),
    COUNT: Steps(0.25, (0.25, 0.5, 1.0, 2.0, 4.0)),
}
#: Cells in slices are fewer.
STRIPS_IN_SLICES = (3.0, 6.0, 12.0, 24.0)
#: Reduced sweeps of an error estimate, beside the values of the run, whatever these are: part of
#: its cells per half-width; omitted pressure modes, whose terms alternate in size, so that in some
#: places one of two vanishes; omitted degrees along the axis. For slices: `Slices.compared`.
REDUCED_CELLS, REDUCED_MODES, REDUCED_DEGREES = 0.5, 2, 2
