"""Free corners of metal at which the pressure modes of a flank end, and their near field.

Between two places at distances d and d' from a corner of interior angle w the flank yields by

    -c0 [ln|s - s'| + psi(w) ln(d + d')],
    psi(w) = pi [sin^2(w/2)/(w + sin w) + cos^2(w/2)/(w - sin w)] - 1                          (W1)

along its normal, per force and width: by the logarithm of a half-plane, and by that of a mirror
image of the load behind the corner. A force at the apex of a wedge, normal to its flank, moves the
flank at a distance r by -(2/E') [sin^2(w/2)/(w + sin w) + cos^2(w/2)/(w - sin w)] ln r: it is held
by radial stress (Johnson, Contact Mechanics, section 5.1), and its parts are those along the
bisector and across it. With c0 = 2/(pi E') that is -c0 (1 + psi) ln r, which both logarithms sum up
to for d' = 0. Both leave out what stays finite at the corner: the modes carry it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.corner_angle import SMOOTH

if TYPE_CHECKING:
    from flankload.bodies.body import Body

#: Metal that turns by less than this is no corner, degrees: straight-sided elements on a rounding
#: turn by a few, and psi is below 0.0002 there.
LEAST_TURN = 5.0
#: The curve of a sharp flank ends with its modes, to this part of their range.
SAME_PLACE = 1e-6


def image_strength(angle_deg: float) -> float:
    """Strength psi of the mirror image behind a corner of an interior angle > 0, Eq. (W1).

    0 where the metal turns by less than 5 degrees, or inwards.
    """
    if angle_deg > SMOOTH - LEAST_TURN:
        return 0.0
    w = float(np.radians(angle_deg))
    axial, across = np.sin(0.5 * w) ** 2, np.cos(0.5 * w) ** 2
    return float(np.pi * (axial / (w + np.sin(w)) + across / (w - np.sin(w))) - 1.0)


def image_strengths(body: Body) -> tuple[float, float]:
    """Psi at the low and the high end of the range of a body's modes."""
    low, high = corner_angles(body)
    return image_strength(low), image_strength(high)


def along_strength(angle_deg: float) -> float:
    """Strength psi_nt of the image of a force along the flank, towards the corner, Eq. (W3).

    By that force the flank moves along its normal by -c0 psi_nt ln(d + d') beside the jump.
    -pi sin^2 w/(w^2 - sin^2 w) with the interior angle w > 0 of the metal; 0 without a corner.
    """
    if not image_strength(angle_deg):
        return 0.0
    w = float(np.radians(angle_deg))
    return float(-np.pi * np.sin(w) ** 2 / (w**2 - np.sin(w) ** 2))


def along_strengths(body: Body) -> tuple[float, float]:
    """Psi_nt at the low and the high end of a body's modes, of a force towards the high end."""
    low, high = corner_angles(body)
    return -along_strength(low), along_strength(high)


def corner_angles(body: Body) -> tuple[float, float]:
    """Interior angles of the metal at the low and the high end of the modes of a body, degrees.

    180 without a corner. The body has elements, or a compliance that tells the angles.
    """
    if body.given is not None:
        return body.given.corner_angles_deg
    if body.mesh is None or body.curve.closed:
        return SMOOTH, SMOOTH
    return body.mesh.end_angles_deg[0], tip_angle(body)


def tip_angle(body: Body) -> float:
    """Interior angle of the metal at the high end of the modes of a body with elements, degrees."""
    if body.mesh is None or body.curve.closed or not _tip_is_sharp(body):
        return SMOOTH
    return body.mesh.end_angles_deg[1]


def _tip_is_sharp(body: Body) -> bool:
    """Whether the flank ends with its modes: no rounding and no chamfer follows.

    Behind these the corner is another one, further away than the modes end: it has no image.
    """
    low, high = body.mode_range_mm
    return body.curve.length_mm - high <= SAME_PLACE * (high - low)
