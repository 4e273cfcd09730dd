"""Free end faces of a prism: the angle of the metal beside them and the strength of their image.

Beside a free end a flank yields more than a half-space does. The near field of a load has a mirror
image behind the end, psi times as strong. The strengths were measured on finite elements: at an
edge of 90 degrees by Poisson's ratio, and at nu = 0.3 by the angle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.bodies.body import Body

#: psi at a right angle, measured, by Poisson's ratio.
RIGHT_ANGLE = ((0.0, 0.2, 0.3, 0.4, 0.45), (0.94, 1.13, 1.30, 1.53, 1.69))
#: 1.33 exp(-0.062 (angle - 90)), fitted at nu = 0.3 to angles from 57 degrees on.
AT_STEEL, STEEL_RATIO, DECAY_PER_DEGREE = 1.33, 0.3, 0.062
#: Sharper edges were not measured: the image leaves 3.4 % at 57 degrees, and more below.
LEAST_ANGLE = 50.0


def end_strength(angle_deg: float, poisson_ratio: float) -> float:
    """Strength psi of the image behind a free end.

    Parameters
    ----------
    angle_deg : float
        Between flank and end face, inside the metal.
    """
    at_right_angle, at_steel = np.interp([poisson_ratio, STEEL_RATIO], *RIGHT_ANGLE)
    by_angle = AT_STEEL * np.exp(-DECAY_PER_DEGREE * (angle_deg - 90.0))
    return float(by_angle * at_right_angle / at_steel)


def edge_angles(body: Body, twist: float) -> tuple[float, float]:
    """Angles of the metal between the flank and the low and high end face, degrees.

    They are 90 +- asin(n.e) with e the direction out of the end: obtuse where the flank's normal
    leans out of it. n.e = -+ kappa l cos(beta_b), l the lever of the transverse normal about the
    axis, in the middle of the flank; tan(beta_b) = |kappa l|.

    Parameters
    ----------
    twist : float
        kappa, rad/mm.

    Returns
    -------
    (float, float)

    Raises
    ------
    SceneError
        Below 50 degrees.
    """
    leaning = float(np.degrees(np.arctan(-twist * body.normal_lever_mm)))
    angles = 90.0 - leaning, 90.0 + leaning
    if min(angles) < LEAST_ANGLE:
        raise SceneError(
            key="helix_angle_deg",
            expected=f"at least {LEAST_ANGLE:g} degrees between flank and end face",
            found=f"{min(angles):.3g} degrees",
        )
    return angles
