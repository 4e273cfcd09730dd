"""The kind "sprocket": rigid pockets of the rollers after ISO 606.

The contact geometry of a pocket is the curve on which the roller's centre can lie: a concave seat
arc at the bottom of the pocket, and beyond its ends convex arcs around the flanks of both teeth,
tangent to it. In the frame of a pocket the origin is the roller's place on the pitch circle; the
axes point in the circumferential direction and outwards.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, pi, radians, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.scene import Sprocket as SprocketKeys

#: ISO 606: least and largest roller seating radius, r_i = 0.505 d1 (+ 0.069 d1^(1/3)).
SEAT_RATIO, SEAT_ROOT = 0.505, 0.069


@dataclass(frozen=True)
class Sprocket:
    """Contact geometry of a sprocket for the rollers of a chain.

    Attributes
    ----------
    seat_radius_mm : float
        Radius of the arc on which a roller's centre can lie in its seat: seat radius minus roller
        radius.
    flank_radius_mm : float
        Radius of the arcs on which the centre can lie beyond the seat.
    seat_half_angle_rad : float
        Half the angle of the seat arc.
    tip_radius_mm : float
        Radius of the tip circle.
    """

    teeth: int
    pitch_mm: float
    roller_diameter_mm: float
    seat_radius_mm: float
    flank_radius_mm: float
    seat_half_angle_rad: float
    tip_radius_mm: float

    @property
    def half_pitch_rad(self) -> float:
        """Half the angle between adjacent teeth."""
        return pi / self.teeth

    @property
    def pitch_rad(self) -> float:
        """Angle between adjacent teeth."""
        return 2 * self.half_pitch_rad

    @property
    def pitch_radius_mm(self) -> float:
        """Radius of the circle of roller centres."""
        return 0.5 * self.pitch_mm / sin(self.half_pitch_rad)

    @property
    def tension_ratio(self) -> float:
        """Ratio of the tensions behind and in front of a roller carried by the foot of the flank.

        q = sin(theta)/sin(theta + 2 beta): balance of a roller between two links, with beta half a
        pitch and theta the angle between the contact force there and the link behind.
        """
        theta = 0.5 * pi - self.seat_half_angle_rad - self.half_pitch_rad
        return sin(theta) / sin(theta + 2 * self.half_pitch_rad)

    def jump_tension(self, tight_N: Floats, wrap_angle_rad: float) -> Floats:
        """T1 q^n, the slack tension (N) below which a worn chain climbs the flanks of n pitches."""
        return tight_N * self.tension_ratio ** (0.5 * wrap_angle_rad / self.half_pitch_rad)

    @cached_property
    def flank_centers(self) -> Floats:
        """(2, 2) Centres of the arcs of the working and of the other flank, pocket frame."""
        a = self.seat_half_angle_rad
        reach = self.seat_radius_mm + self.flank_radius_mm
        return np.array(
            [[side * -sin(a) * reach, self.seat_radius_mm - cos(a) * reach] for side in (1, -1)]
        )

    @property
    def tooth_top_mm(self) -> float:
        """Radius at which both flanks of a tooth meet, or their largest radius before that."""
        x, y = self.flank_centers[1] + [0.0, self.pitch_radius_mm]
        radius = self.flank_radius_mm - 0.5 * self.roller_diameter_mm
        distance, beyond = float(np.hypot(x, y)), float(np.arctan2(x, y)) - self.half_pitch_rad
        if beyond <= 0:
            return distance + radius
        aside = distance * sin(beyond)
        # arcs that begin beyond the middle of the tooth: pockets overlap
        return distance * cos(beyond) + sqrt(radius**2 - aside**2) if aside < radius else 0.0

    @property
    def highest_roller_mm(self) -> float:
        """Largest outward motion of a roller along a flank before it reaches the tip."""
        # the line from the flank's centre through that roller meets the tip circle
        center = self.flank_centers[0] + [0.0, self.pitch_radius_mm]
        inner = self.flank_radius_mm - 0.5 * self.roller_diameter_mm
        distance = float(np.hypot(*center))
        cosine = (self.tip_radius_mm**2 - distance**2 - inner**2) / (2 * distance * inner)
        turn = np.arctan2(center[1], center[0]) - np.arccos(np.clip(cosine, -1.0, 1.0))
        place = center + self.flank_radius_mm * np.array([np.cos(turn), np.sin(turn)])
        return float(place[1] - self.pitch_radius_mm)

    def seat_planes(self, angles_rad: Floats, place: Floats) -> tuple[Floats, Floats]:
        """Planes tangent to the seat arc at angles (m,) from the outward direction.

        Angles are positive in the direction of rotation. Returns the normals (m, 2) out of the
        sprocket and the gaps (n, m), mm, of rollers with their centres at places (n, 2) in the
        frames of their pockets.
        """
        normals = np.column_stack([np.sin(angles_rad), np.cos(angles_rad)])
        return normals, (place - [0.0, self.seat_radius_mm]) @ normals.T + self.seat_radius_mm

    def flank_gaps(self, place: Floats) -> tuple[Floats, Floats]:
        """Normals (2, n, 2) out of the sprocket and gaps (2, n), mm, of rollers to both flanks.

        At the nearest points; the rollers' centres are at places (n, 2) in the frames of their
        pockets.
        """
        away = place[None] - self.flank_centers[:, None]
        distance = np.hypot(away[..., 0], away[..., 1])
        return away / distance[..., None], distance - self.flank_radius_mm

    def outline(self, n: int = 24) -> Floats:
        """Contour (k, 2) of one tooth space from tip to tip, counter-clockwise, for drawings.

        In the frame of the sprocket, with the pocket of roller 0 on the x axis.
        """
        a = self.seat_half_angle_rad
        ball = 0.5 * self.roller_diameter_mm
        seat = [0.0, self.seat_radius_mm]
        angles = np.linspace(a, -a, 2 * n)
        normals = np.column_stack([np.sin(angles), np.cos(angles)])
        pocket = seat - (self.seat_radius_mm + ball) * normals
        flanks = []
        for side, center in zip((1, -1), self.flank_centers, strict=True):
            turn = side * np.linspace(a, a - 1.2, n)
            normal = np.column_stack([np.sin(turn), np.cos(turn)])
            points = center + (self.flank_radius_mm - ball) * normal
            radius = np.hypot(points[:, 0], points[:, 1] + self.pitch_radius_mm)
            within = np.abs(np.arctan2(points[:, 0], points[:, 1] + self.pitch_radius_mm))
            keep = (radius <= self.tip_radius_mm) & (within <= self.half_pitch_rad)
            flanks.append(points[: int(np.argmin(keep)) if not keep.all() else n])
        local = np.vstack([flanks[0][::-1], pocket, flanks[1]])
        return np.column_stack([local[:, 1] + self.pitch_radius_mm, local[:, 0]])


def build_sprocket(spec: SprocketKeys, key: str) -> Sprocket:
    """Build a sprocket from the keys of its table; a SceneError if a roller does not fit.

    ISO 606: the roller seating radius lies between 0.505 d1 and 0.505 d1 + 0.069 d1^(1/3), the
    flank radius between 0.12 d1 (z + 2) and 0.008 d1 (z² + 180), the seating angle between 140° -
    90°/z and 120° - 90°/z; the tight form has the first of each, the wide one the second, except
    for the seating angle, which is 120° - 90°/z by default. The tip diameter is the mean of its
    limits, or less if both flanks of a tooth meet below it.
    """
    built = _proportions(spec)
    _check(built, spec, key)
    return replace(built, tip_radius_mm=min(built.tip_radius_mm, built.tooth_top_mm))


def _proportions(spec: SprocketKeys) -> Sprocket:
    """Sprocket from its keys and from ISO 606 where they are missing, unchecked."""
    d, z = spec.roller_diameter_mm, spec.teeth
    wide = spec.seat == "wide"
    seat = spec.roller_seat_radius_mm or SEAT_RATIO * d + (
        SEAT_ROOT * d ** (1 / 3) if wide else 0.0
    )
    flank = spec.flank_radius_mm or (0.008 * d * (z**2 + 180) if wide else 0.12 * d * (z + 2))
    angle = radians(spec.seating_angle_deg or 120.0 - 90.0 / z)
    pitch_diameter = spec.pitch_mm / sin(pi / z)
    # between d + (1 - 1.6/z) p - d1 and d + 1.25 p - d1
    middle = 0.5 * (2.25 - 1.6 / z)
    tip = spec.tip_diameter_mm or pitch_diameter + middle * spec.pitch_mm - d
    return Sprocket(z, spec.pitch_mm, d, seat - 0.5 * d, flank + 0.5 * d, 0.5 * angle, 0.5 * tip)


def _check(built: Sprocket, spec: SprocketKeys, key: str) -> None:
    """Refuse a sprocket whose rollers do not fit its pockets."""
    d, z = built.roller_diameter_mm, built.teeth
    pitch_diameter, tip = 2 * built.pitch_radius_mm, 2 * built.tip_radius_mm
    if built.seat_radius_mm <= 0.0:
        raise SceneError(
            key=f"{key}.roller_seat_radius_mm",
            expected=f"more than half of {key}.roller_diameter_mm ({0.5 * d:g}): the roller has to "
            "fit its pocket",
            found=f"{built.seat_radius_mm + 0.5 * d:g}",
        )
    if d >= spec.pitch_mm:
        raise SceneError(
            key=f"{key}.roller_diameter_mm",
            expected=f"less than {key}.pitch_mm ({spec.pitch_mm:g})",
            found=f"{d:g}",
        )
    if built.seat_half_angle_rad + built.half_pitch_rad >= 0.5 * pi:
        raise SceneError(
            key=f"{key}.seating_angle_deg",
            expected=f"less than 180 - 360/teeth ({180 - 360 / z:g}), since flanks steeper than "
            "the links hold no tension",
            found=f"{np.degrees(2 * built.seat_half_angle_rad):g}",
        )
    if tip <= pitch_diameter:
        raise SceneError(
            key=f"{key}.tip_diameter_mm",
            expected=f"more than the pitch diameter ({pitch_diameter:g})",
            found=f"{tip:g}",
        )
    top = 2 * built.tooth_top_mm
    if top <= pitch_diameter:
        raise SceneError(
            key=key,
            expected="roller, seat and flank radius, seating angle that leave teeth beyond the "
            f"pitch diameter ({pitch_diameter:g})",
            found=f"flanks that end at the diameter {top:g}" if top else "none between seats",
        )
    if spec.tip_diameter_mm is not None and tip > top:
        raise SceneError(
            key=f"{key}.tip_diameter_mm",
            expected=f"at most {top:g}, where the flanks of a tooth end",
            found=f"{tip:g}",
        )
