"""Sites of coast flanks, described in the mirror image about the line of centres.

In the mirror image coast flanks are working flanks: for teeth with equal sides they are the same
curve, on bodies that turn in the opposite direction. The coast flank of a tooth of body 1 faces the
tooth of body 2 that meets the next tooth of body 1 with its working flank; if body 2 has internal
teeth, it faces the other side of its own space.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import Body


@dataclass(frozen=True)
class CoastSites:
    """S sites of coast flanks; each is named by the tooth of body 1, like a pair.

    For each body the tooth (S,) at each site, and its angle (S,) in the mirrored frame of the body,
    relative to the negative of the body's angle.
    """

    site_teeth: tuple[NDArray[np.int64], NDArray[np.int64]]
    site_angles_rad: tuple[NDArray[np.float64], NDArray[np.float64]]


def coast_sites(numbers: NDArray[np.int64], body_1: Body, body_2: Body) -> CoastSites:
    """Sites of the coast flanks of some teeth of body 1, which pair numbers (S,) name.

    Both flanks of a tooth are assumed to be equal. Pitch errors are defined for working flanks;
    they do not move coast flanks.
    """
    assert body_1.involute is not None
    assert body_2.involute is not None
    sense = body_2.outward
    other = numbers - 1 if sense > 0 else numbers
    return CoastSites(
        site_teeth=(numbers % body_1.teeth, -sense * other % body_2.teeth),
        site_angles_rad=(
            -2 * np.pi * numbers / body_1.teeth - 2 * body_1.involute.turn_rad,
            sense * 2 * np.pi * other / body_2.teeth - 2 * body_2.involute.turn_rad,
        ),
    )
