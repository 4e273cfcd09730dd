"""The involute function, and pairs of involutes at their centre distance (DIN 3960).

External and internal pairs have the same equations with a sense s = 1 (external teeth of body 2) or
-1 (internal teeth).
"""

from __future__ import annotations

from math import atan, hypot, sqrt, tan

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


def distance_of_backlash(
    base_radii_mm: tuple[float, float],
    half_angles_rad: tuple[float, float],
    base_pitch_mm: float,
    sense: int,
    backlash_mm: float = 0.0,
) -> float | None:
    """Centre distance of a pair with a backlash along the base tangent, mm; None if there is none.

    The teeth and the backlash fill the pitch on the working circles r_b/cos(alpha_w): the sum over
    both bodies of s r_b (half angle of the tooth at the base circle - inv(alpha_w)) is half of the
    base pitch without the backlash. The half angle of an internal tooth is that of its space less
    half a pitch.
    """
    radii = (base_radii_mm[0], sense * base_radii_mm[1])
    filled = sum(radius * half for radius, half in zip(radii, half_angles_rad, strict=True))
    value = (filled - 0.5 * (base_pitch_mm - backlash_mm)) / sum(radii)
    return abs(sum(radii)) * hypot(1.0, roll_of_involute_angle(value)) if value > 0.0 else None


def ends_of_path(
    base_radii_mm: tuple[float, float],
    tip_radii_mm: tuple[float, float],
    pressure_angle_rad: float,
    sense: int,
) -> tuple[float, float]:
    """Ends of the path of contact between the tip circles, mm.

    Measured from the pitch point in the direction of motion; the angle is the working one.
    """
    at_pitch_point = [radius * tan(pressure_angle_rad) for radius in base_radii_mm]
    at_tip = [
        sqrt(max(0.0, tip**2 - base**2))
        for tip, base in zip(tip_radii_mm, base_radii_mm, strict=True)
    ]
    return sense * (at_pitch_point[1] - at_tip[1]), at_tip[0] - at_pitch_point[0]
