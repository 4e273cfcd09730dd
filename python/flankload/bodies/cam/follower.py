"""Bodies of kind "follower": a lever with a hub, fixed at its bore, and a roller or a flat."""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, hypot, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.bodies.body import Body, Flat, Material, Roller
from flankload.bodies.cam.follower_mesh import flat_mesh, roller_mesh
from flankload.bodies.plane import circle, line
from flankload.flank import CurvePiece, FlankCurve, fit_flank_curve
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.scene import Follower


#: Default hub radius over bore radius; least hub radius over largest |y| of the arm.
HUB_RATIO, LEAST_HUB_RATIO = 1.6, 1.25
#: Limits of arm width over roller radius, outside which the blocks of the mesh are too distorted.
LEAST_ARM_RATIO, LARGEST_ARM_RATIO = 0.2, 1.6
FLAT_ARM_RATIO = 0.2
#: Least lever arm of a force on the roller over the distance from the follower's axis O1; below it,
#: the roller is nearly tangent to circles about O1.
LEAST_LEVER_RATIO = 0.03
#: Default number of elements along a roller, and its number of modes over that of a gear flank.
ROLLER_ELEMENTS = 24
ROLLER_MODES_FACTOR = 2.0
#: The same for a flat: elements per arm width; modes as a constant and a number per arm width.
FLAT_ELEMENTS_PER_WIDTH = 5.0
FLAT_MODES = 1.6
FLAT_MODES_PER_WIDTH = 0.5


@dataclass(frozen=True)
class Lever:
    """Shape of a follower in its own frame: arm along x, cam on the side of larger y; mm.

    Attributes
    ----------
    bore_radius_mm, hub_radius_mm : float
    arm_mm : (float, float)
        Range of y of the arm.
    head : Roller or Flat
    """

    bore_radius_mm: float
    hub_radius_mm: float
    arm_mm: tuple[float, float]
    head: Roller | Flat

    @property
    def hub_angles_rad(self) -> tuple[float, float]:
        """Polar angles at which the lower and upper edge of the arm leave the hub."""
        low, high = (asin(y / self.hub_radius_mm) for y in self.arm_mm)
        return low, high


def build_follower(
    spec: Follower, key: str, *, flank_element_mm: float | None, fineness: float
) -> Body:
    """Build a follower; parameters as of `build_cam`."""
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


def lever_of(spec: Follower, key: str) -> Lever:
    """Shape of a follower with default sizes, checked for consistency of arm, hub and head."""
    if spec.has_roller:
        assert spec.roller_radius_mm is not None
        radius = spec.roller_radius_mm
        width = spec.arm_width_mm or radius
        least, largest = LEAST_ARM_RATIO * radius, LARGEST_ARM_RATIO * radius
        if not least <= width <= largest:
            expected = f"{LEAST_ARM_RATIO:g} to {LARGEST_ARM_RATIO:g} of {key}.roller_radius_mm "
            refuse(f"{key}.arm_width_mm", f"{expected}({least:g} to {largest:g})", f"{width:g}")
        arm = (-0.5 * width, 0.5 * width)
    else:
        assert spec.flat_to_mm is not None
        assert spec.flat_offset_mm is not None
        width = spec.arm_width_mm or FLAT_ARM_RATIO * spec.flat_to_mm
        arm = (spec.flat_offset_mm - width, spec.flat_offset_mm)
    bore, held = 0.5 * spec.bore_diameter_mm, LEAST_HUB_RATIO * max(map(abs, arm))
    hub = 0.5 * (spec.hub_diameter_mm or 0.0) or max(HUB_RATIO * bore, held)
    if hub < held:
        expected = f"at least {2 * held:g}, so that the hub holds the arm (y from {arm[0]:g} to "
        refuse(f"{key}.hub_diameter_mm", f"{expected}{arm[1]:g} mm)", f"{2 * hub:g}")
    head = _roller(spec, key, hub, arm[1]) if spec.has_roller else _flat(spec, key, hub)
    return Lever(bore, hub, arm, head)


def _roller(spec: Follower, key: str, hub: float, half_width: float) -> Roller:
    arm, radius = spec.arm_mm, spec.roller_radius_mm
    assert arm is not None
    assert radius is not None
    if arm < hub + radius:
        expected = f"more than the radii of hub and roller together, {hub + radius:g}"
        refuse(f"{key}.arm_mm", expected, f"{arm:g}")
    # |P x n| = arm sin(angle) compared with the distance from O1
    end = asin(LEAST_LEVER_RATIO * (arm + radius) / arm)
    return Roller(arm, radius, (end, pi - asin(half_width / radius)))


def _flat(spec: Follower, key: str, hub: float) -> Flat:
    low, high, offset = spec.flat_from_mm, spec.flat_to_mm, spec.flat_offset_mm
    assert low is not None
    assert high is not None
    assert offset is not None
    beside = sqrt(max(0.0, hub**2 - offset**2))
    if low < beside:
        expected = f"at least {beside:.4f}, where the arm leaves the hub of radius {hub:g}"
        refuse(f"{key}.flat_from_mm", expected, f"{low:g}")
    return Flat(offset, (low, high))


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
