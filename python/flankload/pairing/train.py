"""Both gear meshes of a train of external gears, and their phases.

The axis of body 1 is at the origin of the common frame, that of its mate in the first mesh on the
positive x axis. Body 1 turns counter-clockwise.

Two pinions on a wheel are two pairs in frames turned by their polar angles. The torque turns an
idler clockwise, so that its coast flanks drive body 2: their mesh is a pair in the mirror image, in
which they turn counter-clockwise. Its frame is at the idler, with the axis of body 2 on its
positive x axis and the sign of y reversed.

The halves of double helical gears are two pairs in one frame. The half of smaller z is described in
the mirror image about the middle of the groove, in which its helix has the hand of the other half:
both are alike, and z increases away from the groove in each.
"""

from __future__ import annotations

from math import pi, radians
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions, turned
from flankload.base.rounding import round_up
from flankload.pairing.pairing import teeth_until_alike
from flankload.pairing.placed_mesh import (
    MeshPlace,
    PlacedMesh,
    PlacedMeshes,
    named_warnings,
    paired,
)
from flankload.pairing.slices import reached_positions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body

#: Tables of the bodies.
NAMES = ("body_1", "body_2", "body_3")


class TrainPairing(PlacedMeshes):
    """Both gear meshes of a train.

    Bodies of double helical gears are both halves of the pinion, then those of the wheel.
    """

    @property
    def tables(self) -> tuple[int, ...]:
        """(B,) Number of the table of each body, from 0; halves share one."""
        halves = len(self.axes_mm) // len(self.teeth)
        return tuple(table for table in range(len(self.teeth)) for _ in range(halves))

    @property
    def is_double_helical(self) -> bool:
        """Whether both meshes are the halves of one pair."""
        return len(self.axes_mm) > len(self.teeth)

    def title(self, m: int) -> str:
        """Words for a mesh."""
        return f"half {m + 1}" if self.is_double_helical else super().title(m)

    @property
    def common(self) -> int:
        """Number of the gear in both meshes, from 0; of double helical gears the pinion's half."""
        one, two = (mesh.members for mesh in self.meshes)
        return next((body for body in one if body in two), 0)

    @property
    def is_idler(self) -> bool:
        """Whether the common gear turns freely between the others."""
        return self.is_image(1)


def repeating_pitches(bodies: Sequence[Body]) -> int:
    """Tooth pitches of body 1 after which everything repeats."""
    return int(np.lcm.reduce([teeth_until_alike(body) for body in bodies]))


def idler_pairing(
    bodies: tuple[Body, ...],
    angle_deg: float,
    distances_mm: tuple[float, float],
    position_rad: Floats,
) -> TrainPairing:
    """Body 1 drives body 3, which drives body 2.

    Parameters
    ----------
    bodies : Body, Body, Body
        Bodies 1, 2, 3.
    angle_deg : float
        At the axis of body 3, counter-clockwise from body 1 to body 2.
    distances_mm : (float, float)
        Centre distances of both meshes.
    position_rad : (P,) array

    Raises
    ------
    SceneError
        If flanks cannot mesh.
    """
    driver, driven, idler = bodies
    names = ("body_1", "body_3"), ("body_3", "body_2")
    one = paired(names[0], (driver, idler), distances_mm[0])
    two = paired(names[1], (idler, driven), distances_mm[1])
    assert idler.involute is not None
    frame, rate = pi + radians(angle_deg), driver.teeth / idler.teeth
    # the idler's frame in the mirror image at position zero of its mesh with body 1
    mirrored = frame - one.turns_at_zero_rad[1] - 2.0 * idler.involute.turn_rad
    base = (mirrored - two.turns_at_zero_rad[0]) / two.pitch_rad
    # half a pitch is no decision: phases are above -1/2, at most 1/2
    back = -int(round_up(base - 0.5))
    offset = (base + back) * two.pitch_rad
    reached = reached_positions(position_rad, driver)
    first = MeshPlace((driver, idler), (0, 0), (1, -1), (-1, 1)).of(one, reached)
    place = MeshPlace((idler, driven), (-back, 0), (-1, 1), (0, 1))
    image = idler.in_mirror_image()
    second = place.of(two, reached_positions(offset + rate * position_rad, image))
    centers = np.array([[0.0, 0.0], [distances_mm[0], 0.0], [distances_mm[0], 0.0]])
    centers[1] += distances_mm[1] * directions(np.array([frame]))[0]
    return TrainPairing(
        meshes=(
            PlacedMesh(names[0], first, 0.0, 1.0, 0.0, 1, (0, 2)),
            PlacedMesh(names[1], second, offset, rate, frame, -1, (2, 1)),
        ),
        axes_mm=centers,
        teeth=(driver.teeth, driven.teeth, idler.teeth),
        warnings=(
            *named_warnings(one, names[0], "bodies 1 and 3"),
            *named_warnings(two, names[1], "bodies 3 and 2"),
        ),
    )


