"""Two bodies that touch: where their axes and teeth are, and what their contact has in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flankload.bodies import Body
    from flankload.pairing.friction import Friction
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices


@dataclass(frozen=True)
class GearMesh:
    """Two bodies that touch on their flanks.

    Attributes
    ----------
    bodies : (Body, Body)
    pairing : Pairing
    slices : Slices
        Slices of the common face width; a single one in the plane.
    friction : Friction or None
        None if the scene has no friction.
    names : (str, str)
        Tables of the bodies in the scene.
    """

    bodies: tuple[Body, Body]
    pairing: Pairing
    slices: Slices
    friction: Friction | None = None
    names: tuple[str, str] = ("body_1", "body_2")

    @property
    def body_1(self) -> Body:
        """The body that drives the other one."""
        return self.bodies[0]

    @property
    def body_2(self) -> Body:
        """The driven body."""
        return self.bodies[1]

    @property
    def face_width_mm(self) -> float:
        """Width that carries the load: of all slices, which expand with the bodies."""
        return float(self.slices.width_mm.sum())
