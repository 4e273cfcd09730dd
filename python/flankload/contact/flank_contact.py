"""Two bodies in contact at their flanks: the input of a sweep."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from flankload.pairing.slices import PLANE

if TYPE_CHECKING:
    from flankload.bodies.body import Body
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.friction import Friction
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices
    from flankload.scene.discretization import Grid

#: Contact on cells, or one unknown per place of contact.
Level = Literal["pairs", "lumped"]


@dataclass(frozen=True)
class FlankContact:
    """Two bodies whose flanks can touch, and the model of their contact.

    Attributes
    ----------
    bodies, compliances, pairing
        From the previous stages. With slices, compliances are those of the whole width in mm/N,
        with modes that are products with Legendre polynomials over the width.
    face_width_mm : float
        Width over which both bodies are in contact.
    grid : Grid
        Cell sizes.
    level : str
        "pairs": contact pairs on cells. "lumped": one unknown per place of contact, with the width
        of a Hertz contact, and one pair in the table, whose cell width is force over largest
        pressure (π/2 half-widths). Not for conforming flanks.
    friction : Friction or None
        Friction of the flanks; it requires compliances with tangential parts.
    finite_steps : int
        Number of force steps for influence coefficients of finite forces; 0: small forces. Finite
        forces require compliances with `tangential`, with friction also `along`.
    slices : Slices or None
        Slices of the face width for contact in three dimensions.
    """

    bodies: tuple[Body, Body]
    compliances: tuple[BodyCompliance, BodyCompliance]
    pairing: Pairing
    face_width_mm: float
    grid: Grid
    level: Level = "pairs"
    friction: Friction | None = None
    finite_steps: int = 0
    slices: Slices | None = None

    @property
    def sections(self) -> Slices:
        """The slices; in the plane a single one."""
        return PLANE if self.slices is None else self.slices

    @property
    def conforms(self) -> bool:
        """Whether flanks in slices conform over a common height."""
        return self.sections.conforming is not None
