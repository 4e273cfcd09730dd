"""Common height of the conforming flanks of a spline in three dimensions.

The force on a slice is distributed over strips of this height, in the same way in all slices
(`contact.conforming`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body

#: Number of strips over the height; twice as many change the rotation of the example by 0.02 %.
STRIPS = 24
#: Number of points of a flank for the interpolation of radii, accurate to 1e-8 of the height.
POINTS = 20001


@dataclass(frozen=True, eq=False)
class CommonHeight:
    """The conforming part of both flanks of tooth 0, in N equal strips.

    Attributes
    ----------
    s_mm : two (N,) arrays
        Arc lengths of the middles of the strips on the flanks of shaft and hub.
    strip_mm : float
        Length of a strip along the profile.
    normal : (N, 2) array
        Normals out of the shaft there, in its frame.
    middle_normal, middle_s_mm : (2,) array and (float, float)
        Normal in the middle of the height, and its arc lengths on both flanks.
    tilt : (2,) array
        Displacement of the hub's axis per length along z, from its place at z = `middle_z_mm`, the
        middle of the common face width.
    opened_mm : (N,) array
        Gap between the strips of both flanks by different strains of the bodies.
    """

    s_mm: tuple[Floats, Floats]
    strip_mm: float
    normal: Floats
    middle_normal: Floats
    middle_s_mm: tuple[float, float]
    tilt: Floats
    middle_z_mm: float
    opened_mm: Floats

    @property
    def height_mm(self) -> float:
        """Length of the common height along the profile."""
        return self.strip_mm * self.s_mm[0].size


def common_height(
    shaft: Body,
    hub: Body,
    *,
    tilt: Floats,
    middle_z_mm: float,
    strains: tuple[float, float] = (0.0, 0.0),
) -> CommonHeight:
    """Common height of the equal involutes of shaft and hub.

    Parameters
    ----------
    tilt, middle_z_mm
        As in `CommonHeight`.
    strains : (float, float)
        Uniform strains of both bodies, to which their curves are expanded.

    Raises
    ------
    SceneError
        If there is no common height.
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
    normal = shaft.curve.normal(one)
    # a body expands about its axis by its strain times the place
    outwards = np.einsum("ik,ik->i", shaft.curve.point(places), normal[:-1])
    return CommonHeight(
        s_mm=(places, two[:-1]),
        strip_mm=strip,
        normal=normal[:-1],
        middle_normal=normal[-1],
        middle_s_mm=(float(middle), float(two[-1])),
        tilt=tilt,
        middle_z_mm=middle_z_mm,
        opened_mm=(strains[1] - strains[0]) * outwards,
    )


def _radii(body: Body) -> tuple[Floats, Floats]:
    """Arc lengths and radii of points on the active flank."""
    s = np.linspace(*body.mode_range_mm, POINTS)
    return s, np.hypot(*body.curve.point(s).T)
