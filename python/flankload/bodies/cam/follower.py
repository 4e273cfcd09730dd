"""Bodies of kind "follower": a lever with a hub, fixed at its bore, and a roller or a flat."""

from __future__ import annotations

from math import hypot, pi
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.bodies.body import Body, Flat, Material, Roller
from flankload.bodies.cam.follower_mesh import flat_mesh, roller_mesh
from flankload.bodies.cam.lever import Lever, lever_of
from flankload.bodies.plane import circle, line
from flankload.flank import CurvePiece, FlankCurve, fit_flank_curve

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.scene import Follower


#: Default number of elements along a roller, and its number of modes over that of a gear flank.
ROLLER_ELEMENTS = 24
ROLLER_MODES_FACTOR = 2.0
#: The same for a flat: elements per arm width; modes as a constant and a number per arm width.
FLAT_ELEMENTS_PER_WIDTH = 5.0
FLAT_MODES = 1.6
FLAT_MODES_PER_WIDTH = 0.5


def build_follower(
    spec: Follower, key: str, *, flank_element_mm: float | None, fineness: float
) -> Body:
    """Build a follower; parameters as for `build_cam`."""
    lever = lever_of(spec, key)
    head = lever.head
    if isinstance(head, Roller):
        curve, radius = roller_curve(head), head.arm_mm
        length = head.radius_mm * head.angles_rad[1]
        default_mm = length / ROLLER_ELEMENTS
        modes_factor = ROLLER_MODES_FACTOR
    else:
        curve, radius = flat_curve(head), hypot(head.offset_mm, 0.5 * sum(head.ends_mm))
        length = curve.length_mm
        width = lever.arm_mm[1] - lever.arm_mm[0]
        default_mm = width / FLAT_ELEMENTS_PER_WIDTH
        modes_factor = FLAT_MODES + FLAT_MODES_PER_WIDTH * length / width
    mesh = None
    if not spec.rigid:
        make = roller_mesh if isinstance(head, Roller) else flat_mesh
        element_mm = flank_element_mm or default_mm / fineness
        mesh = make(lever, flank_element_mm=element_mm, finer=max(1.0, default_mm / element_mm))
    return Body(
        kind=spec.kind,
        curve=curve,
        teeth=1,
        material=Material(spec.young_modulus_MPa, spec.poisson_ratio),
        rigid=spec.rigid,
        mesh=mesh,
        mode_range_mm=(0.0, length),
        reference_radius_mm=radius,
        outline=outline_of(lever),
        bore_radius_mm=lever.bore_radius_mm,
        modes_factor=modes_factor,
        touches=head,
    )


def roller_curve(roller: Roller) -> FlankCurve:
    """The free half of a roller that faces the cam, from the arm outwards."""
    low, high = roller.angles_rad
    around = circle(np.array([roller.arm_mm, 0.0]), roller.radius_mm)
    return fit_flank_curve([CurvePiece("flank", around, high, low)])


def flat_curve(flat: Flat) -> FlankCurve:
    """The flat, from the axis outwards; it ends in a corner."""
    along = line(np.array([0.0, flat.offset_mm]), np.array([1.0, 0.0]))
    return fit_flank_curve([CurvePiece("flank", along, *flat.ends_mm)], corner_at_end=True)


def outline_of(lever: Lever, points: int = 121) -> Floats:
    """Contour of a lever, counter-clockwise, with a number of points on each arc."""
    (low, high), hub, head = lever.hub_angles_rad, lever.hub_radius_mm, lever.head
    turn = np.linspace(high, low + 2 * pi, points)
    parts = [hub * directions(turn)]
    if isinstance(head, Roller):
        turn = np.linspace(-head.angles_rad[1], head.angles_rad[1], points)
        parts.append(head.radius_mm * directions(turn) + np.array([head.arm_mm, 0.0]))
    else:
        end = head.ends_mm[1]
        parts.append(np.array([[end, lever.arm_mm[0]], [end, lever.arm_mm[1]]]))
    return np.concatenate(parts)
