"""The kinds "pulley" and "belt": teeth of a timing belt, grooves of its pulley.

The frame of a tooth has its origin on the centre line, level with the ends of both adjacent lands,
x outwards (away from the pulley), y in the direction of rotation, from the tight strand to the
slack one. The working flank of the belt is at negative y: the pulley pushes it towards the slack
strand. The pitch line, on which the cord lies, is a circle of
radius teeth*pitch/(2 pi); the land circle is smaller by `land_distance_mm`.

An elastic pulley is a ring of equal sectors, each from the middle of one groove to the middle of
the next. In the frame of a sector the land is centred on the x axis, and the flank that drives the
belt has positive polar angles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import acos, asin, cos, pi, radians, sin, sqrt, tan
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import Material

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.scene import Belt as BeltKeys
    from flankload.scene import Pulley as PulleyKeys

#: Angle at which the side of a round tooth ends and its tip begins, from the circumferential
#: direction.
SIDE_ANGLE = 0.25 * pi


@dataclass(frozen=True)
class Trapezoid:
    """A tooth, or a groove, with straight sides.

    Attributes
    ----------
    width_mm : float
        Width at the land.
    angle_rad : float
        Angle of the sides to the centre line.
    """

    width_mm: float
    height_mm: float
    angle_rad: float

    @property
    def tip_width_mm(self) -> float:
        """Width between the sides at the tip."""
        return self.width_mm - 2 * self.height_mm * tan(self.angle_rad)

    def side(self, parts: Floats) -> tuple[Floats, Floats]:
        """Points of the working side at fractions (n,) of its length, from the land to the tip.

        Returns places (n, 2), mm, and normals (n, 2) that point out of the tooth.
        """
        depth = self.height_mm * parts
        places = np.column_stack([-depth, -0.5 * self.width_mm + depth * tan(self.angle_rad)])
        normal = [-sin(self.angle_rad), -cos(self.angle_rad)]
        return places, np.tile(normal, (parts.size, 1))

    def tip(self, parts: Floats) -> Floats:
        """(n, 2) Points of the tip at fractions of its length, from the working side on."""
        across = 0.5 * self.tip_width_mm * (2 * parts - 1)
        return np.column_stack([np.full(parts.size, -self.height_mm), across])

    def distance(self, places: Floats) -> Floats:
        """(n,) Distance of points from the working side, mm: positive inside, negative outside."""
        foot = np.array([0.0, -0.5 * self.width_mm])
        normal = np.array([-sin(self.angle_rad), -cos(self.angle_rad)])
        return -(places - foot) @ normal


@dataclass(frozen=True)
class Round:
    """A tooth, or a groove, with a round tip: its sides follow the arc, or begin straight.

    Attributes
    ----------
    radius_mm : float
        Radius of the arc.
    height_mm : float
        If it exceeds the radius, the sides are straight from the land to the centre of the arc.
    """

    radius_mm: float
    height_mm: float

    @property
    def width_mm(self) -> float:
        """Width at the land."""
        rest = self.radius_mm - self.height_mm
        return 2 * (sqrt(self.radius_mm**2 - rest**2) if rest > 0 else self.radius_mm)

    @property
    def center(self) -> Floats:
        """Centre of the arc, mm."""
        return np.array([self.radius_mm - self.height_mm, 0.0])

    @property
    def _first_angle(self) -> float:
        """Angle of the arc's end at the land, from the circumferential direction to the tip."""
        rest = (self.radius_mm - self.height_mm) / self.radius_mm
        return 0.5 * pi - acos(rest) if rest > 0 else 0.0

    def side(self, parts: Floats) -> tuple[Floats, Floats]:
        """As `Trapezoid.side`; the tip begins at 45 degrees."""
        straight = max(self.height_mm - self.radius_mm, 0.0)
        first = self._first_angle
        arc = self.radius_mm * (max(SIDE_ANGLE, first + 0.1) - first)
        path = parts * (straight + arc)
        turn = first + np.maximum(path - straight, 0.0) / self.radius_mm
        normals = np.column_stack([-np.sin(turn), -np.cos(turn)])
        places = self.center + self.radius_mm * normals
        places[:, 0] += np.maximum(straight - path, 0.0)
        return places, normals

    def tip(self, parts: Floats) -> Floats:
        """As `Trapezoid.tip`."""
        first = max(SIDE_ANGLE, self._first_angle + 0.1)
        turn = first + (pi - 2 * first) * parts
        return np.asarray(
            self.center + self.radius_mm * np.column_stack([-np.sin(turn), -np.cos(turn)])
        )

    def distance(self, places: Floats) -> Floats:
        """As `Trapezoid.distance`."""
        away = places - self.center
        # next to the straight part only the circumferential distance matters
        away[:, 0] = np.where(
            self.height_mm > self.radius_mm, np.minimum(away[:, 0], 0.0), away[:, 0]
        )
        return np.asarray(self.radius_mm - np.hypot(*away.T))


