"""Near field of the free corners at the ends of a flank's pressure modes.

Along a flank that ends at a corner of interior angle w, a force at the distance d' from the corner
causes, per force and width, the normal displacement at the distance d

    -c0 [ln|s - s'| + psi(w) ln(d + d')],
    psi(w) = pi [sin^2(w/2)/(w + sin w) + cos^2(w/2)/(w - sin w)] - 1                          (W1)

the logarithm of a half-plane and that of a mirror image of the load behind the corner. A force
normal to the flank at the apex of a wedge causes radial stress only (Johnson, Contact Mechanics,
section 5.1) and moves the flank at a distance r by
-(2/E') [sin^2(w/2)/(w + sin w) + cos^2(w/2)/(w - sin w)] ln r, with parts along and across the
bisector. With c0 = 2/(pi E') this is -c0 (1 + psi) ln r, the sum of both logarithms for d' = 0. The
modes represent the part that remains finite at the corner.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.corner_angle import STRAIGHT_ANGLE

if TYPE_CHECKING:
    from collections.abc import Iterable

    from flankload.bodies.body import Body

#: Least turn of the surface at a corner, degrees; straight-sided elements on a rounding turn by
#: less, and psi is below 0.0002 there.
LEAST_CORNER_TURN = 5.0
#: Largest distance of the end of a sharp flank from the end of its modes, over their range.
END_TOLERANCE = 1e-6


def image_strength(angle_deg: float) -> float:
    """Strength psi of the image behind a corner with an interior angle, Eq. (W1); 0 if smooth."""
    if angle_deg > STRAIGHT_ANGLE - LEAST_CORNER_TURN:
        return 0.0
    w = float(np.radians(angle_deg))
    axial, across = np.sin(0.5 * w) ** 2, np.cos(0.5 * w) ** 2
    return float(np.pi * (axial / (w + np.sin(w)) + across / (w - np.sin(w))) - 1.0)


def image_strengths(body: Body) -> tuple[float, float]:
    """Psi at the low and the high end of a body's modes."""
    low, high = corner_angles(body)
    return image_strength(low), image_strength(high)


def along_strength(angle_deg: float) -> float:
    """Strength psi_nt of the image of a tangential force towards the corner, Eq. (W3).

    Beside the jump, this force causes the normal displacement -c0 psi_nt ln(d + d') with
    psi_nt = -pi sin^2 w/(w^2 - sin^2 w) and the interior angle w; 0 without a corner.
    """
    if not image_strength(angle_deg):
        return 0.0
    w = float(np.radians(angle_deg))
    return float(-np.pi * np.sin(w) ** 2 / (w**2 - np.sin(w) ** 2))


def along_strengths(body: Body) -> tuple[float, float]:
    """Psi_nt at the low and the high end of a body's modes, for a force towards the high end."""
    low, high = corner_angles(body)
    return -along_strength(low), along_strength(high)


def corner_angles(body: Body) -> tuple[float, float]:
    """Interior angles at the low and the high end of a body's modes, degrees; 180: no corner.

    They are those of the elements, or of the imported compliance.
    """
    if body.imported is not None:
        return body.imported.corner_angles_deg
    if body.mesh is None or body.curve.closed:
        return STRAIGHT_ANGLE, STRAIGHT_ANGLE
    return body.mesh.end_angles_deg[0], tip_angle(body)


def tip_angle(body: Body) -> float:
    """Interior angle at the high end of the modes of a body with elements, degrees."""
    if body.mesh is None or body.curve.closed or not _tip_is_sharp(body):
        return STRAIGHT_ANGLE
    return body.mesh.end_angles_deg[1]


def forces_turn(bodies: Iterable[Body]) -> bool:
    """Whether forces turn over sharp tips of bodies that touch; not on conforming slices."""
    return any(has_sharp_tip(each) and (each.axial.plane or not each.conforms) for each in bodies)


def has_sharp_tip(body: Body) -> bool:
    """Whether a flank, elastic or rigid, ends in a sharp corner."""
    if body.imported is not None:
        return image_strengths(body)[1] > 0.0
    return not body.curve.closed and _tip_is_sharp(body)


def _tip_is_sharp(body: Body) -> bool:
    """Whether the flank ends with its modes, without a rounding or chamfer.

    A corner behind a rounding or chamfer is too far from the end of the modes for an image.
    """
    low, high = body.mode_range_mm
    return body.curve.length_mm - high <= END_TOLERANCE * (high - low)
