"""Unit loads as forces at the nodes of a flank; their response includes the near field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.bodies.body import WholeMesh
from flankload.elasticity.compliance.parts import NearField
from flankload.elasticity.near_field import logarithm_strength
from flankload.elasticity.nodal_loads import nodes_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from flankload.bodies.body import Body
    from flankload.cost import Account

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NodeLoads:
    """Unit forces at nodes; with friction followed by as many along the flank.

    Attributes
    ----------
    nodes : (n,) array
        Arc lengths, mm.
    plane : {"strain", "stress"}
    """

    body: Body
    nodes: Floats
    plane: str

    #: The flank has no tip modes.
    tip = None

    @property
    def count(self) -> int:
        """Number of nodes of a flank."""
        return self.nodes.size

    @property
    def near_field(self) -> NearField:
        """Only the strength of the logarithm, for the expected width of contacts."""
        return NearField(logarithm_strength(self.body.material, self.plane))

    def settle(
        self,
        response: Floats,
        own: NDArray[np.int64],
        account: Account,
    ) -> None:
        """Count the unit forces; the response is left as it is (see `ModeLoads.settle`)."""
        mesh = self.body.mesh
        flanks = len(mesh.flanks) if isinstance(mesh, WholeMesh) else 1
        account.count(unit_loads_nodal=response.shape[2] * flanks)


def node_loads(body: Body, plane: str) -> NodeLoads:
    """Unit forces at the nodes of the elements of a body.

    Parameters
    ----------
    body : Body
        With a mesh.
    plane : {"strain", "stress"}
    """
    assert body.mesh is not None
    return NodeLoads(body, nodes_of(body.mesh), plane)
