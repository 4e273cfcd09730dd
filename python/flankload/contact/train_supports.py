"""How the bodies of a train are held, and errors of their places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.meshes import Motion
from flankload.pairing.train import TrainPairing

if TYPE_CHECKING:
    from flankload.base.arrays import Floats

#: Forces, moments and motions in the mirror image of a transverse plane.
MIRRORED = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True)
class TrainSupports:
    """How the common gear of a train, or a double helical pinion, is held.

    Halves of a double helical pinion are bodies of their own on common bearings. Without axial
    bearings both turn independently, each under half of the torque: a displacement along the axis
    moves the flanks of both as opposite rotations do, so that its axial forces are in balance.

    Attributes
    ----------
    bearing_N_per_mm, tilt_Nmm_per_rad, axial_N_per_mm : float or None
        Radial, tilting and axial stiffness of its bearings; None if they are rigid.
    floating : bool
        Whether the common gear moves along the push of the first mesh without resistance, or a
        double helical pinion along its axis.
    arm_mm : float
        Distance of the middle of the groove of double helical gears from that of a half.
    groove : (6, 6) array or None
        Motion of a half by the shaft from the middle of the groove, in its own frame.
    twist_rad_per_Nmm : float
        Rotation of half 2 relative to half 1, where the torque comes in, per torque.
    """

    bearing_N_per_mm: float | None = None
    tilt_Nmm_per_rad: float | None = None
    axial_N_per_mm: float | None = None
    floating: bool = False
    arm_mm: float = 0.0
    groove: Floats | None = None
    twist_rad_per_Nmm: float = 0.0

    def carried(self, pairing: TrainPairing) -> range:
        """Both halves of a double helical pinion."""
        return range(2 if pairing.is_double_helical else 0)

    def turn_rad(self, pairing: TrainPairing) -> float:
        """Angle from the frame of the motions, whose x axis is a push, to the common one."""
        if not self.floating or pairing.is_double_helical:
            return 0.0
        x, y = pairing.meshes[0].push
        return float(np.arctan2(y, x))

    def compliances(self, pairing: TrainPairing) -> Floats:
        """(B, 6, B, 6) Motions of the bodies on their bearings."""
        count, own = len(pairing.tables), np.zeros(6)
        known = (self.bearing_N_per_mm, slice(2)), (self.tilt_Nmm_per_rad, slice(3, 5))
        for stiffness, at in (*known, (self.axial_N_per_mm, slice(2, 3))):
            own[at] = 0.0 if stiffness is None else 1.0 / stiffness
        found = np.zeros((count, 6, count, 6))
        if not pairing.is_double_helical:
            found[pairing.common, :, pairing.common] = np.diag(own)
            return found
        # wrenches on both halves, in their own frames, at the middle of the groove
        at_groove = np.eye(6)
        at_groove[3, 1], at_groove[4, 0] = -self.arm_mm, self.arm_mm
        halves = np.stack([at_groove, MIRRORED[:, np.newaxis] * at_groove])
        found[:2, :, :2] = np.einsum("hxa,x,kxb->hakb", halves, own, halves)
        if self.groove is not None:
            found[[0, 1], :, [0, 1]] += self.groove
            found[1, 5, 1, 5] = self.twist_rad_per_Nmm
        return found

    def play(self, pairing: TrainPairing) -> Floats:
        """(B, 2) Displacements of the bodies in their clearances: none."""
        return np.zeros((len(pairing.tables), 2))

    def motions(self, pairing: TrainPairing) -> tuple[Motion, ...]:
        """Rotation of body 1 or of its halves, of an idler, displacement of a floating gear."""
        if pairing.is_double_helical:
            return (Motion(0), Motion(1)) if self.floating else (Motion(0, last=1),)
        idler = (Motion(pairing.common, sign=-1),) if pairing.is_idler else ()
        moving = (Motion(pairing.common, "x"),) if self.floating else ()
        return (Motion(0), *idler, *moving)

    def loads(self, pairing: TrainPairing, torques_Nmm: Floats) -> Floats:
        """(T, q) Loads of the motions."""
        motions = self.motions(pairing)
        halves = len(motions) if pairing.is_double_helical else 1
        return np.outer(torques_Nmm, np.arange(len(motions)) < halves) / halves


@dataclass(frozen=True)
class TrainErrors:
    """Rotations of the bodies of a train from their places.

    Attributes
    ----------
    turned_rad : (B,) array
        Counter-clockwise.
    """

    turned_rad: Floats

    def thickness(self, body: int) -> float:
        """Excess of the thickness of teeth: none."""
        return 0.0

    def tilt(self, body: int) -> None:
        """Tilt of a body: none."""

    def displacements(self, pairing: TrainPairing, position_rad: Floats) -> Floats:
        """(P, B, 3) Displacements x, y (mm) and rotation of each body."""
        found = np.zeros((position_rad.size, self.turned_rad.size, 3))
        found[..., 2] = self.turned_rad
        return found
