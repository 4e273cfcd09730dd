"""A shaft that bends and twists under the teeth: the beam inside the bore and what is beyond.

The beam fills the bore over its width; its steps and bearings outside of the bore act on the two
ends as condensed stiffnesses. All of it is round.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.bodies.shaft import (
    DECIMALS,
    bearing_stiffness,
    bending_stiffness,
    pushing_stiffness,
    round_section,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.scene import shaft as keys

    Floats = NDArray[np.float64]
    Extent = tuple[float, float]
    #: Axial stiffness; stiffness in a plane of bending: force and moment under displacement and
    #: rotation, as (force/displacement, force/rotation, moment/rotation).
    Springs = tuple[float, float, float, float]


@dataclass(frozen=True)
class CarryingShaft:
    """A round shaft inside the bore of a body, over the width of the bore.

    Attributes
    ----------
    range_mm : (float, float)
        Ends of the bore on the common axis direction z.
    radius_mm, inner_radius_mm : float
        Of the bore; of the bore of the shaft itself, 0 if it is solid.
    stiffness : (float, float, float, float)
        Of the beam in the bore against extension E A (N), bending E I (N mm²), shear k G A (N) and
        twist G I_p (N mm²).
    beyond : two tuples of four floats
        Stiffness of the shaft beyond each end, on the section there, with its bearings: axial
        (N/mm); in a plane of bending force per displacement (N/mm), force per rotation (N), moment
        per rotation (N mm).
    end_radii_mm : (float, float)
        Outer radius of the shaft just beyond each end; 0 if there is none.
    bearings : tuple of (z, radial, axial, tilt)
        Bearings in the bore: mm, N/mm, N/mm, N mm/rad.
    axially_held : bool
        Whether a bearing resists axial forces.
    torque_end : "I", "II" or "even"
        Where the torque enters: the section whose rotation is that of the body; "even": over all
        the width, and the rotation is the mean one.
    """

    range_mm: Extent
    radius_mm: float
    inner_radius_mm: float
    stiffness: tuple[float, float, float, float]
    beyond: tuple[Springs, Springs]
    end_radii_mm: tuple[float, float]
    bearings: tuple[tuple[float, float, float, float], ...]
    axially_held: bool
    torque_end: Literal["I", "II", "even"]


def carrying_shaft(
    table: keys.Shaft, middle_mm: float, range_mm: Extent, bore_diameter_mm: float
) -> CarryingShaft:
    """The shaft that fills a bore.

    Parameters
    ----------
    table : Shaft of the scene
        With `under_teeth = "flexible"`.
    middle_mm : float
        Axial position of the middle of the face width.
    range_mm : (float, float)
        Ends of the bore.
    bore_diameter_mm : float
        At most that of the shaft there: what is outside of it belongs to the body.

    Returns
    -------
    CarryingShaft
    """
    assert table.gear_position_mm is not None
    assert table.bearing_positions_mm is not None
    assert table.torque_end is not None
    shift = middle_mm - table.gear_position_mm
    low, high = (round(end - shift, DECIMALS) for end in range_mm)
    radial, axial, tilt = bearing_stiffness(table)
    modulus = table.young_modulus_MPa
    shear_modulus = modulus / (2.0 * (1.0 + table.poisson_ratio))
    inner = table.bore_diameter_mm or 0.0
    area, moment, sheared = round_section(np.array(bore_diameter_mm), inner, table.poisson_ratio)
    places = np.round(table.bearing_positions_mm, DECIMALS)
    return CarryingShaft(
        range_mm=range_mm,
        radius_mm=0.5 * bore_diameter_mm,
        inner_radius_mm=0.5 * inner,
        stiffness=(
            modulus * float(area),
            modulus * float(moment),
            shear_modulus * float(sheared),
            2.0 * shear_modulus * float(moment),
        ),
        beyond=(_beyond(table, 0.0, low), _beyond(table, _length(table), high)),
        end_radii_mm=(_radius_at(table, low, -1), _radius_at(table, high, 1)),
        bearings=tuple(
            (float(place + shift), float(one), float(two), float(three))
            for place, one, two, three in zip(places, radial, axial, tilt, strict=True)
            if low <= place <= high
        ),
        axially_held=bool(axial.any()),
        torque_end=table.torque_end,
    )


def _length(table: keys.Shaft) -> float:
    """Length of the whole shaft, to the decimals of places."""
    assert table.lengths_mm is not None
    return round(sum(table.lengths_mm), DECIMALS)


def _radius_at(table: keys.Shaft, place: float, side: int) -> float:
    """Outer radius just beyond a place, on the side of smaller (-1) or larger z (1)."""
    assert table.lengths_mm is not None
    assert table.diameters_mm is not None
    ends = np.round(np.cumsum(table.lengths_mm), DECIMALS)
    beyond = place + side * 10.0**-DECIMALS
    if not 0.0 < beyond < ends[-1]:
        return 0.0
    return 0.5 * table.diameters_mm[int(np.searchsorted(ends, beyond))]


def _beyond(table: keys.Shaft, free: float, end: float) -> Springs:
    """Stiffness at `end` of the part of a shaft from there to its free end."""
    assert table.lengths_mm is not None
    assert table.bearing_positions_mm is not None
    low, high = min(free, end), max(free, end)
    steps = np.round(np.concatenate([[0.0], np.cumsum(table.lengths_mm)]), DECIMALS)
    places = np.round(table.bearing_positions_mm, DECIMALS)
    own = (places >= low) & (places <= high) & (places != end)
    if not own.any():
        return 0.0, 0.0, 0.0, 0.0
    radial, axial, tilt = (values[own] for values in bearing_stiffness(table))
    nodes = np.unique(np.concatenate([[low, high], places[own], steps]))
    nodes = nodes[(nodes >= low) & (nodes <= high)]
    bearings = np.searchsorted(nodes, places[own])
    at = int(np.searchsorted(nodes, end))
    bent = _condensed(
        bending_stiffness(table, nodes, bearings, radial, tilt), np.array([2 * at, 2 * at + 1])
    )
    pushed = _condensed(pushing_stiffness(table, nodes, bearings, axial), np.array([at]))
    return float(pushed[0, 0]), float(bent[0, 0]), float(bent[0, 1]), float(bent[1, 1])


def _condensed(stiffness: Floats, kept: NDArray[np.int64]) -> Floats:
    """Stiffness of some unknowns when no load acts on the others; symmetric."""
    rest = np.setdiff1d(np.arange(len(stiffness)), kept)
    scale = 1.0 / np.sqrt(np.diag(stiffness))
    scaled = stiffness * np.outer(scale, scale)
    between = scaled[np.ix_(rest, kept)]
    own = scaled[np.ix_(kept, kept)]
    found = own - between.T @ np.linalg.solve(scaled[np.ix_(rest, rest)], between)
    size = 1.0 / scale[kept]
    return np.asarray(0.5 * (found + found.T) * np.outer(size, size))
