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
    names : (str, str)
        Tables of the bodies in the scene, such as "body_1".
    bodies : (Body, Body)
    pairing : Pairing
    face_width_mm : float
        Common face width.
    friction : Friction or None
        None if the scene has no friction.
    slices : Slices or None
        Slices of the common face width of three-dimensional bodies.
    """

    names: tuple[str, str]
    bodies: tuple[Body, Body]
    pairing: Pairing
    face_width_mm: float
    friction: Friction | None = None
    slices: Slices | None = None

    @property
    def loaded_width_mm(self) -> float:
        """Width that carries the load: of all slices, which expand with the bodies."""
        return self.face_width_mm if self.slices is None else float(self.slices.width_mm.sum())
