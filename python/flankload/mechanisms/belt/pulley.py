"""Elastic pulley of the kind "pulley": a ring of equal sectors, each with one of its own teeth.

A sector extends from the middle of one groove to the middle of the next. In its frame the land
between them is centred on the x axis, and the flank that drives the belt has positive polar angles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import asin, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import Material
from flankload.mechanisms.belt.belt import Round, Trapezoid, turn_matrix

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.mechanisms.belt.belt import Strip
    from flankload.scene import Pulley as PulleyKeys

    Floats = NDArray[np.float64]


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
        return (places + np.array([foot, 0.0])) @ turn_matrix(self.half_pitch_rad)


def build_pulley(keys: PulleyKeys, strip: Strip, plane: str) -> ElasticPulley:
    """Make an elastic pulley from its validated keys.

    Parameters
    ----------
    strip : Strip
        The belt on it.
    plane : {"strain", "stress"}
    """
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
