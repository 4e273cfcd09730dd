"""An involute flank, its angles (DIN 3960) and its modifications normal to the involute.

With the base radius r_b, half the tooth angle at the base circle th0 and the roll parameter t,

    P(t) = r_b e_r(th0 - t) + (r_b t - delta(t)) e_theta(th0 - t),

where delta is the material removed along the normal of the involute, e_theta(th0 - t).

The space of a ring has the shape of such a tooth: th0 is half the angle of the space, and material
removed is a negative delta.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan, atan2, sqrt
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.bodies.plane import across

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


@dataclass(frozen=True)
class Involute:
    """Radii and angles of a gear's flank.

    Attributes
    ----------
    base_radius_mm, reference_radius_mm, root_radius_mm, tip_radius_mm : float
    form_radius_mm : float
        Radius at which the involute begins, above the root fillet.
    base_half_angle_rad : float
        Half the angle between the two involutes at the base circle: of a tooth, or of the space of
        a ring.
    turn_rad : float
        Polar angle of the centre line of tooth or space in the frame of the body.
    outward : int
        1: the radius increases from root to tip; -1: it decreases, as in a ring.
    tooth_center_rad : float
        Angle from that centre line to the centre of the tooth: 0, or half a pitch for a ring.
    """

    base_radius_mm: float
    reference_radius_mm: float
    root_radius_mm: float
    form_radius_mm: float
    tip_radius_mm: float
    base_half_angle_rad: float
    turn_rad: float = 0.0
    outward: int = 1
    tooth_center_rad: float = 0.0

    def roll_at(self, radius_mm: float) -> float:
        """Roll parameter t (tan of the pressure angle) at a radius; 0 inside the base circle."""
        return sqrt(max(0.0, (radius_mm / self.base_radius_mm) ** 2 - 1.0))

    def half_angle_at(self, radius_mm: float) -> float:
        """Half the angle between the involutes at a radius, rad; negative beyond their meeting."""
        roll = self.roll_at(radius_mm)
        return self.base_half_angle_rad - roll + atan(roll)

    def tooth_half_angle_at(self, radius_mm: float) -> float:
        """Half the angle of a tooth at a radius, rad; negative beyond its pointed tip."""
        return self.outward * (self.half_angle_at(radius_mm) - self.tooth_center_rad)

    def polar_angle_at(self, radius_mm: float) -> float:
        """Polar angle of the working flank at a radius in the frame of the body, rad."""
        return self.turn_rad + self.half_angle_at(radius_mm)


@dataclass(frozen=True)
class Modifications:
    """Material removed along the normal of the involute, as a function of the roll parameter.

    Attributes
    ----------
    tip_relief_mm : float
        Amount at the tip circle; negative for a ring.
    relief_start : float
        Roll parameter at which the relief begins.
    relief_exponent : int
        Exponent of the distance from there (`RELIEF_EXPONENTS`).
    crowning_mm : float
        Parabola over the roll parameter: 0 in the middle of the flank, this amount at both ends;
        negative for a ring.
    roll_form, roll_tip : float
        Roll parameters at the ends of the flank: form circle and tip circle.
    knee_mm, knee_roll : float
        Amount and roll parameter at the knee of a double-linear tip relief.
    root_relief_mm, root_start, root_exponent : float, float, int
        As of the tip relief, with the amount at the form circle.
    """

    tip_relief_mm: float
    relief_start: float
    relief_exponent: int
    crowning_mm: float
    roll_form: float
    roll_tip: float
    knee_mm: float = 0.0
    knee_roll: float | None = None
    root_relief_mm: float = 0.0
    root_start: float = 0.0
    root_exponent: int = 1

    @classmethod
    def none(cls) -> Modifications:
        """No material removed."""
        return cls(0.0, 0.0, 1, 0.0, 0.0, 1.0)

    def at(self, roll: Floats) -> tuple[Floats, Floats, Floats]:
        """Material removed at roll parameters (m,), mm, and its first two derivatives."""
        half = 0.5 * (self.roll_tip - self.roll_form)
        x = (roll - 0.5 * (self.roll_tip + self.roll_form)) / half
        off = self.crowning_mm * x**2
        first = 2 * self.crowning_mm * x / half
        second = np.full_like(roll, 2 * self.crowning_mm / half**2)
        for part in self._reliefs:
            off, first, second = _add_relief(roll, part, (off, first, second))
        return off, first, second

    @property
    def before_knee(self) -> Modifications:
        """The first part of a double-linear tip relief, continued to the tip."""
        if self.knee_roll is None:
            return self
        whole = self.roll_tip - self.relief_start
        amount = self.knee_mm * whole / (self.knee_roll - self.relief_start)
        return replace(self, tip_relief_mm=amount, knee_roll=None)

    @property
    def _reliefs(self) -> list[tuple[float, float, float, int]]:
        """Amount, roll parameters at start and end, and exponent of each relief.

        A double-linear relief is the sum of two lines, from its start and from its knee.
        """
        parts = []
        if self.tip_relief_mm:
            amount = self.before_knee.tip_relief_mm
            if self.knee_roll is not None:
                parts.append((self.tip_relief_mm - amount, self.knee_roll, self.roll_tip, 1))
            parts.append((amount, self.relief_start, self.roll_tip, self.relief_exponent))
        if self.root_relief_mm:
            ends = (self.root_start, self.roll_form)
            parts.append((self.root_relief_mm, *ends, self.root_exponent))
        return parts


def _add_relief(
    roll: Floats, relief: tuple[float, float, float, int], before: tuple[Floats, Floats, Floats]
) -> tuple[Floats, Floats, Floats]:
    """Add amount x^n with x = (roll - start)/(end - start), and its first two derivatives."""
    amount, start, end, n = relief
    off, first, second = before
    span = end - start
    x = np.maximum((roll - start) / span, 0.0)
    inside = (roll - start) * span >= 0.0
    return (
        off + amount * x**n,
        first + inside * (amount * n * x ** (n - 1) / span),
        second + inside * (amount * n * (n - 1) / span**2),
    )


@dataclass(frozen=True)
class InvoluteFlank:
    """The flank as a parametric curve.

    Attributes
    ----------
    base_radius_mm, base_half_angle_rad : float
    modifications : Modifications
    """

    base_radius_mm: float
    base_half_angle_rad: float
    modifications: Modifications

    def place(self, roll: Floats) -> tuple[Floats, Floats, Floats]:
        """Points (m, 2) at roll parameters (m,), mm, and their first two derivatives."""
        roll = np.atleast_1d(np.asarray(roll, dtype=float))
        off, first, second = (part[:, None] for part in self.modifications.at(roll))
        angle = self.base_half_angle_rad - roll
        radial = directions(angle)
        normal = across(radial)
        base = self.base_radius_mm
        reach = base * roll[:, None] - off
        # d e_r/dt = -e_theta, d e_theta/dt = e_r at the angle th0 - t
        return (
            base * radial + reach * normal,
            reach * radial - first * normal,
            (base - 2 * first) * radial - (reach + second) * normal,
        )

    def normal(self, roll: float) -> Floats:
        """Unit normal (2,) at a roll parameter, pointing out of the tooth, or space of a ring."""
        _, first, _ = self.place(np.array([roll]))
        tangent = first[0] / np.linalg.norm(first[0])
        return np.array([-tangent[1], tangent[0]])

    def point(self, roll: float) -> Floats:
        """Point (2,) at a roll parameter, mm."""
        return self.place(np.array([roll]))[0][0]

    def roll_at(self, radius_mm: float) -> float:
        """Roll parameter at a distance from the axis, at least the base radius."""
        reach = sqrt(max(0.0, (radius_mm / self.base_radius_mm) ** 2 - 1.0))
        roll = reach
        for _ in range(60):
            off, first, _ = (float(part[0]) for part in self.modifications.at(np.array([roll])))
            miss = roll - off / self.base_radius_mm - reach
            roll -= miss / (1.0 - first / self.base_radius_mm)
            if abs(miss) <= 1e-15 * max(1.0, reach):
                break
        return roll

    def polar_angle_at(self, radius_mm: float) -> float:
        """Polar angle from the centre line at a distance from the axis, rad."""
        place = self.point(self.roll_at(radius_mm))
        return atan2(place[1], place[0])