@dataclass(frozen=True)
class Strip:
    """A timing belt on its pulley: w wrapped teeth.

    Attributes
    ----------
    pitch_mm : float
        Pitch of the pulley, on which the belt lies.
    tooth : Trapezoid, Round or None
        None for a belt without teeth.
    groove : Trapezoid, Round or None
        None if the groove has the shape of the tooth.
    land_distance_mm : float
        Distance from the land to the pitch line.
    back_mm : float
        Thickness from the land to the back.
    cord_N_per_mm : float
        Tension of the cord divided by its strain, per mm of width.
    clearance_rad : float
        Angle by which the pulley rotates before the first contact, in addition to the gaps to the
        groove.
    pitch_difference_mm : float
        Pitch of the belt minus that of the pulley.
    prestress_N_per_mm : float
        Mean tension that keeps the cord straight, per mm of width.
    rows : (int, int) or None
        Rows of elements from the land to the cord, and from the cord to the back; None: from the
        length of the elements.
    """

    pulley_teeth: int
    pitch_mm: float
    wrapped_teeth: int
    width_mm: float
    tooth: Trapezoid | Round | None
    groove: Trapezoid | Round | None
    land_distance_mm: float
    back_mm: float
    cord_N_per_mm: float
    material: Material
    clearance_rad: float = 0.0
    pitch_difference_mm: float = 0.0
    prestress_N_per_mm: float = 0.0
    rows: tuple[int, int] | None = None

    @property
    def pitch_radius_mm(self) -> float:
        """Radius of the circle on which the cord lies."""
        return self.pulley_teeth * self.pitch_mm / (2 * pi)

    @property
    def strand_N_per_mm(self) -> float:
        """Tension of a free strand divided by its strain, per mm of width, without tooth loads."""
        material = self.material
        plane = material.young_modulus_MPa / (1 - material.poisson_ratio**2)
        return self.cord_N_per_mm + plane * self.back_mm

    @property
    def land_radius_mm(self) -> float:
        """Radius of the pulley's outer circle."""
        return self.pitch_radius_mm - self.land_distance_mm

    @property
    def pitch_rad(self) -> float:
        """Angle between adjacent teeth."""
        return 2 * pi / self.pulley_teeth

    @property
    def foot_radius_mm(self) -> float:
        """Radius of the origins of the tooth frames."""
        half_width = 0.5 * self.tooth.width_mm if self.tooth is not None else 0.0
        return sqrt(self.land_radius_mm**2 - half_width**2)

    def in_tooth(self, places: Floats, tooth_angle_rad: float) -> Floats:
        """Transform places (…, 2) from axes at the centre of rotation to the frame of a tooth."""
        return turned(places, -tooth_angle_rad) - np.array([self.foot_radius_mm, 0.0])

    def gaps(self, places: Floats) -> Floats:
        """(n,) Gaps between places on the working flank, in its tooth frame, and the groove, mm."""
        if self.groove is None:
            return np.zeros(len(places))
        return self.groove.distance(places)


def build_strip(pulley: PulleyKeys, belt: BeltKeys) -> Strip:
    """Make belt and pulley from their validated keys."""
    groove_width = pulley.groove_width_mm or belt.tooth_width_mm
    wider = 0.5 * (groove_width - belt.tooth_width_mm)
    tooth: Trapezoid | Round
    groove: Trapezoid | Round
    if pulley.tooth_shape == "T":
        assert belt.flank_angle_deg is not None
        angle = radians(belt.flank_angle_deg)
        tooth = Trapezoid(belt.tooth_width_mm, belt.tooth_height_mm, angle)
        cut = pulley.groove_angle_deg
        # flanks meet at the land: the extra width of a groove is rotation of the pulley before
        # contact
        groove = replace(tooth, angle_rad=radians(cut) if cut is not None else angle)
    else:
        tooth = Round(0.5 * belt.tooth_width_mm, belt.tooth_height_mm)
        # concentric arcs: the extra width of a groove is a gap along the whole flank
        groove = Round(tooth.radius_mm + wider, tooth.height_mm + wider)
    strip = Strip(
        pulley_teeth=pulley.teeth,
        pitch_mm=pulley.pitch_mm,
        wrapped_teeth=belt.wrapped_teeth,
        width_mm=belt.width_mm,
        tooth=tooth,
        groove=groove if groove != tooth else None,
        land_distance_mm=belt.land_distance_mm,
        back_mm=belt.back_mm,
        cord_N_per_mm=belt.cord_stiffness_N_per_mm,
        material=Material(belt.young_modulus_MPa, belt.poisson_ratio),
        pitch_difference_mm=belt.pitch_mm - pulley.pitch_mm + belt.pitch_difference_um / 1000.0,
        prestress_N_per_mm=belt.prestress_N / belt.width_mm,
    )
    if pulley.tooth_shape == "T" and wider:
        return replace(strip, clearance_rad=wider / strip.foot_radius_mm)
    return strip


