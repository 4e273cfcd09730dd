"""A chain on its sprocket at a position: its truss, rollers, strands, planes of the pockets.

Rollers on links are a truss with geometric stiffness. Planes replace the pockets of the rollers:
tangent to the seats, or at the nearest points.

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

from flankload.base.rotation import directions
from flankload.base.rounding import round_down, round_up

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.mechanisms.chain.sprocket import Sprocket

#: Number of fixed planes on the seat arc, and their least distance from that at the nearest point,
#: rad.
ARC_PLANES, LEAST_ANGLE = 5, 0.05


@dataclass(frozen=True)
class Chain:
    """A chain without its sprocket.

    Attributes
    ----------
    pitch_mm : float
        Pitch of the new chain.
    elongation : float
        Relative increase of the length of every link by wear.
    link_stiffness_N : float
        Force divided by strain of a link.
    contact_stiffness_N_per_mm : float
        Stiffness of the contact between roller and pocket, equal in all directions.
    span_mm : float
        Length of the free strands, whose tension stabilises the outer rollers laterally.
    """

    pitch_mm: float
    elongation: float
    link_stiffness_N: float
    contact_stiffness_N_per_mm: float
    span_mm: float

    @property
    def link_mm(self) -> float:
        """Length of a link without tension."""
        return self.pitch_mm * (1 + self.elongation)

    def tensions(self, place: Floats) -> Floats:
        """(n - 1,) Tensions of the links between n rollers at places (n, 2), N."""
        length = np.hypot(*np.diff(place, axis=0).T)
        return self.link_stiffness_N * (length / self.link_mm - 1.0)

    def truss(self, place: Floats, tension: Floats) -> tuple[Floats, Floats]:
        """Stiffness (2n, 2n), N/mm, and forces (2n,), N, of links between n rollers at (n, 2).

        K = EA/l t tᵀ + T/l (1 - t tᵀ) for each link with the direction t. The tensions (n - 1,)
        give the lateral stiffness of the links; compressed links have none.
        """
        n = len(place)
        link = np.diff(place, axis=0)
        length = np.hypot(*link.T)
        t = link / length[:, None]
        along = t[:, :, None] * t[:, None, :]
        blocks = (self.link_stiffness_N / self.link_mm) * along + (
            np.maximum(tension, 0.0) / length
        )[:, None, None] * (np.eye(2) - along)
        stiffness = np.zeros((n, 2, n, 2))
        first = np.arange(n - 1)
        for i, j, sign in ((0, 0, 1), (1, 1, 1), (0, 1, -1), (1, 0, -1)):
            stiffness[first + i, :, first + j, :] += sign * blocks
        pull = self.tensions(place)[:, None] * t
        force = np.zeros((n, 2))
        force[:-1] += pull
        force[1:] -= pull
        return stiffness.reshape(2 * n, 2 * n), force.ravel()


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
        return self.sprocket.pitch_radius_mm * directions(self.angles_rad)

    @property
    def levers_mm(self) -> tuple[float, float]:
        """Lever arms of both strands about the axis."""
        ends = self.centers[[0, -1]]
        one, two = (
            abs(cross(end, way)) for end, way in zip(ends, (self.tight, self.slack), strict=True)
        )
        return float(one), float(two)


def wrap_at(sprocket: Sprocket, wrap_angle_rad: float, position_rad: float) -> Wrap:
    """Rollers on the sprocket when it has turned to a position."""
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


@dataclass(frozen=True)
class Planes:
    """Planes of the pockets: (k,) rollers, (k, 2) normals in the world, gaps, curvatures."""

    roller: Numbers
    normal: Floats
    gap: Floats
    curvature: Floats


def in_pocket(vectors: Floats, angles: Floats) -> Floats:
    """Circumferential and outward components of vectors (n, 2) at polar angles."""
    cosine, sine = np.cos(angles), np.sin(angles)
    x, y = vectors.T
    return np.column_stack([cosine * y - sine * x, cosine * x + sine * y])


def in_world(local: Floats, angles: Floats) -> Floats:
    """Vectors (…, 2) from their circumferential and outward components."""
    cosine, sine = np.cos(angles), np.sin(angles)
    along, out = local[..., 0], local[..., 1]
    return np.stack([out * cosine - along * sine, out * sine + along * cosine], axis=-1)


def seat_planes(wrap: Wrap, place: Floats, turned: float, angles: Floats) -> Planes:
    """Planes tangent to the seats at angles (m,), for all rollers."""
    polar = wrap.angles_rad + turned
    local = in_pocket(place, polar) - [0.0, wrap.sprocket.pitch_radius_mm]
    normals, gaps = wrap.sprocket.seat_planes(angles, local)
    n, m = gaps.shape
    return Planes(
        roller=np.repeat(np.arange(n), m),
        normal=in_world(np.tile(normals, (n, 1)), np.repeat(polar, m)),
        gap=gaps.ravel(),
        curvature=np.zeros(n * m),
    )


def nearest_planes(wrap: Wrap, place: Floats, turned: float) -> Planes:
    """Planes at the nearest points of the pockets, with their curvature, and adjacent planes.

    Both flanks always have a plane, since no contact surface lies beyond their feet; a roller in
    the seat has that of the nearest point and further planes of the arc, which limit long steps.
    """
    sprocket = wrap.sprocket
    polar = wrap.angles_rad + turned
    local = in_pocket(place, polar) - [0.0, sprocket.pitch_radius_mm]
    away = local - [0.0, sprocket.seat_radius_mm]
    half = sprocket.seat_half_angle_rad
    nearest = np.arctan2(-away[:, 0], -away[:, 1])
    flank_normals, flank_gaps = sprocket.flank_gaps(local)
    roller, normal, gap, curvature = [], [], [], []
    fan = np.linspace(-half, half, ARC_PLANES)
    for i in range(len(place)):
        for side in (0, 1):
            roller.append(i)
            normal.append(flank_normals[side, i])
            gap.append(flank_gaps[side, i])
            curvature.append(-1.0 / (flank_gaps[side, i] + sprocket.flank_radius_mm))
        if abs(nearest[i]) > half:
            continue
        angles = np.append(fan[np.abs(fan - nearest[i]) > LEAST_ANGLE], nearest[i])
        planes, gaps = sprocket.seat_planes(angles, local[i : i + 1])
        roller += [i] * angles.size
        normal += list(planes)
        gap += list(gaps[0])
        distance = max(float(np.hypot(*away[i])), 1e-6 * sprocket.pitch_mm)
        curvature += [0.0] * (angles.size - 1) + [1.0 / distance]
    rollers = np.array(roller)
    return Planes(
        roller=rollers,
        normal=in_world(np.array(normal), polar[rollers]),
        gap=np.array(gap),
        curvature=np.array(curvature),
    )
