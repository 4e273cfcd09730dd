"""Interference of flanks: contact in a fillet or elsewhere off the path of contact.

A point p of flank 1 and a point q of flank 2 can meet only at the two intersections of the circle
about O1 through p with the circle about O2 through q. With p at one of these, the angle of q about
O2 to this intersection is the margin of both points: 0 if they touch, negative if they overlap.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.bodies.profile.involute import Involute
    from flankload.flank import FlankCurve

    Flags = NDArray[np.bool_]
    Numbers = NDArray[np.int64]

#: Number of points in each interval of a flank's curve.
POINTS_PER_INTERVAL = 6
#: Overlaps are first evaluated at every third point, then at all points near the deepest ones.
FIRST_STEP = 3

#: Least overlap that causes a warning, over the flank's length (1 um for module 4.5 mm); profiles
#: are not more accurate.
LEAST_OVERLAP = 1e-4


@dataclass(frozen=True)
class Overlap:
    """The deepest overlap of a part of the flanks, along the circumference.

    Radii are distances from the axis of each body; `at_tips`: both points are on the outer halves
    of their flanks.
    """

    depth_mm: float
    radius_1_mm: float
    radius_2_mm: float
    at_tips: bool


def root_contacts(
    involutes: tuple[Involute, Involute], lengths_mm: tuple[float, float]
) -> Iterator[str]:
    """Warn if the mate's tip meets the fillet instead of the involute.

    `lengths_mm`: root end of the path of contact of each body, along the line of action from its
    base circle.
    """
    for name, involute, length in zip("12", involutes, lengths_mm, strict=True):
        deepest = hypot(involute.base_radius_mm, max(0.0, length))
        depth = involute.outward * (involute.form_radius_mm - deepest)
        if length < 0.0 or depth > 0.0:
            side = "below" if involute.outward > 0 else "beyond"
            yield (
                f"the mate's tip reaches {depth:.3f} mm {side} the form circle of body_{name} "
                f"(diameter {2 * involute.form_radius_mm:.3f} mm): it meets the root fillet"
            )


def overlapping_flanks(
    body_1: Body, body_2: Body, pitch_radii_mm: tuple[float, float], distance_mm: float
) -> Iterator[str]:
    """Warn of overlaps with a root; raise a SceneError for overlaps of tips.

    Parameters as for `overlaps_of`.
    """
    for overlap in overlaps_of(body_1, body_2, pitch_radii_mm, distance_mm):
        where = (
            f"at the diameters {2 * overlap.radius_1_mm:.3f} mm of body_1 and "
            f"{2 * overlap.radius_2_mm:.3f} mm of body_2"
        )
        if overlap.at_tips:
            raise SceneError(
                key="body_2.tip_diameter_mm",
                expected="tips that clear each other on their way out of the mesh (shorter teeth, "
                f"or more than {body_2.teeth - body_1.teeth} teeth of difference)",
                found=f"{2 * (body_2.tip_radius_mm or 0.0):g}, where the tips overlap by "
                f"{overlap.depth_mm:.4f} mm {where}",
            )
        yield (
            f"the flanks overlap by up to {overlap.depth_mm:.4f} mm off the path of contact, "
            f"{where}: the motion is not uniform, since the root displaces the tip"
        )


def overlaps_of(
    body_1: Body, body_2: Body, pitch_radii_mm: tuple[float, float], distance_mm: float
) -> Iterator[Overlap]:
    """The deepest overlaps at the tips and elsewhere, if any.

    The bodies have involutes; pair 0 touches on the working pitch circles at position zero.
    """
    (r_1, angle_1, tip_1), (r_2, angle_2, tip_2) = (
        _places(body, radius) for body, radius in zip((body_1, body_2), pitch_radii_mm, strict=True)
    )
    # ignore points out of reach of the other body
    some_1, some_2 = _some_meet(r_1, r_2, distance_mm), _some_meet(r_2, r_1, distance_mm)
    if not (some_1.any() and some_2.any()):
        return
    r_1, angle_1, tip_1 = r_1[some_1], angle_1[some_1], tip_1[some_1]
    r_2, angle_2, tip_2 = r_2[some_2], angle_2[some_2], tip_2[some_2]

    def depths(i: Numbers, j: Numbers) -> tuple[Floats, Flags]:
        place_1 = (r_1[i, np.newaxis], angle_1[i, np.newaxis])
        found = _overlaps(place_1, (r_2[j], angle_2[j]), body_1, body_2, distance_mm)
        return found, tip_1[i, np.newaxis] & tip_2[j]

    counts = r_1.size, r_2.size
    some = [np.unique([*range(0, count, FIRST_STEP), count - 1]) for count in counts]
    first, first_at_tips = depths(*some)
    for part in (True, False):
        begun = _deepest(first, first_at_tips == part)
        near = [
            np.arange(max(of[k] - FIRST_STEP, 0), min(of[k] + FIRST_STEP + 1, count))
            for k, of, count in zip(begun, some, counts, strict=True)
        ]
        depth, at_tips = depths(*near)
        i, j = _deepest(depth, at_tips == part)
        if at_tips[i, j] == part and depth[i, j] > LEAST_OVERLAP * body_1.curve.length_mm:
            radii = float(r_1[near[0][i]]), float(r_2[near[1][j]])
            yield Overlap(float(depth[i, j]), *radii, part)


def _deepest(depth: Floats, among: Flags) -> tuple[int, int]:
    """Place of the largest overlap among the chosen ones."""
    i, j = np.unravel_index(np.argmax(np.where(among, depth, -np.inf)), depth.shape)
    return int(i), int(j)


def along(curve: FlankCurve, count: int) -> Floats:
    """Arc lengths of `count` points in each interval of a curve, and of its end."""
    points = np.linspace(curve.breaks[:-1], curve.breaks[1:], count, endpoint=False)
    return np.append(points.T.ravel(), curve.breaks[-1])


def _places(body: Body, pitch_radius: float) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Radii and angles (from the pitch point) of points on a flank; whether in its outer half."""
    curve, involute = body.curve, body.involute
    assert involute is not None
    s = along(curve, POINTS_PER_INTERVAL)
    x, y = curve.point(s).T
    angle = np.arctan2(y, x) - involute.polar_angle_at(pitch_radius)
    return (
        np.hypot(x, y),
        (angle + np.pi) % (2 * np.pi) - np.pi,
        s > 0.5 * sum(body.mode_range_mm),
    )


