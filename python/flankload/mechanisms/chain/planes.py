"""Planes in place of the pockets of rollers: tangent to the seats, or at the nearest points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.mechanisms.chain.wrap import Wrap

    Floats = NDArray[np.float64]

#: Number of planes beside that of the nearest point, and their least distance from it, rad.
BESIDE, APART = 5, 0.05


@dataclass(frozen=True)
class Planes:
    """Planes of the pockets: (k,) rollers, (k, 2) normals in the world, gaps, curvatures."""

    roller: NDArray[np.int64]
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

    In the seat, the plane of the nearest point and further planes of the arc that limit long steps;
    the planes of both flanks always: no contact surface lies beyond their feet.
    """
    sprocket = wrap.sprocket
    polar = wrap.angles_rad + turned
    local = in_pocket(place, polar) - [0.0, sprocket.pitch_radius_mm]
    away = local - [0.0, sprocket.seat_radius_mm]
    half = sprocket.seat_half_angle_rad
    nearest = np.arctan2(-away[:, 0], -away[:, 1])
    flank_normals, flank_gaps = sprocket.flank_gaps(local)
    roller, normal, gap, curvature = [], [], [], []
    fan = np.linspace(-half, half, BESIDE)
    for i in range(len(place)):
        for side in (0, 1):
            roller.append(i)
            normal.append(flank_normals[side, i])
            gap.append(flank_gaps[side, i])
            curvature.append(-1.0 / (flank_gaps[side, i] + sprocket.flank_radius_mm))
        if abs(nearest[i]) > half:
            continue
        angles = np.append(fan[np.abs(fan - nearest[i]) > APART], nearest[i])
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
