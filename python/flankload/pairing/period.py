"""Period of a pair: the rotation of body 1 after which everything repeats."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import lcm, pi
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.bodies.body import Body


@dataclass(frozen=True)
class Period:
    """Period of the positions.

    Attributes
    ----------
    pitch_rad : float
        One tooth pitch of body 1: after it the next tooth has the place of the previous one.
    pitches : int
        Number of pitches after which equal teeth meet again: 1 if all teeth of each body are
        equal; otherwise the number of teeth, or the size of the smallest group that repeats; for
        two such bodies the least common multiple. Teeth are equal if they have equal deviations,
        equal friction and, where it is known, equal compliance.
    """

    pitch_rad: float
    pitches: int = 1

    @property
    def rad(self) -> float:
        """Rotation of body 1 after which everything repeats, rad."""
        return self.pitches * self.pitch_rad

    def with_compliance(self, groups: tuple[int, int]) -> Period:
        """The period for bodies whose compliances repeat after the given numbers of teeth."""
        return replace(self, pitches=lcm(self.pitches, *groups))


def period_of(body_1: Body, body_2: Body, *, by_tooth: tuple[float, ...] = ()) -> Period:
    """Period of a pair; `by_tooth` is another property of each tooth of body 1 (friction)."""
    return Period(
        pitch_rad=2 * pi / body_1.teeth,
        pitches=lcm(_teeth_until_alike(body_1, by_tooth), _teeth_until_alike(body_2)),
    )


def _teeth_until_alike(body: Body, by_tooth: tuple[float, ...] = ()) -> int:
    """Teeth after which the flanks' places, and another property, repeat around a body."""
    places = np.zeros((4, body.teeth))
    if by_tooth:
        places[2] = by_tooth
    if body.pitch_errors_um:
        places[0] = body.pitch_errors_um
    if body.flank_turns_rad:
        places[1] = body.flank_turns_rad
    if body.axial is not None and body.axial.tooth_slopes_mm:
        places[3] = body.axial.tooth_slopes_mm
    return next(
        group
        for group in range(1, body.teeth + 1)
        if body.teeth % group == 0 and np.array_equal(np.roll(places, group, axis=1), places)
    )