def _some_meet(radii: Floats, others: Floats, distance: float) -> NDArray[np.bool_]:
    """Whether circles meet any circle about the other axis with a radius in the range of others."""
    reached = (others.min() < distance + radii) & (others.max() > np.abs(distance - radii))
    return np.asarray(reached, dtype=np.bool_)


def _overlaps(
    place_1: tuple[Floats, Floats],
    place_2: tuple[Floats, Floats],
    body_1: Body,
    body_2: Body,
    distance: float,
) -> Floats:
    """Larger overlap at both intersections, mm about O2; -inf if there are none."""
    (r_1, angle_1), (r_2, angle_2) = place_1, place_2
    sense, ratio = body_2.outward, body_1.teeth / body_2.teeth
    cosine_1 = (distance**2 + r_1**2) - r_2**2
    cosine_1 /= sense * 2 * distance * r_1
    cosine_2 = (distance**2 + r_2**2) - r_1**2
    cosine_2 /= 2 * distance * r_2
    meet = (np.abs(cosine_1) < 1.0) & (np.abs(cosine_2) < 1.0)
    # at the other intersection both angles have the opposite sign
    depth = np.full(meet.shape, -np.inf)
    theta_2 = np.arccos(cosine_2, out=cosine_2, where=meet)
    np.arccos(cosine_1, out=depth, where=meet)
    depth *= ratio
    depth -= theta_2
    np.abs(depth, out=depth, where=meet)
    depth += ratio * angle_1 + sense * angle_2
    depth *= r_2
    return depth
