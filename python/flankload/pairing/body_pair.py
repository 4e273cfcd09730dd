"""Both bodies of a scene and how they stand to each other, before elements are solved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.bodies.root_fillet import RootFillets
    from flankload.pairing.expansion import Growth
    from flankload.pairing.friction import Friction
    from flankload.pairing.pairing import Pairing
    from flankload.scene.discretization import Discretization
    from flankload.scene.effects import Effects


@dataclass(frozen=True)
class BodyPair:
    """Both bodies and how they stand to each other.

    Attributes
    ----------
    body_1, body_2 : Body
    pairing : Pairing
    discretization : Discretization
    effects : Effects
    position_rad : (P,) array
        Angles of body 1 from position zero; of adaptive positions those to begin with.
    pitches : int or None
        Tooth pitches that the positions run over; None where they are single angles.
    closed : bool
        All repeats after them (with pitch errors one tooth pitch is no period).
    adaptive : bool
        More positions are looked for.
    notes : tuple of str
        What a user must know of bodies and pair.
    friction : Friction or None
        None where the scene has no friction.
    fillets : two RootFillets or None
        Where stress is asked for.
    growth : two Growth or None
        What makes the bodies grow.
    standing_note : str or None
        How far apart flanks stand whose place their files give.
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
    growth: tuple[Growth | None, Growth | None] = (None, None)
    standing_note: str | None = None

    @property
    def period_rad(self) -> float:
        """Period of the curves: what the positions run over, where all repeats after it."""
        if self.closed and self.pitches is not None:
            return self.pitches * self.pairing.pitch_rad
        return self.pairing.period_rad

    @property
    def turn_1(self) -> float:
        """Turn of body 1's frame at position zero, rad."""
        return self.pairing.turns_at_zero_rad[0]

    @property
    def turn_2(self) -> float:
        """Turn of body 2's frame at position zero, rad."""
        return self.pairing.turns_at_zero_rad[1]