@dataclass(frozen=True)
class ElasticPulley:
    """An elastic pulley, fixed at its bore.

    Attributes
    ----------
    teeth : int
        Number of equal sectors.
    land_radius_mm : float
        Radius of the outer circle.
    groove : Trapezoid, Round or None
        Groove with its cut width; None for a plain ring.
    touched_mm : float
        Height of the belt's tooth, which is the part of a straight side in contact.
    depth_mm : float
        Depth of the groove, from the line between the ends of both lands beside it.
    bore_radius_mm : float
        Radius of the bore, which is fixed.
    plane : {"strain", "stress"}
    """

    teeth: int
    land_radius_mm: float
    groove: Trapezoid | Round | None
    touched_mm: float
    depth_mm: float
    bore_radius_mm: float
    material: Material
    plane: str = "strain"

    @property
    def half_pitch_rad(self) -> float:
        """Half the angle between adjacent teeth."""
        return pi / self.teeth

    @property
    def half_land_rad(self) -> float:
        """Half the angle of a land."""
        if self.groove is None:
            return self.half_pitch_rad
        return self.half_pitch_rad - asin(0.5 * self.groove.width_mm / self.land_radius_mm)

    def flank(self, parts: Floats) -> Floats:
        """(n, 2) Places of the working flank at fractions of its contact part, from the land."""
        assert self.groove is not None
        straight = isinstance(self.groove, Trapezoid)
        reach = self.touched_mm / self.groove.height_mm if straight else 1.0
        return self._placed(self.groove.side(reach * parts)[0])

    def below(self, parts: Floats) -> Floats:
        """(n, 2) Places of the flank below its contact part, from there to its end."""
        assert self.groove is not None
        reach = self.touched_mm / self.groove.height_mm
        return self._placed(self.groove.side(reach + (1.0 - reach) * parts)[0])

    def bottom(self, parts: Floats) -> Floats:
        """(n, 2) Places of the bottom of the groove, from the end of the flank to its middle."""
        assert self.groove is not None
        places = self.groove.tip(0.5 * parts)
        start = self.groove.tip(np.zeros(1))[0, 0]
        # a deeper round groove is extended below its sides
        drawn = (self.depth_mm + start) / max(self.groove.height_mm + start, 1e-300)
        if isinstance(self.groove, Round):
            places[:, 0] = start + (places[:, 0] - start) * drawn
        return self._placed(places)

    @property
    def flank_goes_on(self) -> bool:
        """Whether the flank extends beyond its contact part."""
        return isinstance(self.groove, Trapezoid) and self.depth_mm > self.touched_mm

    def _placed(self, places: Floats) -> Floats:
        """Transform places from the frame of the groove to that of the sector."""
        assert self.groove is not None
        foot = sqrt(self.land_radius_mm**2 - (0.5 * self.groove.width_mm) ** 2)
        return turned(places + np.array([foot, 0.0]), self.half_pitch_rad)


def build_pulley(keys: PulleyKeys, strip: Strip, plane: str) -> ElasticPulley:
    """Make an elastic pulley from its validated keys and the belt on it."""
    assert keys.bore_diameter_mm is not None
    assert strip.tooth is not None
    groove = strip.groove if strip.groove is not None else strip.tooth
    depth = max(keys.groove_depth_mm or 0.0, groove.height_mm)
    if isinstance(groove, Trapezoid):
        width = keys.groove_width_mm or groove.width_mm
        groove = replace(groove, width_mm=width, height_mm=depth)
    return ElasticPulley(
        teeth=strip.pulley_teeth,
        land_radius_mm=strip.land_radius_mm,
        groove=groove,
        touched_mm=strip.tooth.height_mm,
        depth_mm=depth,
        bore_radius_mm=0.5 * keys.bore_diameter_mm,
        material=Material(keys.young_modulus_MPa, keys.poisson_ratio),
        plane=plane,
    )
