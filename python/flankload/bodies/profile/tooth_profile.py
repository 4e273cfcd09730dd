"""The profile of an external or internal tooth: a curve of root fillet, flank and tip."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2, pi
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions, turned
from flankload.bodies.plane import mirrored
from flankload.bodies.profile.gear_tip import flank_and_tip
from flankload.bodies.profile.involute import Involute, InvoluteFlank, Modifications
from flankload.flank import ACTIVE, CurvePiece, FlankCurve, fit_flank_curve, fit_tolerance_mm

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.bodies.profile.gear_tip import FormPoint
    from flankload.flank import Place
    from flankload.scene.involute import InvoluteKeys

    #: A part of a fillet: points as a function of a parameter, and the parameter at both ends.
    Part = tuple[Place, float, float]

#: Number of points of the outline in each interval of the curve, and on the root and tip arcs.
POINTS, ARC_POINTS = 4, 5


@dataclass(frozen=True)
class ToothProfile:
    """Profile of a tooth.

    Attributes
    ----------
    curve : FlankCurve
        The working flank: fillet from the root circle, flank, tip.
    involute : Involute
        Radii and angles.
    teeth : int
    root_half_angle_rad : float
        Polar angle at which the fillet meets the root circle.
    """

    curve: FlankCurve
    involute: Involute
    teeth: int
    root_half_angle_rad: float

    @property
    def mode_range_mm(self) -> tuple[float, float]:
        """Arc lengths of the active flank, on which pressure modes are defined.

        Fillet and tip rounding are excluded: few modes could not represent the pressure where the
        normal turns.
        """
        return self.curve.range_of(*ACTIVE)

    @property
    def root_radius_mm(self) -> float:
        """Radius of the root circle, mm."""
        return self.involute.root_radius_mm

    @property
    def tip_radius_mm(self) -> float:
        """Radius of the tip circle, mm."""
        return self.involute.tip_radius_mm

    def rotated(self, angle: float) -> ToothProfile:
        """Return the profile rotated counter-clockwise about the axis by an angle in rad."""
        turn = self.involute.turn_rad + angle
        return replace(
            self, curve=self.curve.rotated(angle), involute=replace(self.involute, turn_rad=turn)
        )

    def outline(self) -> Floats:
        """Toothed contour (k, 2) of one sector from cut to cut, counter-clockwise, mm."""
        involute, breaks = self.involute, self.curve.breaks
        inside = breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(POINTS) / POINTS
        s = np.append(inside, breaks[-1])
        flank = self.curve.rotated(-involute.turn_rad).point(s)
        center = involute.tooth_center_rad
        cut = center + involute.outward * pi / self.teeth
        root = np.linspace(cut, self.root_half_angle_rad, ARC_POINTS)[:-1]
        tip = np.linspace(atan2(flank[-1, 1], flank[-1, 0]), center, ARC_POINTS)[1:]
        half = np.concatenate(
            [self.root_radius_mm * directions(root), flank, self.tip_radius_mm * directions(tip)]
        )
        whole = np.concatenate([half, mirrored(half[-2::-1], center)])[:: -involute.outward]
        return turned(whole, involute.turn_rad)


def profile_curve(
    fillet: Sequence[Part],
    flank: InvoluteFlank,
    involute: Involute,
    start: FormPoint,
    spec: InvoluteKeys,
    key: str,
) -> FlankCurve:
    """The curve of fillet, flank and tip.

    `fillet`: its parts from the root circle to the flank without modifications; others as of
    `flank_and_tip`.
    """

    def pieces(flank: InvoluteFlank) -> list[CurvePiece]:
        below = [CurvePiece("fillet", *part) for part in _following(fillet, flank, start)]
        return [*below, *flank_and_tip(flank, involute, start, spec, key)]

    modified = pieces(flank)
    # tolerance of the flank without modifications: designs with other reliefs share cached fits
    plain = pieces(replace(flank, modifications=Modifications.none()))
    return fit_flank_curve(
        modified, tolerance_mm=fit_tolerance_mm(plain), corner_at_end=spec.tip_radius_mm is None
    )


def _following(fillet: Sequence[Part], flank: InvoluteFlank, start: FormPoint) -> list[Part]:
    """The fillet, shifted smoothly to the start of a modified flank.

    The start on the root circle and the tangents at both ends are unchanged.
    """
    if not (flank.modifications.crowning_mm or flank.modifications.root_relief_mm):
        return list(fillet)
    place, first, last = fillet[-1]
    moved, span = flank.point(start.roll) - place(np.array([last]))[0][0], last - first

    def moved_place(u: Floats) -> tuple[Floats, Floats, Floats]:
        point, along, bend = place(u)
        x = ((u - first) / span)[:, None]
        return (
            point + x**3 * (10 - 15 * x + 6 * x**2) * moved,
            along + 30 * x**2 * (1 - x) ** 2 / span * moved,
            bend + 60 * x * (1 - x) * (1 - 2 * x) / span**2 * moved,
        )

    return [*fillet[:-1], (moved_place, first, last)]
