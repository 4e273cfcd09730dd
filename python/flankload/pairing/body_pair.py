"""The two bodies of a scene with their pairing and options, before finite elements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.bodies.root_fillet import RootFillets
    from flankload.pairing.expansion import BodyLoad
    from flankload.pairing.friction import Friction
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices
    from flankload.scene.discretization import Discretization
    from flankload.scene.effects import Effects


@dataclass(frozen=True)
class BodyPair:
    """Two bodies with their relative position and the options of the run.

    Attributes
    ----------
    body_1, body_2 : Body
    pairing : Pairing
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
    friction : Friction or None
        None if the scene has no friction.
    fillets : two RootFillets or None
        Root fillets of both bodies, if the root stress is requested.
    body_loads : two BodyLoad or None
        Causes of thermal and centrifugal expansion of both bodies, if any.
    flank_distance_note : str or None
        Note on the distance of flanks whose angles follow from files.
    slices : Slices or None
        Slices of the common face width of three-dimensional bodies.
    """

    body_1: Body
    body_2: Body
    pairing: Pairing
    discretization: Discretization
    effects: Effects
    position_rad: NDArray[np.float64]
    pitches: int | None
    closed: bool
    adaptive: bool
    notes: tuple[str, ...]
    friction: Friction | None = None
    fillets: tuple[RootFillets | None, RootFillets | None] = (None, None)
    body_loads: tuple[BodyLoad | None, BodyLoad | None] = (None, None)
    flank_distance_note: str | None = None
    slices: Slices | None = None

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Both bodies."""
        return self.body_1, self.body_2

    @property
    def elastic(self) -> tuple[bool, bool]:
        """Whether each body is elastic."""
        return self.effects.elastic_body_1, self.effects.elastic_body_2

    @property
    def period_rad(self) -> float:
        """Period of the curves, rad: the range of the positions if it is a whole period."""
        if self.closed and self.pitches is not None:
            return self.pitches * self.pairing.pitch_rad
        return self.pairing.period_rad

    @property
    def turn_1(self) -> float:
        """Angle of body 1's frame at position zero, rad."""
        return self.pairing.turns_at_zero_rad[0]

    @property
    def turn_2(self) -> float:
        """Angle of body 2's frame at position zero, rad."""
        return self.pairing.turns_at_zero_rad[1]
