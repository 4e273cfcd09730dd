"""Arrangement of a chain around its sprocket at a position: rollers, strands, lever arms.

The sprocket (body 1) turns counter-clockwise, in the sense of its torque; rollers are counted from
the tight strand to the slack one, which is the sense of rotation. Both strands keep their
directions. At position zero roller 0 is aligned with the tight strand and its first link: it has
just arrived and carries no load; it leaves when it is aligned with the slack strand.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import round_down, round_up

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.mechanisms.chain.sprocket import Sprocket

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Wrap:
    """Rollers on their sprocket at one position; n rollers.

    Attributes
    ----------
    first : int
        Number of the roller at the tight end.
    angles_rad : (n,) array
        Angles of the roller pockets, from the place where the tight strand leaves.
    tight, slack : (2,) arrays
        Directions of the strand tensions.
    advance : float
        Pitches by which the tight end has passed the place of its strand.
    """

    sprocket: Sprocket
    first: int
    angles_rad: Floats
    tight: Floats
    slack: Floats
    advance: float

    @property
    def centers(self) -> Floats:
        """(n, 2) Places of the rollers on the pitch circle, mm."""
        return self.sprocket.pitch_radius_mm * _radial(self.angles_rad)

    @property
    def levers_mm(self) -> tuple[float, float]:
        """Lever arms of both strands about the axis."""
        ends = self.centers[[0, -1]]
        one, two = (
            abs(cross(end, way)) for end, way in zip(ends, (self.tight, self.slack), strict=True)
        )
        return float(one), float(two)


def wrap_at(sprocket: Sprocket, wrap_angle_rad: float, position_rad: float) -> Wrap:
    """Rollers on the sprocket at a position.

    Parameters
    ----------
    wrap_angle_rad : float
        Angle between the places where both strands leave.
    position_rad : float
        Rotation of the sprocket.
    """
    beta = sprocket.half_pitch_rad
    pitches = position_rad / (2 * beta)
    # rollers that arrive or leave at this position are omitted
    first = -round_down(pitches)
    last = round_up(wrap_angle_rad / (2 * beta) - pitches)
    # roller k is k pitches behind roller 0, which arrived half a pitch before its strand
    angles = np.asarray(2 * beta * (np.arange(first, last + 1) + pitches) - beta, dtype=np.float64)
    end = wrap_angle_rad
    return Wrap(
        sprocket=sprocket,
        first=first,
        angles_rad=angles,
        tight=np.array([sin(0.0), -cos(0.0)]),
        slack=np.array([-sin(end), cos(end)]),
        advance=float(angles[0] / (2 * beta)),
    )


def cross(a: Floats, b: Floats) -> Floats:
    """Third component of the product of vectors (…, 2)."""
    product: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _radial(angles: Floats) -> Floats:
    return np.column_stack([np.cos(angles), np.sin(angles)])
