"""The assembly of two bodies with the options of a run, before finite elements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.pairing.gear_mesh import GearMesh

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from flankload.bodies.root_fillet import RootFillets
    from flankload.pairing.expansion import BodyLoad
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
    rim : bool
        Whether displacements of a free rim are needed.
    mirrored : bool
        Whether the mirror image of the body is solved, in which its coast flanks are working ones.
    turns : bool
        Whether forces turn over sharp tips of the bodies that touch.
    """

    elastic: bool
    fillets: RootFillets | None = None
    body_load: BodyLoad | None = None
    coast_flanks: bool = False
    rim: bool = False
    mirrored: bool = False
    turns: bool = False

    @property
    def needs_elements(self) -> bool:
        """Whether elements are solved for any purpose."""
        return self.elastic or (self.body_load is not None and self.body_load.needs_elements)


@dataclass(frozen=True, kw_only=True)
class BodyPair(GearMesh):
    """The gear mesh of two bodies, of which body 1 carries the torque, and the options of the run.

    Attributes
    ----------
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
        return (self,)

    @property
    def period_rad(self) -> float:
        """Period of the curves, rad: the range of the positions if it is a whole period."""
        if self.closed and self.pitches is not None:
            return self.pitches * self.pairing.pitch_rad
        return self.pairing.period_rad
