"""Two bodies in contact at their flanks: the input of a sweep."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from flankload.contact.body_record import records_of

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.scene.discretization import Grid

#: Contact on cells, or one unknown per place of contact.
Level = Literal["pairs", "lumped"]


@dataclass(frozen=True)
class FlankContact:
    """Two bodies whose flanks can touch, and the model of their contact.

    Attributes
    ----------
    mesh : GearMesh
    compliances : (BodyCompliance, BodyCompliance)
        Per width in the plane. With slices, of the whole width in mm/N, with modes that are
        products with Legendre polynomials over the width. Friction requires tangential parts.
    grid : Grid
        Cell sizes.
    level : str
        "pairs": contact pairs on cells. "lumped": one unknown per place of contact, with the width
        of a Hertz contact, and one pair in the table, whose cell width is force over largest
        pressure (π/2 half-widths). Not for conforming flanks.
    finite_steps : int
        Number of force steps for influence coefficients of finite forces; 0: small forces. Finite
        forces require compliances with `tangential`, with friction also `along`.
    """

    mesh: GearMesh
    compliances: tuple[BodyCompliance, BodyCompliance]
    grid: Grid
    level: Level = "pairs"
    finite_steps: int = 0

    @cached_property
    def records(self) -> tuple[Floats, ...]:
        """Records (n,) of the mesh and of both bodies, which all sweeps share."""
        return records_of(self)
