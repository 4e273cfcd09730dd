"""Shape of a body along its axis: width, helix, lead modifications, shaft and regions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import tan
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import TIE
from flankload.bodies.shaft import Shaft, build_shaft, flexible_shaft
from flankload.scene.table import RELIEF_EXPONENTS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.bodies.flank_surface import FlankSurface
    from flankload.bodies.shaft import FlexibleShaft
    from flankload.scene.axial import AxialKeys
    from flankload.scene.planet_flank import PlanetFlank


@dataclass(frozen=True)
class LeadModifications:
    """Metal removed from a flank along its face width, in the direction of the base tangent.

    Attributes
    ----------
    crowning_mm : float
        Parabola: 0 in the middle, this amount at both ends.
    slope_mm : float
        Linear: this amount at the end of larger z; negative: its magnitude at the other end.
    end_relief_mm, end_relief_length_mm : (float, float)
        Amounts at the ends of smaller and larger z, and lengths of the reliefs.
    end_relief_exponent : int
        Exponent of the distance from the start of the relief (`RELIEF_EXPONENTS`).
    """

    crowning_mm: float = 0.0
    slope_mm: float = 0.0
    end_relief_mm: tuple[float, float] = (0.0, 0.0)
    end_relief_length_mm: tuple[float, float] = (1.0, 1.0)
    end_relief_exponent: int = 1

    def at(self, zeta: Floats, width_mm: float) -> Floats:
        """Metal removed (n,), mm, >= 0, at zeta (n,): 0 at the end of smaller z, 1 at the other."""
        removed = self.crowning_mm * (2.0 * zeta - 1.0) ** 2
        removed += _sloped(self.slope_mm, zeta)
        for amount, length, from_end in zip(
            self.end_relief_mm, self.end_relief_length_mm, (zeta, 1.0 - zeta), strict=True
        ):
            rest = np.maximum(0.0, 1.0 - from_end * width_mm / length)
            removed += amount * rest**self.end_relief_exponent
        return removed


def _sloped(slope_mm: float, zeta: Floats) -> Floats:
    """Metal removed (n,) by a helix slope, >= 0."""
    return slope_mm * zeta if slope_mm > 0 else -slope_mm * (1.0 - zeta)


@dataclass(frozen=True)
class AxialShape:
    """Shape of a body along its axis.

    Attributes
    ----------
    range_mm : (float, float)
        Positions of both ends on the common axis direction z.
    twist_rad_per_mm : float
        Rotation of the transverse section per length along z, counter-clockwise: tan(beta)/r on
        the reference circle, positive for a right-hand helix.
    lead : LeadModifications
        Metal removed from all flanks, constant over their height.
    tooth_slopes_mm : tuple of float
        Empty, or a further helix slope for each tooth, in the order of pitch errors.
    surface : FlankSurface or None
        Metal removed that varies over the height of the flanks.
    shaft : Shaft or None
        Shaft and bearings; None: the bore does not move.
    regions : tuple of (str, (float, float))
        Names and axial ranges of regions not as wide as the teeth: web, hub, sets of a mesh.
    plane : bool
        Whether the body is computed in the plane, per mm of its width.
    """

    range_mm: tuple[float, float]
    twist_rad_per_mm: float = 0.0
    lead: LeadModifications = LeadModifications()
    tooth_slopes_mm: tuple[float, ...] = ()
    surface: FlankSurface | None = None
    shaft: Shaft | None = None
    regions: tuple[tuple[str, tuple[float, float]], ...] = ()
    plane: bool = False

    @property
    def width_mm(self) -> float:
        """Face width, mm."""
        return self.range_mm[1] - self.range_mm[0]

    def width_in(self, common_mm: float) -> float:
        """Face width; that of the pair, mm, in the plane."""
        return common_mm if self.plane else self.width_mm

    @property
    def middle_mm(self) -> float:
        """Position of the middle of the face width, mm."""
        return 0.5 * (self.range_mm[0] + self.range_mm[1])

    @property
    def hand_sign(self) -> int:
        """1 for a right-hand helix, -1 for a left-hand one, 0 without a helix."""
        return int(np.sign(self.twist_rad_per_mm))

    def without_lead(self) -> AxialShape:
        """The shape without flank modifications and without a shaft, unless it is flexible."""
        shaft = None if self.flexible is None else self.shaft
        return replace(
            self, lead=LeadModifications(), tooth_slopes_mm=(), surface=None, shaft=shaft
        )

    @property
    def flexible(self) -> FlexibleShaft | None:
        """The shaft, if it bends and twists under the teeth."""
        return None if self.shaft is None else self.shaft.flexible

    def in_mirror_image(self) -> AxialShape:
        """The shape behind a mirror along the axis, in which the helix has the other hand."""
        return replace(self, twist_rad_per_mm=-self.twist_rad_per_mm)

    def zeta(self, z_mm: Floats) -> Floats:
        """Relative axial positions: 0 at the end of smaller z, 1 at that of larger z."""
        return (z_mm - self.range_mm[0]) / self.width_mm

    def gap_mm(self, z_mm: Floats) -> Floats:
        """Metal removed by the lead modifications at axial positions (n,), mm."""
        return self.lead.at(self.zeta(z_mm), self.width_mm)

    def tooth_gaps_mm(self, z_mm: Floats) -> Floats:
        """Metal removed by the individual helix slope of each tooth (T, n), mm."""
        zeta = self.zeta(z_mm)
        return np.array([_sloped(slope, zeta) for slope in self.tooth_slopes_mm])


#: A body in the plane, of unit width.
PLANE_SHAPE = AxialShape((-0.5, 0.5), plane=True)


def share_middle(extents_mm: Sequence[tuple[float, float]]) -> bool:
    """Whether axial ranges have the same middle, up to rounding."""
    middles = [low + high for low, high in extents_mm]
    widest = max(high - low for low, high in extents_mm)
    return max(middles) - min(middles) <= TIE * widest


def axial_shape(
    keys: AxialKeys,
    range_mm: tuple[float, float],
    reference_radius_mm: float,
    surface: FlankSurface | None = None,
) -> AxialShape:
    """Shape along the axis from the keys of a body and the range of its teeth.

    The helix angle is that on the reference radius.
    """
    return AxialShape(
        range_mm,
        keys.hand_sign * tan(keys.helix_rad) / reference_radius_mm,
        lead_of(keys),
        tuple(slope / 1000.0 for slope in keys.tooth_helix_slope_um),
        surface,
        _shaft_of(keys, range_mm),
        keys.regions_of(range_mm),
    )


def lead_of(keys: AxialKeys | PlanetFlank) -> LeadModifications:
    """Modifications along the axis from keys."""
    one, two = keys.end_relief_um or (0.0, 0.0)
    lengths = keys.end_relief_length_mm or (1.0, 1.0)
    return LeadModifications(
        crowning_mm=(keys.lead_crowning_um or 0.0) / 1000.0,
        slope_mm=(keys.helix_slope_um or 0.0) / 1000.0,
        end_relief_mm=(one / 1000.0, two / 1000.0),
        end_relief_length_mm=(lengths[0], lengths[1]),
        end_relief_exponent=RELIEF_EXPONENTS[keys.end_relief_shape],
    )


def _shaft_of(keys: AxialKeys, range_mm: tuple[float, float]) -> Shaft | None:
    """Shaft and bearings from the keys of a body."""
    if keys.shaft is None:
        return None
    middle = 0.5 * (range_mm[0] + range_mm[1])
    shaft = build_shaft(keys.shaft, middle)
    if not keys.shaft.is_flexible:
        return shaft
    bore = keys.bore_of(range_mm)
    assert bore is not None  # refused with the keys
    return replace(shaft, flexible=flexible_shaft(keys.shaft, middle, *bore))
