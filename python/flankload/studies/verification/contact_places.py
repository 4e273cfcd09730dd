"""Places where flanks may touch at a position, with their width and element size.

From the exact curves alone: both flanks are sampled, and the gap is the angle about O1 between them
on the same radius.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.near_field import logarithm_strength
from flankload.errors import FlankloadError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.flank import FlankCurve
    from flankload.pairing.gear_mesh import GearMesh

#: Number of sample points on a flank for the gap.
SAMPLES = 600
#: Size of the zone of fine elements, in half-widths of a contact that carries the load.
ZONE_HALF_WIDTHS = 1.6
#: Least force for the mesh of a flank that is unloaded in flankload, as part of the whole load.
LEAST_FORCE_PART = 0.25
#: Largest length of fine elements as part of a flank's length.
LARGEST_PART = 1.0 / 24.0


@dataclass(frozen=True)
class Place:
    """Place where a pair of flanks may touch.

    `gap_rad` is the least gap, the rotation of body 1 until the flanks touch; `element_mm` the
    wanted length of the elements there; `points` (k, 2) are the centres of fine elements, at
    distances of at most one element length, mm; `turns_rad` the rotations of both bodies.
    """

    site: int
    gap_rad: float
    element_mm: float
    points: Floats
    half_width_mm: float = float("nan")
    turns_rad: tuple[float, float] = (0.0, 0.0)


def contact_places(
    pair: GearMesh,
    turns: tuple[float, float],
    *,
    force_N_per_mm: dict[int, float],
    rotation_rad: float,
    reach: float,
    elements_per_half_width: float,
    plane: str,
) -> tuple[Place, ...]:
    """Places at which flanks can touch before body 1 has turned far beyond its rotation.

    By ascending pair number, from the rotations of both bodies' frames, rad, the approximate
    rotation of body 1 and the approximate force of each pair, which determines the element size: so
    many on the half-width of a Hertz contact under that force. Flanks are omitted if their gap
    exceeds `reach` times the rotation after the first contact. Raises FlankloadError if no flanks
    meet.
    """
    compliance = sum(logarithm_strength(body.material, plane) for body in pair.bodies)
    least = LEAST_FORCE_PART * sum(force_N_per_mm.values()) / len(force_N_per_mm)
    places = []
    for meeting in meetings(pair, turns):
        force = max(force_N_per_mm.get(meeting.site, 0.0), least)
        places.append(meeting.place(compliance * force, elements_per_half_width))
    return reachable(places, rotation_rad, reach)


def reachable(places: Sequence[Place], rotation_rad: float, reach: float) -> tuple[Place, ...]:
    """Places whose gap is at most `reach` times the rotation after the first contact."""
    if not places:
        raise FlankloadError("no flanks meet at this position")
    touch = min(place.gap_rad for place in places)
    return tuple(p for p in places if p.gap_rad <= touch + reach * (rotation_rad - touch))


def fine_sizes(places: Sequence[Place]) -> Floats:
    """Element lengths at the points of all places."""
    return np.concatenate([np.full(len(place.points), place.element_mm) for place in places])


@dataclass(frozen=True, eq=False)
class Meeting:
    """Two flanks of a pair with opposite points: samples of the gap on flank 1.

    The curves are rotated to the position, curve 2 about its own axis. `gaps_rad` (n,), `arc_mm`
    (n,) and `points` (n, 2) are gap angles, arc lengths on flank 1 and places of the samples.
    """

    site: int
    curve_1: FlankCurve
    curve_2: FlankCurve
    center_distance_mm: float
    turns_rad: tuple[float, float]
    gaps_rad: Floats
    arc_mm: Floats
    points: Floats

    def place(self, force_compliance: float, elements: float, late_rad: float = 0.0) -> Place:
        """Place of the least gap, with the zone and so many elements on the half-width.

        From the force times the compliance of both half-planes, mm. The half-width is infinite on
        flat flanks, which touch over their length. `late_rad` is added to the gap.
        """
        best = int(self.gaps_rad.argmin())
        least, s_1, middle = float(self.gaps_rad[best]), self.arc_mm[best], self.points[best]
        s_2 = self.curve_2.arc_length_of(middle - [self.center_distance_mm, 0.0])[0]
        bend = self.curve_1.curvature([s_1])[0] + self.curve_2.curvature(s_2)[0]
        # line contact: b^2 = 2 F c / bend
        half_width = float(np.sqrt(2 * force_compliance / bend)) if bend > 0 else float("inf")
        n_x, n_y = self.curve_1.normal([s_1])[0]
        lever = abs(float(middle[0] * n_y - middle[1] * n_x))
        longest = LARGEST_PART * min(self.curve_1.length_mm, self.curve_2.length_mm)
        size = min(half_width / elements, longest)
        near = (self.gaps_rad - least) * lever <= ZONE_HALF_WIDTHS**2 * force_compliance
        points = _spread(self.points[near], middle, size)
        return Place(self.site, least + late_rad, size, points, half_width, self.turns_rad)


def meetings(pair: GearMesh, turns: tuple[float, float]) -> list[Meeting]:
    """Pairs of flanks with opposite points, by ascending number; the bodies are turned, rad."""
    pairing = pair.pairing
    found = []
    for number, site in enumerate(pairing.sites.tolist()):
        curve_1, curve_2 = (
            body.curve.rotated(turn + float(angles[number]))
            for body, turn, angles in zip(pair.bodies, turns, pairing.site_angles_rad, strict=True)
        )
        gaps = _gaps(curve_1, curve_2, pairing.center_distance_mm, pairing.period_rad)
        if gaps is not None:
            distance = pairing.center_distance_mm
            found.append(Meeting(site, curve_1, curve_2, distance, turns, *gaps))
    return found


def _gaps(
    curve_1: FlankCurve, curve_2: FlankCurve, distance_mm: float, pitch_rad: float
) -> tuple[Floats, Floats, Floats] | None:
    """Gap angles, arc lengths on flank 1 and places of its samples that have an opposite point."""
    s = np.linspace(0.0, curve_1.length_mm, SAMPLES)
    points = curve_1.point(s)
    mate = curve_2.point(np.linspace(0.0, curve_2.length_mm, SAMPLES))
    mate[:, 0] += distance_mm
    radius, mate_radius = np.hypot(*points.T), np.hypot(*mate.T)
    angle, mate_angle = np.arctan2(*points.T[::-1]), np.unwrap(np.arctan2(*mate.T[::-1]))
    gap = np.full(s.size, np.inf)
    for piece in _monotonic(mate_radius):
        along, of_piece = mate_radius[piece], mate_angle[piece]
        order = slice(None) if along[-1] >= along[0] else slice(None, None, -1)
        opposite = np.interp(radius, along[order], of_piece[order], left=np.nan, right=np.nan)
        between = (opposite - angle + np.pi) % (2 * np.pi) - np.pi
        gap = np.where(np.abs(between) < 0.5 * pitch_rad, np.minimum(gap, between), gap)
    found = np.isfinite(gap)
    return (gap[found], s[found], points[found]) if found.any() else None


def _monotonic(values: Floats) -> list[slice]:
    """Pieces between turning points, which belong to both of their pieces."""
    rising = np.diff(values) > 0
    ends = [0, *(np.flatnonzero(rising[1:] != rising[:-1]) + 1).tolist(), values.size - 1]
    return [slice(low, high + 1) for low, high in pairwise(ends)]


def _spread(points: Floats, middle: Floats, size: float) -> Floats:
    """Some of the points, about `size` apart, including the middle one."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    chosen = np.unique((along / size).astype(int), return_index=True)[1]
    return np.vstack([points[chosen], points[-1:], middle[None]])
