"""How the bodies of a train of three gears are held, and the error of its timing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flankload.contact.meshes import Motion
from flankload.contact.meshes_contact import MeshesContact
from flankload.pairing.train import TrainPairing

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


@dataclass(frozen=True)
class TrainSupports:
    """How the common gear of a train is held.

    Attributes
    ----------
    bearing_N_per_mm : float or None
        Radial stiffness of its bearings; None if they are rigid.
    floating : bool
        Whether it moves along the push of the first mesh without resistance.
    carrier : None
    """

    bearing_N_per_mm: float | None = None
    floating: bool = False
    carrier: ClassVar[None] = None

    def turn_rad(self, pairing: TrainPairing) -> float:
        """Angle from the frame of the motions, whose x axis is a push, to the common one."""
        if not self.floating:
            return 0.0
        x, y = pairing.meshes[0].push
        return float(np.arctan2(y, x))

    def compliances(self, pairing: TrainPairing) -> Floats:
        """(3, 6, 3, 6) Motions of the bodies on their bearings."""
        found, common = np.zeros((3, 6, 3, 6)), pairing.common
        if self.bearing_N_per_mm is not None:
            found[common, :2, common, :2] = np.eye(2) / self.bearing_N_per_mm
        return found

    def motions(self, pairing: TrainPairing) -> tuple[Motion, ...]:
        """Rotation of body 1, of an idler, and displacement of a floating gear."""
        idler = (Motion(pairing.common, sign=-1),) if pairing.is_idler else ()
        moving = (Motion(pairing.common, "x"),) if self.floating else ()
        return (Motion(0), *idler, *moving)

    def loads(self, pairing: TrainPairing, torques_Nmm: Floats) -> Floats:
        """(T, q) Loads of the motions."""
        return np.outer(torques_Nmm, np.eye(1, len(self.motions(pairing))))


TrainContact = MeshesContact[TrainPairing, TrainSupports]


@dataclass(frozen=True)
class TrainErrors:
    """Rotation of body 3 of a train from its place, counter-clockwise."""

    timing_rad: float = 0.0

    def thickness(self, body: int) -> float:
        """Excess of the thickness of teeth: none."""
        return 0.0

    def tilt(self, body: int) -> None:
        """Tilt of a body: none."""

    def displacements(self, pairing: TrainPairing, position_rad: Floats) -> Floats:
        """(P, 3, 3) Displacements x, y (mm) and rotation of each body."""
        found = np.zeros((position_rad.size, 3, 3))
        found[:, 2, 2] = self.timing_rad
        return found
