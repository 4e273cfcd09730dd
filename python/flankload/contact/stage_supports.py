"""How the members of a planetary stage are held: motions without springs, and springs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.base.rotation import directions
from flankload.contact.meshes import Motion
from flankload.contact.meshes_contact import MeshesContact
from flankload.pairing.stage import StagePairing

if TYPE_CHECKING:
    from flankload.base.arrays import Floats

Floating = Literal["none", "sun", "ring", "carrier"]
#: Stiffness along or about two axes, if any.
Pair = tuple[float, float] | None


@dataclass(frozen=True)
class StageSupports:
    """How the members of a stage are held.

    Attributes
    ----------
    floating : str
        The member that is free to move in the plane.
    ring_free : bool
        Whether the rim of the ring bends freely, so that the ring floats, too.
    pin_N_per_mm : (float, float) or None
        Radial and tangential stiffness of each pin; None if they are rigid.
    sun_N_per_mm : float or None
        Radial stiffness of the support of a floating sun, if it has one.
    sun_load_N : (float, float)
        Weight of the sun in x and y.
    tilt_Nmm_per_rad : three (float, float) or None
        Tilting stiffness of sun, pins and ring about their radial and tangential axes (x and y of
        sun and ring); None if they do not tilt.
    carrier : (n, 6, n, 6) array or None
        Motions of the pins in an elastic carrier under forces and moments on all of them.
    play_mm : tuple of n float
        Largest displacement of each planet on its pin from the middle; empty without clearance.
    """

    floating: Floating = "none"
    ring_free: bool = False
    pin_N_per_mm: tuple[float, float] | None = None
    sun_N_per_mm: float | None = None
    sun_load_N: tuple[float, float] = (0.0, 0.0)
    tilt_Nmm_per_rad: tuple[Pair, Pair, Pair] = (None, None, None)
    carrier: Floats | None = None
    play_mm: tuple[float, ...] = ()

    def carried(self, pairing: StagePairing) -> range:
        """The planets on an elastic carrier."""
        return range(1, 1 + (0 if self.carrier is None else len(self.carrier)))

    def turn_rad(self, pairing: StagePairing) -> float:
        """Angle from the frame of the motions to that of the carrier: none."""
        return 0.0

    def compliances(self, pairing: StagePairing) -> Floats:
        """(n + 2, 6, n + 2, 6) Motions of sun, planets, ring on springs by forces and moments.

        mm and rad per N and N mm in the frame of the carrier, of the section in the middle of each
        width.
        """
        radial_N_per_mm = self.sun_N_per_mm
        sun = None if radial_N_per_mm is None else (radial_N_per_mm, radial_N_per_mm)
        of_sun, of_pins, of_ring = self.tilt_Nmm_per_rad
        planets = [_on_springs(self.pin_N_per_mm, of_pins, angle) for angle in pairing.angles_rad]
        own = [_on_springs(sun, of_sun), *planets, _on_springs(None, of_ring)]
        found = np.zeros((len(own), 6, len(own), 6))
        for b, compliance in enumerate(own):
            found[b, :, b] = compliance
        if self.carrier is not None:
            found[1:-1, :, 1:-1] += self.carrier
        return found

    def play(self, pairing: StagePairing) -> Floats:
        """(n + 2, 2) Displacements of the bodies in their clearances, along the normal forces."""
        found = np.zeros((pairing.count + 2, 2))
        if any(self.play_mm):
            both = -pairing.rows((1.0, 1.0, 1.0))[:, 1:-1, :2].sum(axis=0)
            along = both / np.hypot(*both.T)[:, np.newaxis]
            found[1:-1] = np.array(self.play_mm)[:, np.newaxis] * along
        return found

    def motions(self, pairing: StagePairing) -> tuple[Motion, ...]:
        """Rotations of the sun and of the planets, clockwise, then those of a floating member."""
        count = pairing.count
        turning = [Motion(0), *(Motion(1 + j, sign=-1) for j in range(count))]
        bodies = {"sun": (0, 0), "carrier": (1, count), "ring": (1 + count, 1 + count)}
        member = self.moving
        if member is None:
            return tuple(turning)
        body, last = bodies[member]
        return (*turning, Motion(body, "x", last=last), Motion(body, "y", last=last))

    @property
    def moving(self) -> Literal["sun", "ring", "carrier"] | None:
        """The member that moves in the plane without springs."""
        if self.ring_free:
            return "ring"
        if self.floating == "none" or (self.floating == "sun" and self.sun_N_per_mm is not None):
            return None
        return self.floating

    def loads(self, pairing: StagePairing, torques_Nmm: Floats) -> Floats:
        """(T, q) Loads of the motions."""
        found = np.zeros((torques_Nmm.size, len(self.motions(pairing))))
        found[:, 0] = torques_Nmm
        if self.moving == "sun":
            found[:, 1 + pairing.count :] = self.sun_load_N
        return found


StageContact = MeshesContact[StagePairing, StageSupports]


def _on_springs(radial: Pair, tilting: Pair, angle_rad: float = 0.0) -> Floats:
    """(6, 6) Compliance of springs along two axes at an angle, and about them."""
    found, axes = np.zeros((6, 6)), directions(np.array([angle_rad, angle_rad + 0.5 * np.pi]))
    for first, stiffness in ((0, radial), (3, tilting)):
        if stiffness is not None:
            moved = axes.T @ np.diag(1.0 / np.array(stiffness)) @ axes
            found[first : first + 2, first : first + 2] = 0.5 * (moved + moved.T)
    return found
