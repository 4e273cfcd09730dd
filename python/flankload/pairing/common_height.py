"""Common height of the flanks of a spline in three dimensions, and the tilt of the hub's axis.

Flanks of a spline lie on each other over a height, so that a slice has no place of contact. Its
force is spread over strips of that height, in the same way in all slices (`contact.conforming`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.errors import SceneError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import Body
    from flankload.pairing.slices import Slices
    from flankload.pairing.spline_fit import SplineFit

    Floats = NDArray[np.float64]

#: Strips over the height: twice as many change the rotation of the example by 0.02 %.
STRIPS = 24
#: Points of a flank between which radii are interpolated, 1e-8 of the height.
POINTS = 20001


@dataclass(frozen=True, eq=False)
class CommonHeight:
    """The part of both flanks of tooth 0 that lie on each other, in N equal strips.

    Attributes
    ----------
    s_mm : two (N,) arrays
        Arc lengths of the middles of the strips on the flanks of shaft and hub.
    strip_mm : float
        Length of a strip along the profile.
    normal : (N, 2) array
        Normals out of the shaft there, in its frame.
    middle_mm, middle_normal, middle_s_mm : (2,) arrays and (float, float)
        Place, normal and arc lengths on both flanks of the middle of the height.
    axis_mm, tilt : (2,) arrays
        Place of the hub's axis at z = `middle_z_mm`, the middle of the common face width, from the
        shaft's, and its displacement per length along z.
    """

    s_mm: tuple[Floats, Floats]
    strip_mm: float
    normal: Floats
    middle_mm: Floats
    middle_normal: Floats
    middle_s_mm: tuple[float, float]
    axis_mm: Floats
    tilt: Floats
    middle_z_mm: float

    @property
    def height_mm(self) -> float:
        """Length of the common height along the profile."""
        return self.strip_mm * self.s_mm[0].size

    def gap_mm(self, turn_rad: Floats, z_mm: Floats, spread: Floats) -> Floats:
        """Gap (S, J) by offset and tilt of the hub's axis, along the normals of the shaft.

        A rotation vector w of the hub about the middle moves its point (x, y, z) by w x (x, y, z),
        in the section by z (w_y, -w_x): as the axis there, so that the gap is that times n.
        `turn_rad` (S,) are the angles of the teeth of the shaft in space, `z_mm` (J,) the slices,
        `spread` (N,) the part of the force on each strip.
        """
        axis = self.axis_mm + np.outer(z_mm - self.middle_z_mm, self.tilt)
        return np.asarray(turned(spread @ self.normal, turn_rad) @ axis.T)


def common_height(
    shaft: Body,
    hub: Body,
    *,
    offset_mm: float,
    misalignment_rad: float,
    direction_rad: float,
    middle_z_mm: float,
) -> CommonHeight:
    """Common height of shaft and hub, of equal involutes.

    The axes are `offset_mm` apart along x. `misalignment_rad` is the angle between them; the hub's
    axis leans towards larger z in the direction of the polar angle `direction_rad`, about the axial
    position `middle_z_mm`. Raises a SceneError if roundings or chamfers leave no common height.
    """
    (s_1, r_1), (s_2, r_2) = _radii(shaft), _radii(hub)
    low, high = max(r_1.min(), r_2.min()), min(r_1.max(), r_2.max())
    if not low < high:
        raise SceneError(
            key="body_1.tip_diameter_mm",
            expected=f"more than {2 * low:.4f}, so that the flanks lie on each other between both "
            "fillets and tip roundings",
            found=f"a flank that ends at {2 * high:.4f}",
        )
    start, end = np.interp([low, high], r_1, s_1)
    strip = float(end - start) / STRIPS
    places = start + strip * (np.arange(STRIPS) + 0.5)
    middle = 0.5 * (start + end)
    one = np.append(places, middle)
    two = np.interp(np.interp(one, s_1, r_1), r_2[::-1], s_2[::-1])
    normal, middle_mm = shaft.curve.normal(one), shaft.curve.point([middle])[0]
    direction = np.array([np.cos(direction_rad), np.sin(direction_rad)])
    return CommonHeight(
        s_mm=(places, two[:-1]),
        strip_mm=strip,
        normal=normal[:-1],
        middle_mm=middle_mm,
        middle_normal=normal[-1],
        middle_s_mm=(float(middle), float(two[-1])),
        axis_mm=np.array([offset_mm, 0.0]),
        tilt=misalignment_rad * direction,
        middle_z_mm=middle_z_mm,
    )


def tilt_notes(fit: SplineFit | None, slices: Slices) -> list[str]:
    """Note on coast flanks of a spline that would touch before all teeth carry, on tilted axes."""
    height = slices.conforming
    if fit is None or height is None or not height.tilt.any():
        return []
    width_mm = float(slices.width_mm.sum())
    moved = fit.offset_mm + 0.5 * width_mm * float(np.hypot(*height.tilt))
    if 2.0 * moved <= fit.normal_backlash_mm:
        return []
    said = (
        f"the normal backlash of {1000 * fit.normal_backlash_mm:.1f} um is less than twice the "
        f"{1000 * moved:.1f} um by which misalignment and offset move the ends of the flanks: "
        "before all teeth carry, coast flanks would touch, too; only the working flanks are looked "
        "at"
    )
    return [said]


def _radii(body: Body) -> tuple[Floats, Floats]:
    """Arc lengths and radii of points of the active flank."""
    s = np.linspace(*body.mode_range_mm, POINTS)
    return s, np.hypot(*body.curve.point(s).T)
