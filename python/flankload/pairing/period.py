"""After how much turning of body 1 all repeats."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import lcm, pi
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.bodies.body import Body


@dataclass(frozen=True)
class Period:
    """What positions repeat after.

    Attributes
    ----------
    pitch_rad : float
        After this turn of body 1 the next tooth stands where one stood: one tooth pitch.
    pitches : int
        After so many pitches teeth alike meet again: 1 where all teeth of a body are alike; where
        they are not, the number of them, or of the least group that repeats; of two such bodies the
        least common multiple. Teeth are alike that stand alike, rub alike and, where that is said,
        yield alike.
    """

    pitch_rad: float
    pitches: int = 1

    @property
    def rad(self) -> float:
        """Turn of body 1 after which all repeats."""
        return self.pitches * self.pitch_rad

    def with_compliance(self, groups: tuple[int, int]) -> Period:
        """The same of bodies whose compliances repeat after so many teeth."""
        return replace(self, pitches=lcm(self.pitches, *groups))


def period_of(body_1: Body, body_2: Body, *, by_tooth: tuple[float, ...] = ()) -> Period:
    """Period of a pair.

    Parameters
    ----------
    body_1, body_2 : Body
    by_tooth : tuple of float
        What else differs between the teeth of body 1 (friction), one number for each.

    Returns
    -------
    Period
    """
    return Period(
        pitch_rad=2 * pi / body_1.teeth,
        pitches=lcm(_teeth_until_alike(body_1, by_tooth), _teeth_until_alike(body_2)),
    )


def _teeth_until_alike(body: Body, by_tooth: tuple[float, ...] = ()) -> int:
    """Teeth after which the places of the flanks, and another number, repeat around a body."""
    places = np.zeros((3, body.teeth))
    if by_tooth:
        places[2] = by_tooth
    if body.pitch_errors_um:
        places[0] = body.pitch_errors_um
    if body.flank_turns_rad:
        places[1] = body.flank_turns_rad
    return next(
        group
        for group in range(1, body.teeth + 1)
        if body.teeth % group == 0 and np.array_equal(np.roll(places, group, axis=1), places)
    )
