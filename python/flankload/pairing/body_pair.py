"""The assembly of two bodies with the options of a run, before finite elements."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.bodies.root_fillet import RootFillets
    from flankload.pairing.expansion import BodyLoad
    from flankload.pairing.friction import Friction
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices
    from flankload.scene.discretization import Discretization
    from flankload.scene.effects import Effects


@dataclass(frozen=True)
class BodyJob:
    """Purposes for which the elements of a body are solved.

    Attributes
    ----------
    elastic : bool
        Whether the body is elastic under contact forces.
    fillets : RootFillets or None
        Root fillets, if their stress is requested.
    body_load : BodyLoad or None
        Causes of thermal and centrifugal expansion, if any.
    coast_flanks : bool
        Whether coast flanks carry load as well.
    """

    elastic: bool
    fillets: RootFillets | None = None
    body_load: BodyLoad | None = None
    coast_flanks: bool = False

    @property
    def needs_elements(self) -> bool:
        """Whether elements are solved for any purpose."""
        return self.elastic or (self.body_load is not None and self.body_load.needs_elements)


@dataclass(frozen=True)
class BodyPair:
    """Two bodies with their relative position and the options of the run.

    Attributes
    ----------
    mesh : GearMesh
    jobs : (BodyJob, BodyJob)
    discretization : Discretization
    effects : Effects
    position_rad : (P,) array
        Angles of body 1 from position zero; for adaptive positions, the initial ones.
    pitches : int or None
        Tooth pitches that the positions cover; None for explicit angles.
    closed : bool
        The positions cover a whole period, which with pitch errors is longer than a tooth pitch.
    adaptive : bool
        Positions are added adaptively.
    notes : tuple of str
        Remarks on the bodies and the pair for the user.
    flank_distance_note : str or None
        Note on the distance of flanks whose angles follow from files.
    """

    mesh: GearMesh
    jobs: tuple[BodyJob, BodyJob]
    discretization: Discretization
    effects: Effects
    position_rad: NDArray[np.float64]
    pitches: int | None
    closed: bool
    adaptive: bool
    notes: tuple[str, ...]
    flank_distance_note: str | None = None

    @property
    def meshes(self) -> tuple[GearMesh, ...]:
        """The only contact of two bodies."""
        return (self.mesh,)

    @property
    def names(self) -> tuple[str, str]:
        """Tables of both bodies in the scene."""
        return self.mesh.names

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Both bodies."""
        return self.mesh.bodies

    @property
    def body_1(self) -> Body:
        """The body that the torque turns."""
        return self.mesh.bodies[0]

    @property
    def body_2(self) -> Body:
        """The body at rest."""
        return self.mesh.bodies[1]

    @property
    def pairing(self) -> Pairing:
        """Relative position of both bodies."""
        return self.mesh.pairing

    @property
    def face_width_mm(self) -> float:
        """Common face width."""
        return self.mesh.face_width_mm

    @property
    def friction(self) -> Friction | None:
        """Friction of the flanks."""
        return self.mesh.friction

    @property
    def slices(self) -> Slices | None:
        """Slices of the common face width of three-dimensional bodies."""
        return self.mesh.slices

    def with_mesh(self, **changes: Any) -> BodyPair:
        """The pair with other values of fields of its mesh."""
        return replace(self, mesh=replace(self.mesh, **changes))

    @property
    def period_rad(self) -> float:
        """Period of the curves, rad: the range of the positions if it is a whole period."""
        if self.closed and self.pitches is not None:
            return self.pitches * self.pairing.pitch_rad
        return self.pairing.period_rad