def two_pinions_pairing(
    bodies: tuple[Body, ...],
    angle_deg: float,
    distances_mm: tuple[float, float],
    position_rad: Floats,
) -> TrainPairing:
    """Body 1 drives bodies 2 and 3; parameters as for `idler_pairing`, the angle is at body 1."""
    wheel, *pinions = bodies
    names = ("body_1", "body_2"), ("body_1", "body_3")
    meshes: list[PlacedMesh] = []
    warnings: list[str] = []
    for k, (own, pinion) in enumerate(zip(names, pinions, strict=True)):
        angle, distance = (0.0, angle_deg)[k], distances_mm[k]
        pair = paired(own, (wheel, pinion), distance)
        # whole turns of the angle stay exact: the phase is that of the teeth of the wheel
        part = -wheel.teeth * angle % 360.0
        part -= 360.0 if part > 180.0 else 0.0
        tooth = round((part + wheel.teeth * angle) / 360.0)
        offset = part / 360.0 * pair.pitch_rad
        place = MeshPlace((wheel, pinion), (tooth, 0), (1, -1), (-1, 1))
        placed = place.of(pair, reached_positions(offset + position_rad, wheel))
        meshes.append(PlacedMesh(own, placed, offset, 1.0, radians(angle), 1, (0, k + 1)))
        warnings += named_warnings(pair, own, f"bodies 1 and {own[1][-1]}")
    centers = np.zeros((3, 2))
    centers[1] = distances_mm[0], 0.0
    centers[2] = turned(np.array([distances_mm[1], 0.0]), np.array([radians(angle_deg)]))[0]
    return TrainPairing(
        meshes=(meshes[0], meshes[1]),
        axes_mm=centers,
        teeth=(wheel.teeth, pinions[0].teeth, pinions[1].teeth),
        warnings=tuple(warnings),
    )


def double_helical_pairing(
    bodies: tuple[Body, ...],
    angle_deg: float,
    distances_mm: tuple[float, float],
    position_rad: Floats,
) -> TrainPairing:
    """Both halves of body 1 drive those of body 2; parameters as for `idler_pairing`."""
    pinion, wheel = bodies
    names, distance = ("body_1", "body_2"), distances_mm[0]
    pair = paired(names, (pinion, wheel), distance)
    place = MeshPlace((pinion, wheel), (0, 0), (1, -1), (-1, 1))
    placed = place.of(pair, reached_positions(position_rad, pinion))
    halves = ((0, 2), (1, 3))
    return TrainPairing(
        meshes=tuple(PlacedMesh(names, placed, 0.0, 1.0, 0.0, 1, members) for members in halves),
        axes_mm=np.outer([0.0, 0.0, distance, distance], [1.0, 0.0]),
        teeth=(pinion.teeth, wheel.teeth),
        warnings=named_warnings(pair, names, "bodies 1 and 2"),
    )
