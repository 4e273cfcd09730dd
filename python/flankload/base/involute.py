"""The involute function and its inverse (DIN 3960), and the tolerance of base pitches."""

from __future__ import annotations

from math import atan, tan

#: Largest relative difference of the base pitches of two gears that mesh.
PITCH_TOLERANCE = 1e-6


def involute_function(angle: float) -> float:
    """Involute function: inv(angle) = tan(angle) - angle, rad."""
    return tan(angle) - angle


def roll_of_involute_angle(value: float) -> float:
    """Roll parameter t >= 0 with t - atan(t) = value (inverse of the involute function)."""
    roll = (3.0 * value) ** (1.0 / 3.0) if value < 1.8 else value + 1.5
    for _ in range(60):
        if roll == 0.0:
            return 0.0
        # Newton's method: d/dt (t - atan t) = t²/(1 + t²)
        step = (roll - atan(roll) - value) * (1.0 + roll**2) / roll**2
        roll -= step
        if abs(step) <= 1e-15 * roll:
            break
    return roll
